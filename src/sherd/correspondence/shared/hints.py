"""What the user knows of two incomplete shapes: landmarks and ignored vertices of both."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sherd.arrays import Bools, Ints
from sherd.correspondence.question import Pins
from sherd.errors import InfeasibleError, OptionError
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.overlap_options import OverlapOptions
from sherd.scan.intake import Intake
from sherd.scan.numbering import nearest_repaired, original_points, repaired_vertices
from sherd.surface.described import DescribedSurface

__all__ = ["KeptShape", "check_overlap_hints", "kept_shape", "landmarks_on", "pins_on"]


@dataclass(frozen=True, eq=False)
class KeptShape:
    """A repaired shape without what is ignored, and the way back to the user's numbering.

    Attributes
    ----------
    intake
        The shape as it came in.
    mesh
        What is asked about.
    vertices, faces
        (k,) and (f,) numbers that its vertices and faces have on the repaired shape.
    """

    intake: Intake
    mesh: TriangleMesh
    vertices: Ints
    faces: Ints

    def kept_vertices(self, originals: Ints, *, what: str) -> Ints:
        """The user's vertices (p,) as vertices of `mesh`, -1 where left out.

        Raises
        ------
        InputError
            If one does not exist or has no face with an area.
        """
        repaired = repaired_vertices(self.intake, originals, what=what)
        new = np.full(self.intake.mesh.vertex_count, -1, dtype=np.int64)
        new[self.vertices] = np.arange(len(self.vertices))
        found: Ints = new[repaired]
        return found

    def to_original_points(self, points: SurfacePoints) -> SurfacePoints:
        """Points of `mesh` as points of the user's shape."""
        moved = SurfacePoints(self.faces[points.faces], points.barycentric)
        return original_points(self.intake, moved)

    def sources(self) -> tuple[Ints, Bools]:
        """For each of the user's vertices the one of `mesh` that answers for it, and if it is it.

        (n,) both; the nearest one answers for what was left out.
        """
        from scipy.spatial import cKDTree  # noqa: PLC0415

        vertices = self.intake.mesh.vertices
        known = np.zeros(len(vertices), dtype=bool)
        known[self.vertices] = True
        source = np.empty(len(vertices), dtype=np.int64)
        source[self.vertices] = np.arange(len(self.vertices))
        if not known.all():
            source[~known] = cKDTree(vertices[self.vertices]).query(vertices[~known])[1]
        nearest = nearest_repaired(self.intake)
        return source[nearest], known[nearest] & (self.intake.report.new_vertices >= 0)


def check_overlap_hints(first: Intake, second: Intake, options: OverlapOptions) -> None:
    """Refuse hints that name vertices which do not exist, and masks of another mesh.

    Raises
    ------
    OptionError
        With the name of the option, the vertex and the range.
    """
    pairs = np.array(options.landmarks, dtype=np.int64).reshape(-1, 2)
    for side, (name, shape) in enumerate((("first", first), ("second", second))):
        count = shape.original.vertex_count
        ignored = getattr(options, f"ignore_{name}")
        for option, vertices in ((f"ignore_{name}", ignored), ("landmarks", pairs[:, side])):
            if len(vertices) and max(vertices) >= count:
                raise OptionError(
                    f"{option} names vertex {max(vertices)} of the {name} shape, which has "
                    f"0..{count - 1}"
                )
        length = getattr(ignored, "mask_length", None)
        if length not in (None, count):
            raise OptionError(
                f"ignore_{name} is a mask of {length} values, but the {name} shape has {count} "
                "vertices"
            )


def kept_shape(intake: Intake, ignored: tuple[int, ...], *, name: str) -> KeptShape:
    """The repaired shape without faces at ignored vertices.

    Raises
    ------
    InfeasibleError
        If nothing is left.
    """
    new = intake.report.new_vertices[np.asarray(ignored, dtype=np.int64)]
    dropped = np.zeros(intake.mesh.vertex_count, dtype=bool)
    dropped[new[new >= 0]] = True  # those that repair left out are ignored anyway
    keep = ~dropped[intake.mesh.faces].any(axis=1)
    if not keep.any():
        raise InfeasibleError(f"every face of the {name} shape touches an ignored vertex")
    mesh, vertices = intake.mesh.submesh(keep)
    return KeptShape(intake, mesh, vertices, np.flatnonzero(keep))


def landmarks_on(first: KeptShape, second: KeptShape, options: OverlapOptions) -> Ints:
    """(p, 4) landmarks: vertices of the kept first and second, and both as the user counts."""
    pairs = np.array(options.landmarks, dtype=np.int64).reshape(-1, 2)
    on_first = first.kept_vertices(pairs[:, 0], what="landmarks:")
    on_second = second.kept_vertices(pairs[:, 1], what="landmarks:")
    there = (on_first >= 0) & (on_second >= 0)
    found: Ints = np.column_stack([on_first, on_second, pairs])[there]
    return found


def pins_on(full: DescribedSurface, part: DescribedSurface, on_full: Ints, on_part: Ints) -> Pins:
    """Pins of vertices (p,) of `part` on vertices of `full`, each vertex once."""
    vertices, first = np.unique(part.working.working_vertices(on_part), return_index=True)
    positions = full.placed.vertices[on_full[first]]
    return Pins(vertices, positions, np.column_stack([on_part[first], on_full[first]]))
