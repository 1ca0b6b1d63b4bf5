"""Closest points and vertices of a surface where it looks the same way."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Bools, Floats, Ints, blocks_of_rows
from sherd.mesh.geometry import face_balls, face_cross, lengths
from sherd.mesh.sizes import LARGEST_PART
from sherd.mesh.surface_points import BLOCK, SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.threads import search_threads

__all__ = ["SurfaceFinder", "SurfaceFollower"]


# A normal that differs by a right angle counts like 0.04 of distance: other sheets stay away.
NORMAL_SCALE = 0.03
# Faces searched around each position; exact where triangles are not much longer than wide.
NEAR_FACES = 12
# The faces near a position are searched anew when it has moved by so much of the distance to the
# farthest of them (normals counted as in the search): until then its closest face is among them.
FOLLOWED = 0.15
# Samples per vertex area, each shared by three vertices: a vertex sees a dozen.
SAMPLES = 4
MOST_DIVISIONS = 16
# Positions within so much of the distance to the farthest of the near faces around their middle
# have their closest face among these.
TOGETHER = 0.5
# Of a vertex's area, from which on it is covered.
HALF = 0.5


class SurfaceFinder:
    """Closest points of a mesh of area near 1, on faces that look the same way.

    Parameters
    ----------
    mesh
        The surface, in the template's unit.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        self.mesh = mesh
        self._corners = np.ascontiguousarray(mesh.vertices[mesh.faces])
        self._balls = face_balls(self._corners)
        self._normals = mesh.face_normals
        self._faces = _tree(self._balls[:, :3], self._normals)

    def closest(self, positions: Floats, normals: Floats) -> SurfacePoints:
        """The closest point to each position (p, 3) whose surface has normal (p, 3)."""
        return _joined(
            self.closest_among(
                self.near_faces(positions[rows], normals[rows])[0], positions[rows], normals[rows]
            )
            for rows in _blocks(len(positions))
        )

    def follower(self) -> SurfaceFollower:
        """Closest points of positions that move from one question to the next."""
        return SurfaceFollower(self)

    def near_faces(self, positions: Floats, normals: Floats) -> tuple[Ints, Floats]:
        """Faces (p, k) near each position (p, 3) that look about as its normal (p, 3) does.

        And how far away (p,) the farthest of them is, a normal counting as NORMAL_SCALE.
        """
        count = min(NEAR_FACES, self.mesh.face_count)
        query = _with_normals(positions, normals)
        away, near = (
            np.reshape(found, (-1, count))
            for found in self._faces.query(query, k=count, workers=search_threads(len(query)))
        )
        return near, away[:, -1]

    def closest_among(self, near: Ints, positions: Floats, normals: Floats) -> SurfacePoints:
        """As :meth:`closest`, among the faces `near` (g, k), each row for p / g positions in turn.

        The normals (g, 3) are those of the groups.
        """
        from sherd.mesh.closest_kernel import closest_on_faces  # loads slowly  # noqa: PLC0415

        # among the near faces only those that look the other way are put back
        agreement = np.einsum("pkc,pc->pk", self._normals[near], normals)
        penalty = 4.0 * NORMAL_SCALE**2 * (agreement < 0)
        found = closest_on_faces(positions, near, self._corners, self._balls, penalty)
        return SurfacePoints(*found)

    def _closest_to_groups(self, groups: Floats, normals: Floats) -> SurfacePoints:
        """The closest points, in turn, to groups (g, q, 3) of positions with one normal (g, 3).

        Positions that lie close together have the same near faces: they are searched for once,
        around the middle of the group.
        """
        middles = groups.mean(axis=1)
        near, reach = self.near_faces(middles, normals)
        spread = lengths((groups - middles[:, None]).reshape(-1, 3)).reshape(groups.shape[:2])
        wide = np.flatnonzero(spread.max(axis=1) > TOGETHER * reach)
        points = self.closest_among(near, groups.reshape(-1, 3), normals)
        if not len(wide):
            return points
        number = groups.shape[1]
        alone = self.closest(groups[wide].reshape(-1, 3), np.repeat(normals[wide], number, axis=0))
        faces, weights = points.faces.copy(), points.barycentric.copy()
        rows = (wide[:, None] * number + np.arange(number)).ravel()
        faces[rows], weights[rows] = alone.faces, alone.barycentric
        return SurfacePoints(faces, weights)

    def covered_areas(self, positions: Floats, faces: Ints) -> Floats:
        """How much of a surface (p, 3), (f, 3) lies at each vertex, (n,) area.

        Samples of the surface are shared by the corners of the faces that they lie on, so the mesh
        itself covers each of its vertices by its vertex area.
        """
        corners = positions[faces]
        spanned = face_cross(positions, faces)
        areas = 0.5 * lengths(spanned)
        normals = spanned / np.maximum(2 * areas, 1e-300)[:, None]
        # a part that was torn over the whole space is sampled no more than one of this mesh's size
        spacing = max(self.mesh.area, areas.sum() / LARGEST_PART) / self.mesh.vertex_count
        divisions = np.clip(np.ceil(np.sqrt(SAMPLES * areas / spacing)), 1, MOST_DIVISIONS)
        covered = np.zeros(self.mesh.vertex_count)
        for division in np.unique(divisions):
            rows = np.flatnonzero(divisions == division)
            grid = _subtriangle_centers(int(division))
            samples = np.einsum("gk,fkc->fgc", grid, corners[rows])
            points = _joined(
                self._closest_to_groups(samples[block], normals[rows[block]])
                for block in _blocks(len(rows))
            )
            share = np.repeat(areas[rows] / len(grid), len(grid))
            corners_hit = self.mesh.faces[points.faces]
            parts = points.barycentric * share[:, None]
            covered += np.bincount(corners_hit.ravel(), parts.ravel(), minlength=len(covered))
        return covered

    def covered_vertices(self, positions: Floats, faces: Ints) -> Bools:
        """The vertices (n,) of this mesh that a surface (p, 3), (f, 3) covers at least half of.

        The surface is sampled densely, so the region has no holes between its vertices, however
        coarse it is.
        """
        whole = self.mesh.vertex_areas
        covered: Bools = self.covered_areas(positions, faces) >= HALF * whole
        covered &= whole > 0
        return covered


