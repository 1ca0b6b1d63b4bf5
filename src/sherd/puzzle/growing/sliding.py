"""What two pieces share, slid along the skin until the relief of one lies on that of the other.

Where skin stretches between two poses an elastic surface does not follow. It lies beside its place,
with less strain than there and everywhere by about as much, and neighborhoods that are wider than
the slide look as alike as at the place itself. But bumps and hollows of the skin say where it lies.
So a map is moved along the surface as one picture of a film onto the next: by the smooth field that
best explains how reliefs differ, wide bumps first. At a wrong place there is no such field, and
reliefs stay as unlike as they were.

References
----------
Horn, Schunck, *Determining optical flow*, 1981.
Brox, Bruhn, Papenberg, Weickert, *High accuracy optical flow estimation based on a theory for
warping*, 2004: from coarse to fine, each step from where the last one led.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache, partial

import numpy as np
from scipy.sparse.linalg import LinearOperator, cg

from sherd.arrays import Bools, Floats
from sherd.correspondence.elastic_kernel import fit_rotations
from sherd.correspondence.labels.two_way import Both
from sherd.correspondence.question import Question
from sherd.correspondence.registration import Deformation
from sherd.correspondence.shared.relief import alike_in, relief, seen_area
from sherd.correspondence.shared.two_way_placement import SharedPlacement, drawn_together
from sherd.mesh.geometry import lengths, vertex_normals
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.operators import gradient, stiffness
from sherd.threads import side_by_side

__all__ = ["alike_in_reliefs", "slid"]

# Bumps of these widths, in sqrt(area) of the larger piece: a slope says how far off its bump is up
# to about its width, and right answers slide by 0.05 to 0.08; below the last one a slide of the
# size of an edge is noise.
WIDTHS = (0.06, 0.04, 0.025)
# What is seen says more than that the field is smooth about what is wider than this, the finest
# bump. On one pair of a horse that was off by 0.047 four and two times as much leave 0.024 and
# 0.018, this 0.014.
SMOOTH = 0.025
# Steps at each width, as slopes are straight only so far, and how often both directions slide and
# are drawn together. The second time moves a right answer by a fifth of the first.
STEPS, ROUNDS = 4, 2
# Ranks differ by a third where nothing agrees; beyond this a difference counts less and less.
DOUBT = 0.3
# Where nothing is seen the field is held by so little of what slopes hold it by elsewhere.
LEAST_HOLD = 1e-3
CG_TOLERANCE, CG_LIMIT = 1e-3, 200
# Both finer reliefs judge: the finest tells most, and the next one is not lost by what is left of a
# slide.
JUDGING = 2


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
        if not all(place.shared.any() for place in found):
            return placements
        moved = side_by_side(
            partial(_moved, *each) for each in zip(questions, found, found[::-1], strict=True)
        )
        found = drawn_together(questions, (moved[0], moved[1]), strain)
    if not all(place.shared.any() for place in found):
        return placements
    return (
        replace(found[0], similarity=placements[0].similarity),
        replace(found[1], similarity=placements[1].similarity),
    )


def alike_in_reliefs(questions: Both[Question], placements: Both[SharedPlacement]) -> float:
    """How alike the reliefs of two pieces are where one lies on the other, in [-1, 1].

    Mean over the finer of `WIDTHS`.
    """
    there, here = (_reliefs(question.full.mesh)[-JUDGING:] for question in questions)
    both = zip(here, there, strict=True)
    return float(np.mean([alike_in(fields, questions, placements) for fields in both]))


# each question asks for those of both of its surfaces, many times
@lru_cache(maxsize=4)
def _reliefs(mesh: TriangleMesh) -> tuple[Floats, ...]:
    """The relief (n,) of a mesh at each of `WIDTHS`."""
    return tuple(relief(mesh, width) for width in WIDTHS)


def _moved(question: Question, own: SharedPlacement, other: SharedPlacement) -> Deformation:
    """The part, slid along the full shape by how reliefs differ over what is shared."""
    part, full = question.part.mesh, question.full.mesh
    start = own.deformation.positions
    slide = np.zeros_like(start)
    surface = question.full.finder.follower()
    for here, there, width in zip(_reliefs(part), _reliefs(full), WIDTHS, strict=True):
        sought, seen = _ranks(here, own.shared), _ranks(there, other.shared)
        slopes = _slopes(full, seen)
        for _ in range(STEPS):
            facing = vertex_normals(start + slide, part.faces)
            points = surface.closest(start + slide, facing)
            slide = _field(
                part,
                part.vertex_areas * own.shared,
                seen_area(question, own.shared, points, width),
                sought - points.interpolate(full, seen),
                points.interpolate(full, slopes),
                points.interpolate(full, full.vertex_normals),
                slide,
            )
            # what is shared lies on the surface; the rest is carried along
            feet = surface.closest(start + slide, facing).positions(full)
            slide = np.where(own.shared[:, None], feet - start, slide)
    positions = start + slide
    return Deformation(positions, fit_rotations(question.part.elastic, positions))


def _field(
    part: TriangleMesh,
    laid: Floats,
    trust: Floats,
    unlike: Floats,
    slopes: Floats,
    up: Floats,
    before: Floats,
) -> Floats:
    """The smooth field (n, 3) along the surface that explains best how reliefs differ.

    Minimizes, with slopes g along the surface, mean square slope s and w the trust where reliefs
    differ little,

        sum w (unlike - g (u - before))^2 + s sum laid (up u)^2 + s SMOOTH^2 integral |grad u|^2

    Parameters
    ----------
    part
        The surface that slides.
    laid, trust
        (n,) area of what lies on the other surface, and of what sees its relief.
    unlike
        (n,) what reliefs differ by after the field `before` (n, 3).
    slopes, up
        (n, 3) of the relief of the other surface, and its normals, there.
    before
        What the last step found.
    """
    up = up / np.maximum(lengths(up), 1e-12)[:, None]
    along = slopes - np.einsum("ni,ni->n", slopes, up)[:, None] * up
    steep = float(trust @ (along**2).sum(axis=1) / max(trust.sum(), 1e-12))
    weights = trust / (1 + (unlike / DOUBT) ** 2)
    hold = weights[:, None, None] * along[:, :, None] * along[:, None, :]
    hold += (steep * laid)[:, None, None] * up[:, :, None] * up[:, None, :]
    # a surface without slopes says nothing, and is still solved
    hold += max(LEAST_HOLD * steep, 1e-12) * part.area / part.vertex_count * np.eye(3)
    pull = (weights * (unlike + np.einsum("ni,ni->n", along, before)))[:, None] * along
    stiff = steep * SMOOTH**2 * stiffness(part.vertices, part.faces)
    eased = np.linalg.inv(hold + stiff.diagonal()[:, None, None] * np.eye(3))

    def held(flat: Floats) -> Floats:
        field = flat.reshape(-1, 3)
        pressed: Floats = np.einsum("nij,nj->ni", hold, field) + stiff @ field
        return pressed.ravel()

    def preconditioned(flat: Floats) -> Floats:
        field: Floats = np.einsum("nij,nj->ni", eased, flat.reshape(-1, 3))
        return field.ravel()

    shape = (before.size, before.size)
    found, _ = cg(
        LinearOperator(shape, held, dtype=np.float64),
        pull.ravel(),
        x0=before.ravel(),
        rtol=CG_TOLERANCE,
        maxiter=CG_LIMIT,
        M=LinearOperator(shape, preconditioned, dtype=np.float64),
    )
    field: Floats = found.reshape(-1, 3)
    return field


def _ranks(values: Floats, shared: Bools) -> Floats:
    """Values (n,) as ranks among those that are shared, from -1/2 to 1/2.

    A nose or a hoof has more relief than all the rest, and what two meshings have of it differs.
    """
    order = np.sort(values[shared])
    ranks: Floats = (np.searchsorted(order, values) + 0.5) / (len(order) + 1) - 0.5
    return ranks


def _slopes(mesh: TriangleMesh, values: Floats) -> Floats:
    """Gradient (n, 3) of values (n,) at vertices: the mean of those on faces, by area."""
    steps = (gradient(mesh.vertices, mesh.faces) @ values).reshape(-1, 3)
    weighed = np.repeat(steps * mesh.face_areas[:, None], 3, axis=0)
    total = [
        np.bincount(mesh.faces.ravel(), axis, minlength=mesh.vertex_count) for axis in weighed.T
    ]
    slopes: Floats = np.stack(total, axis=1) / np.maximum(3 * mesh.vertex_areas, 1e-15)[:, None]
    return slopes
