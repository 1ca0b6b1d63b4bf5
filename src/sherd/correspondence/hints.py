"""What the user knows, brought into the shapes of the question: landmarks, ignored vertices."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Ints
from sherd.correspondence.question import Pins
from sherd.errors import InfeasibleError, OptionError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.match_options import MatchOptions
from sherd.scan.intake import Intake
from sherd.scan.numbering import repaired_vertices
from sherd.surface.described import DescribedSurface
from sherd.surface.template import Template

__all__ = ["check_hints", "landmark_pairs", "pins_of", "without_ignored", "working_pins"]


def check_hints(full: Intake, part: Intake, options: MatchOptions) -> None:
    """Refuse hints that name vertices which do not exist, and masks of another mesh.

    Raises
    ------
    OptionError
        With the name of the option, the vertex and the range.
    """
    on_part, on_full = landmark_pairs(options).T
    counts = part.original.vertex_count, full.original.vertex_count
    wanted = (
        ("landmarks", "part", counts[0], on_part),
        ("landmarks", "full shape", counts[1], on_full),
        ("ignore", "part", counts[0], np.asarray(options.ignore, dtype=np.int64)),
    )
    for name, shape, count, vertices in wanted:
        if len(vertices) and vertices.max() >= count:
            raise OptionError(
                f"{name} names vertex {vertices.max()} of the {shape}, which has 0..{count - 1}"
            )
    length = getattr(options.ignore, "mask_length", None)
    if length not in (None, counts[0]):
        raise OptionError(
            f"ignore is a mask of {length} values, but the part has {counts[0]} vertices"
        )


def landmark_pairs(options: MatchOptions) -> Ints:
    """(p, 2) vertices of the part and of the full shape that belong together."""
    return np.array(options.landmarks, dtype=np.int64).reshape(-1, 2)


def without_ignored(part: Intake, options: MatchOptions) -> tuple[TriangleMesh, Ints]:
    """The repaired part without faces at ignored vertices, and the old index of each vertex.

    Raises
    ------
    InfeasibleError
        If nothing is left.
    """
    ignored = np.asarray(options.ignore, dtype=np.int64)
    new = part.report.new_vertices[ignored]
    dropped = np.zeros(part.mesh.vertex_count, dtype=bool)
    dropped[new[new >= 0]] = True  # those that repair left out are ignored anyway
    keep = ~dropped[part.mesh.faces].any(axis=1)
    if not keep.any():
        raise InfeasibleError("every face of the part touches an ignored vertex")
    return part.mesh.submesh(keep)


def pins_of(template: Template, part: Intake, kept: Ints, options: MatchOptions) -> Pins:
    """Landmarks as pins on vertices of the kept part.

    Raises
    ------
    InputError
        If a landmark belongs to no face with an area.
    """
    pairs = landmark_pairs(options)
    on_part = repaired_vertices(part, pairs[:, 0], what="landmarks:")
    on_full = repaired_vertices(template.intake, pairs[:, 1], what="landmarks:")
    new = np.full(part.mesh.vertex_count, -1, dtype=np.int64)
    new[kept] = np.arange(len(kept))
    there = new[on_part] >= 0
    return Pins(new[on_part][there], template.placed.vertices[on_full[there]], pairs[there])


def working_pins(part: DescribedSurface, pins: Pins) -> Pins:
    """The same pins on vertices of the part's working mesh, each once."""
    vertices, first = np.unique(part.working.working_vertices(pins.vertices), return_index=True)
    return Pins(vertices, pins.positions[first], pins.landmarks[first])
