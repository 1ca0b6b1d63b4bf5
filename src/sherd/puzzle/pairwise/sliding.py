"""What two pieces share, slid along the skin until bumps of one lie on those of the other.

Where skin stretches between two poses an elastic surface does not follow. It lies beside its place,
with less strain than there and everywhere by about as much, and neighborhoods that are wider than
the slide look as alike as at the place itself. But bumps and hollows of the skin say where it lies.
So a map is moved along the surface as one picture of a film onto the next: by the smooth field that
best explains how Gaussian and mean curvature differ, wide bumps first. At a wrong place there is no
such field, and reliefs stay as unlike as they were.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache, partial

import numpy as np

from sherd.arrays import Floats
from sherd.correspondence.elastic_kernel import fit_rotations
from sherd.correspondence.labels.two_way import Both
from sherd.correspondence.question import Question
from sherd.correspondence.registration import Deformation
from sherd.correspondence.shared.relief_correlation import (
    alike_in,
    judged_reliefs,
    seen_area,
)
from sherd.correspondence.shared.two_way_placement import (
    SharedPlacement,
    drawn_together,
    share_something,
)
from sherd.descriptors.relief import JUDGED, relief_and_bulge
from sherd.mesh.geometry import vertex_normals
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.optical_flow import Sight, flow_field, ranks, slopes
from sherd.threads import side_by_side

__all__ = ["alike_in_reliefs", "slid"]

# Bumps of these widths, in sqrt(area) of the larger piece: a slope says how far off its bump is up
# to about its width, and right answers slide by 0.05 to 0.08; below the last one a slide of the
# size of an edge is noise.
WIDTHS = (0.06, *JUDGED)
# What is seen says more than that the field is smooth about what is wider than this, the finest
# bump. On one pair of a horse that was off by 0.047 four and two times as much leave 0.024 and
# 0.018, this 0.014.
SMOOTH = 0.025
# Steps at each width, as slopes are straight only so far, and how often both directions slide and
# are drawn together. The second time moves a right answer by a fifth of the first.
STEPS, ROUNDS = 4, 2


def slid(
    questions: Both[Question], placements: Both[SharedPlacement], *, strain: float
) -> Both[SharedPlacement]:
    """Both placements, slid along the other surface and drawn together.

    Where nothing is shared, or nothing would be afterwards, they are as they were.

    Parameters
    ----------
    questions
        The second shape on the first, and the first on the second.
    placements
        Of both.
    strain
        What is accepted as shared, see :func:`sharing_cost`.
    """
    found = placements
    for _ in range(ROUNDS):
        if not share_something(found):
            return placements
        moved = side_by_side(
            partial(_moved, *each) for each in zip(questions, found, found[::-1], strict=True)
        )
        found = drawn_together(questions, (moved[0], moved[1]), strain)
    if not share_something(found):
        return placements
    return (
        replace(found[0], similarity=placements[0].similarity),
        replace(found[1], similarity=placements[1].similarity),
    )


def alike_in_reliefs(questions: Both[Question], placements: Both[SharedPlacement]) -> float:
    """How alike the reliefs of two pieces are where one lies on the other, in [-1, 1].

    Mean over the finer of `WIDTHS`, which say whether skin is the same.
    """
    reliefs = judged_reliefs(questions)
    return float(np.mean([alike_in(fields, questions, placements) for fields in reliefs]))


# each question asks for those of both of its surfaces, many times
@lru_cache(maxsize=4)
def _pictures(mesh: TriangleMesh) -> tuple[tuple[Floats, Floats], ...]:
    """Relief (n,) and bulge (n,) of a mesh at each of `WIDTHS`."""
    return tuple(relief_and_bulge(mesh, width) for width in WIDTHS)


def _moved(question: Question, own: SharedPlacement, other: SharedPlacement) -> Deformation:
    """The part, slid along the full shape by how both differ over what is shared."""
    part, full = question.part.mesh, question.full.mesh
    start = own.deformation.positions
    slide = np.zeros_like(start)
    surface = question.full.finder.follower()
    for here, there, width in zip(_pictures(part), _pictures(full), WIDTHS, strict=True):
        sought = [ranks(picture, own.shared) for picture in here]
        seen = [ranks(picture, other.shared) for picture in there]
        steep = [slopes(full, picture) for picture in seen]
        for _ in range(STEPS):
            facing = vertex_normals(start + slide, part.faces)
            points = surface.closest(start + slide, facing)
            sights = [
                Sight(wanted - points.interpolate(full, found), points.interpolate(full, slope))
                for wanted, found, slope in zip(sought, seen, steep, strict=True)
            ]
            slide = flow_field(
                part,
                part.vertex_areas * own.shared,
                seen_area(question, own.shared, points, width),
                np.zeros(part.vertex_count),
                sights,
                points.interpolate(full, full.vertex_normals),
                slide,
                SMOOTH,
            )
            # what is shared lies on the surface; the rest is carried along
            feet = surface.closest(start + slide, facing).positions(full)
            slide = np.where(own.shared[:, None], feet - start, slide)
    positions = start + slide
    return Deformation(positions, fit_rotations(question.part.elastic, positions))
