"""IntrinsicTriangulation: a surface by the lengths of its edges, flipped to be Delaunay."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from sherd.arrays import Floats, Ints
from sherd.mesh.geometry import edge_lengths
from sherd.mesh.topology import half_edges
from sherd.spectral.intrinsic_kernel import flip_to_delaunay

__all__ = ["IntrinsicTriangulation", "intrinsic_delaunay"]

# Added to all edges as needed, relative to their mean, so that no triangle is flat (Sharp and
# Crane 2020, section 4.5).
MARGIN = 1e-5
# Flips end by themselves, after fewer flips than edges on all but the worst meshes.
MOST_FLIPS = 50


@dataclass(frozen=True, eq=False)
class IntrinsicTriangulation:
    """Triangles without places.

    Attributes
    ----------
    faces
        (m, 3) vertices.
    lengths
        (m, 3) of the sides from corner k to corner k + 1, l.
    glue
        (3 m,) the other side of side 3 f + k, or -1.
    """

    faces: Ints
    lengths: Floats
    glue: Ints

    def renumbered(self, numbers: Ints) -> IntrinsicTriangulation:
        """With the vertices' new numbers."""
        return IntrinsicTriangulation(numbers[self.faces], self.lengths, self.glue)

    def corners(self) -> Floats:
        """(m, 3): each triangle in its own plane, as x_1, x_2 and y_2.

        Corner 0 is the origin, corner 1 is (x_1, 0) and corner 2 is (x_2, y_2).
        """
        ab, bc, ca = self.lengths.T
        x = (ab**2 + ca**2 - bc**2) / (2 * ab)
        y = np.sqrt(np.maximum(ca**2 - x**2, (MARGIN * ca) ** 2))
        return np.stack([ab, x, y], axis=1)

    def stiffness_and_areas(self, count: int) -> tuple[sparse.csc_array, Floats]:
        """Cotangent stiffness (n, n) and vertex areas (n,), a third of each triangle's.

        Linear elements: see :func:`sherd.spectral.operators.stiffness`.
        """
        corners = self.corners()
        area = 0.5 * corners[:, 0] * corners[:, 2]
        squared = self.lengths**2
        total = squared.sum(axis=1, keepdims=True)
        weights = (total - 2 * squared) / (8 * area[:, None])
        tail, head = self._ends()
        # an edge may join a vertex to itself: it adds nothing
        entries = np.where(tail == head, 0.0, weights.ravel())
        shape = (count, count)
        half: sparse.csc_array = sparse.coo_array((entries, (tail, head)), shape=shape).tocsc()
        both = half + half.T
        degree: sparse.dia_array = sparse.diags_array(np.asarray(both.sum(axis=1)).ravel())
        areas = np.bincount(self.faces.ravel(), np.repeat(area / 3, 3), minlength=count)
        return sparse.csc_array(degree - both), areas.astype(float)

    def steps(self, count: int) -> sparse.csr_array:
        """(n, n) symmetric: length of each side and of each straight line across a glued side.

        Where several join the same two vertices the shortest counts.
        """
        tail, head = self._ends()
        across, first, second = self._lines_across()
        ends = np.concatenate([np.stack([tail, head]), np.stack([first, second])], axis=1)
        lengths = np.concatenate([self.lengths.ravel(), across])
        low, high = ends.min(axis=0), ends.max(axis=0)
        order = np.lexsort((lengths, high, low))
        low, high, lengths = low[order], high[order], lengths[order]
        new = np.append(True, (np.diff(low) != 0) | (np.diff(high) != 0))[: len(low)]
        new &= low != high
        upper = sparse.coo_array((lengths[new], (low[new], high[new])), shape=(count, count))
        return sparse.csr_array(upper + upper.T)

    def _ends(self) -> tuple[Ints, Ints]:
        return self.faces.ravel(), np.roll(self.faces, -1, axis=1).ravel()

    def _lines_across(self) -> tuple[Floats, Ints, Ints]:
        """Length and ends of the other diagonals of two glued triangles, where both see it."""
        side = np.flatnonzero(self.glue > np.arange(len(self.glue)))
        other = self.glue[side]
        face, turn, beyond, back = side // 3, side % 3, other // 3, other % 3
        ab = self.lengths[face, turn]
        x, y = _apex(ab, self.lengths[face, (turn + 1) % 3], self.lengths[face, (turn + 2) % 3])
        u, v = _apex(ab, self.lengths[beyond, (back + 2) % 3], self.lengths[beyond, (back + 1) % 3])
        foot = x + (u - x) * y / np.maximum(y + v, 1e-300)
        seen = (foot > 0) & (foot < ab)
        first, second = self.faces[face, (turn + 2) % 3], self.faces[beyond, (back + 2) % 3]
        return np.hypot(x - u, y + v)[seen], first[seen], second[seen]


def _apex(ab: Floats, bc: Floats, ca: Floats) -> tuple[Floats, Floats]:
    """Place of c above the x axis when a is the origin and b = (ab, 0)."""
    x = (ab**2 + ca**2 - bc**2) / (2 * ab)
    return x, np.sqrt(np.maximum(ca**2 - x**2, 0.0))


def intrinsic_delaunay(vertices: Floats, faces: Ints) -> IntrinsicTriangulation:
    """The Delaunay triangulation of the surface with these vertices; edges run on the surface.

    Faces that name a vertex twice are left out.

    Borders, edges of more than two faces, and edges whose two faces are not oriented alike stay.

    References
    ----------
    Sharp and Crane, *A Laplacian for nonmanifold triangle meshes*, 2020, sections 4.4 and 4.5;
    here faces at non-manifold edges are not doubled.
    """
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    lengths = edge_lengths(vertices, faces)[:, [2, 0, 1]]  # opposite corner k is side k + 1
    spare = lengths.sum(axis=1, keepdims=True) - 2 * lengths
    least = MARGIN * lengths.mean() if len(lengths) else 0.0
    lengths = lengths + max(least - float(spare.min(initial=0.0)), 0.0)
    triangles = IntrinsicTriangulation(faces, np.ascontiguousarray(lengths), _glued_sides(faces))
    flip_to_delaunay(triangles.faces, triangles.lengths, triangles.glue, MOST_FLIPS * len(faces))
    return triangles


def _glued_sides(faces: Ints) -> Ints:
    """(3 m,) the other side of each side, where exactly two faces share an edge, or -1."""
    halves = half_edges(faces)
    low, high = halves.min(axis=1), halves.max(axis=1)
    keys = low * (int(faces.max(initial=0)) + 1) + high
    order = np.argsort(keys, kind="stable")
    ranked = keys[order]
    same = ranked[1:] == ranked[:-1]
    first = np.flatnonzero(
        same & ~np.append(same[1:], False) & ~np.concatenate([[False], same[:-1]])
    )
    a, b = order[first], order[first + 1]
    against = (halves[a, 0] == halves[b, 1]) & (low[a] < high[a])
    glue = np.full(len(halves), -1, dtype=np.int64)
    glue[a[against]], glue[b[against]] = b[against], a[against]
    return glue
