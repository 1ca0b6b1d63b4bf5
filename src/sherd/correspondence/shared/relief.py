"""Relief: what a surface keeps when it is bent, at the size of a muscle, a knuckle or an ear.

Two limbs bend alike, are as thick and as long as each other, and labels lie well on either. But
skin that is the same has its bumps, saddles and flat places where the other one has them, and
they keep their Gaussian curvature in every pose. So wherever a map lays it, the relief of the one
must be that of the other, place by place.

Another animal has other bumps, but it has its shoulders, its withers and its hollows where the
first one has them: its form, which is the same at a larger size, of mean curvature. That changes
where a joint is bent, and hardly elsewhere.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from scipy.stats import rankdata

from sherd.arrays import Bools, Floats
from sherd.correspondence.labels.consistent import node_areas
from sherd.correspondence.labels.labeling import Labeling, Problem
from sherd.correspondence.labels.two_way import Both
from sherd.correspondence.question import Question
from sherd.correspondence.shared.two_way_placement import SharedPlacement
from sherd.mesh.geometry import angle_defects
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.diffusion import diffused
from sherd.spectral.operators import stiffness

__all__ = [
    "alike_at_labels",
    "alike_in",
    "alike_in_form",
    "alike_in_relief",
    "form",
    "relief",
    "relief_and_bulge",
    "seen_area",
]

# In sqrt(area) of the larger piece. As fine as a right map is exact (0.01 to 0.02), and against
# what is around, so many times as far, which is as a limb is wide: that a limb is round is true of
# all limbs.
FINE, AROUND = 0.02, 3.5
# Nearer to a cut than so many widths the angles of faces that are gone are missing in the average.
CUT_WIDTHS = 2
CUT = CUT_WIDTHS * FINE
# Form: as fine as the map of another species is exact, against what is around, the chest or the
# thigh that it belongs to. Chosen among widths from 0.02 to 0.2 on 27 pairs, mostly of SMAL: from
# 0.035 and 0.1 to 0.07 and 0.2 all tell right from wrong about as well.
FORM_FINE, FORM_COARSE = 0.05, 0.14
# Two nodes are always in order or in reverse order.
LEAST_NODES = 3


# several answers to one question ask for those of both of its surfaces
@lru_cache(maxsize=4)
def relief(mesh: TriangleMesh, width: float = FINE) -> Floats:
    """The relief (n,) of a mesh in units of sqrt(area), 1 / length.

    The signed root of Gaussian curvature, averaged over `width`, less the same over `AROUND` times
    that. The root, as the curvature of a bump is that of its size squared, and tips would outweigh
    all else.
    """
    fine, coarse = _averaged(mesh, _angle_defects(mesh)[:, None], (width, AROUND * width))
    return _signed_root(fine[:, 0]) - _signed_root(coarse[:, 0])


@lru_cache(maxsize=4)
def form(mesh: TriangleMesh) -> Floats:
    """The form (n,) of a mesh in units of sqrt(area), 1 / length; positive where it bulges.

    Mean curvature averaged over `FORM_FINE`, less the same over `FORM_COARSE`: half of the
    Laplacian of positions along the normal.
    """
    fine, coarse = _averaged(mesh, _mean_curvature(mesh)[:, None], (FORM_FINE, FORM_COARSE))
    form: Floats = (fine - coarse)[:, 0]
    return form


def relief_and_bulge(mesh: TriangleMesh, width: float) -> tuple[Floats, Floats]:
    """The relief (n,) of a mesh, see :func:`relief`, and how it bulges, negative in a hollow.

    That is mean curvature averaged over `width`, less the same over `AROUND` times that. Two
    pictures of one surface: neither follows from the other, and where one is flat the other one
    may have a slope.
    """
    curvatures = np.stack([_angle_defects(mesh), _mean_curvature(mesh)], axis=1)
    fine, coarse = _averaged(mesh, curvatures, (width, AROUND * width))
    return _signed_root(fine[:, 0]) - _signed_root(coarse[:, 0]), fine[:, 1] - coarse[:, 1]


def _angle_defects(mesh: TriangleMesh) -> Floats:
    """Integral (n,) of Gaussian curvature around each vertex."""
    return angle_defects(mesh.vertices, mesh.faces)


def _mean_curvature(mesh: TriangleMesh) -> Floats:
    """Integral (n,) of mean curvature around each vertex."""
    pull = stiffness(mesh.vertices, mesh.faces) @ mesh.vertices
    bent: Floats = 0.5 * np.einsum("ij,ij->i", pull, mesh.vertex_normals)
    return bent


def _averaged(mesh: TriangleMesh, curvatures: Floats, widths: tuple[float, float]) -> list[Floats]:
    """Integrals (n, k) of curvatures at vertices as their means (n, k) over each width."""
    inside = curvatures.copy()
    inside[mesh.boundary_vertices] = 0.0
    areas = np.maximum(mesh.vertex_areas, 1e-12 * mesh.area / mesh.vertex_count)
    return [diffused(mesh, inside / areas[:, None], width) for width in widths]


def alike_in_relief(questions: Both[Question], placements: Both[SharedPlacement]) -> float:
    """How alike the reliefs of two pieces are where one lies on the other, in [-1, 1].

    See :func:`alike_in`.
    """
    reliefs = (relief(questions[0].part.mesh), relief(questions[1].part.mesh))
    return alike_in(reliefs, questions, placements)


def alike_in_form(questions: Both[Question], placements: Both[SharedPlacement]) -> float:
    """How alike the forms of two pieces are where one lies on the other, in [-1, 1].

    See :func:`alike_in`.
    """
    forms = (form(questions[0].part.mesh), form(questions[1].part.mesh))
    return alike_in(forms, questions, placements)


def alike_in(
    fields: Both[Floats], questions: Both[Question], placements: Both[SharedPlacement]
) -> float:
    """How alike what is known of two shapes is where one lies on the other, in [-1, 1].

    Spearman's rank correlation over what is shared, by area, mean of both directions; 0 where
    nothing is shared. Ranks, since a nose or a hoof has more relief than all the rest.

    Parameters
    ----------
    fields
        (n,) and (m,), of the part's vertices of the one question and of the other.
    questions, placements
        Of both directions.
    """
    both = zip(questions, placements, fields, fields[::-1], strict=True)
    return float(np.mean([_alike(*each) for each in both]))


def seen_area(question: Question, shared: Bools, points: SurfacePoints, width: float) -> Floats:
    """The area (n,) of the part that is shared, less along both cuts, of what is `width` wide.

    `points` of the full shape are where the part's vertices lie.
    """
    full, part = question.full, question.part
    depth = np.minimum(part.cut_distance, points.interpolate(full.mesh, full.cut_distance))
    seen: Floats = part.mesh.vertex_areas * shared * np.clip(depth / (CUT_WIDTHS * width), 0.0, 1.0)
    return seen


def alike_at_labels(
    fields: Both[Floats], problems: Both[Problem], found: Both[Labeling], kept: Both[Bools]
) -> float:
    """How alike what is known of two shapes is where nodes have labels, times the root of the area.

    As :func:`alike_in`, of the nodes that are kept and not of all vertices, before anything is
    laid. A rank correlation of n independent places scatters by 1 / sqrt(n) where nothing is alike,
    so what it proves grows with the root of the area.

    Parameters
    ----------
    fields
        (n,) and (m,), of the vertices of the second shape and of the first.
    problems
        The nodes of the second shape with labels of the first, and the other way around.
    found, kept
        Labelings of both, and (k,) the nodes of each that count.
    """
    alike, area = 0.0, 0.0
    for side, problem in enumerate(problems):
        labels = found[side].labels
        areas = node_areas(problem) * kept[side]
        depth = np.minimum(problem.node_depth, problem.label_depth[labels])
        trust = areas * np.clip(depth / CUT, 0.0, 1.0)
        rows = np.flatnonzero(trust > 0)
        area += 0.5 * float(areas.sum())
        if len(rows) >= LEAST_NODES:
            here = fields[side][problem.nodes.vertices[rows]]
            there = fields[1 - side][problem.labels.vertices[labels[rows]]]
            alike += 0.5 * _correlation(rankdata(here), rankdata(there), trust[rows])
    return alike * math.sqrt(area)


def _alike(question: Question, place: SharedPlacement, own: Floats, other: Floats) -> float:
    points = place.trip.points
    trust = seen_area(question, place.shared, points, FINE)
    rows = np.flatnonzero(trust > 0)
    if len(rows) < 2:
        return 0.0
    there = points[rows].interpolate(question.full.mesh, other)
    return _correlation(rankdata(own[rows]), rankdata(there), trust[rows])


def _correlation(first: Floats, second: Floats, weights: Floats) -> float:
    """Pearson's correlation with weights (n,); 0 if one of both is constant."""
    first = first - np.average(first, weights=weights)
    second = second - np.average(second, weights=weights)
    spread = math.sqrt(float(weights @ first**2) * float(weights @ second**2))
    return float(weights @ (first * second)) / spread if spread > 0 else 0.0


def _signed_root(values: Floats) -> Floats:
    result: Floats = np.sign(values) * np.sqrt(np.abs(values))
    return result