class SurfaceFollower:
    """The closest points of positions that move a little from one question to the next.

    The faces near a position are searched anew only once it has moved.

    Parameters
    ----------
    finder
        Of the surface.
    """

    def __init__(self, finder: SurfaceFinder) -> None:
        self._finder = finder
        self._near = np.empty((0, 0), dtype=np.int64)
        self._reach, self._searched = np.empty(0), np.empty((0, 6))

    def closest(self, positions: Floats, normals: Floats) -> SurfacePoints:
        """As :meth:`SurfaceFinder.closest`, for as many positions (p, 3) each time."""
        here = _with_normals(positions, normals)
        if not len(self._searched):
            self._searched = here
            self._near, self._reach = self._finder.near_faces(positions, normals)
        else:
            off = ((here - self._searched) ** 2).sum(axis=1)
            moved = np.flatnonzero(off > (FOLLOWED * self._reach) ** 2)
            self._searched[moved] = here[moved]
            self._near[moved], self._reach[moved] = self._finder.near_faces(
                positions[moved], normals[moved]
            )
        return self._finder.closest_among(self._near, positions, normals)


def _blocks(count: int) -> list[slice]:
    """Rows that are searched at once; of none one block without any."""
    return blocks_of_rows(count, BLOCK) or [slice(0, 0)]


def _joined(found: Iterable[SurfacePoints]) -> SurfacePoints:
    every = list(found)
    if len(every) == 1:
        return every[0]
    return SurfacePoints(
        np.concatenate([points.faces for points in every]),
        np.concatenate([points.barycentric for points in every]),
    )


def _tree(places: Floats, normals: Floats) -> cKDTree:
    return cKDTree(_with_normals(places, normals), balanced_tree=False)


def _with_normals(places: Floats, normals: Floats) -> Floats:
    return np.concatenate([places, NORMAL_SCALE * normals], axis=1)


def _subtriangle_centers(division: int) -> Floats:
    """Barycentric centers (division^2, 3) of the small triangles of a divided triangle."""
    rows = []
    for i in range(division):
        for j in range(division - i):
            rows.append((i + 1 / 3, j + 1 / 3))
            if i + j < division - 1:
                rows.append((i + 2 / 3, j + 2 / 3))
    first = np.array(rows) / division
    return np.concatenate([first, 1 - first.sum(axis=1, keepdims=True)], axis=1)
