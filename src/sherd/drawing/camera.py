"""Where to look from: an up direction that leaves the animal standing, a side with the region."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.spatial import ConvexHull, QhullError, cKDTree

from sherd.arrays import Bools, Floats
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.threads import side_by_side

__all__ = ["View", "best_view", "orbit_view", "upward"]


# Twelve ways around, three heights: near enough to the best side for a first look.
AZIMUTHS = 12
ELEVATIONS = (12.0, 32.0, -12.0)
# Seen from a little above is how people draw animals; other heights must show 10 or 25 % more.
ELEVATION_BONUS = (1.0, 0.9, 0.75)
# A three-quarter view shows depth that a view along an axis hides.
OBLIQUE_BONUS = 0.12
# Pixels across when views are compared: a region of 1 % of the shape still covers about 80.
PREVIEW_SIZE = 140
# Larger meshes are thinned for the comparison; this many vertices take a second.
LARGEST_PREVIEW = 100_000
# What lies within this share of the height above the ground carries the weight.
CONTACT_SHARE = 0.06
# Near the ground is below this share of the longest extent: hooves and hands, half a lying man.
LOW_SHARE = 0.1
SAMPLE_SIZE = 1500


@dataclass(frozen=True, eq=False)
class View:
    """An orthographic camera.

    Parameters
    ----------
    rotation
        (3, 3), rows are the directions right, up and toward the viewer, in mesh coordinates.
    visible_share
        Share of the marked area that is seen from here, in [0, 1].
    """

    rotation: Floats
    visible_share: float = 1.0

    @property
    def opposite(self) -> View:
        """From behind, with the same way up."""
        right, up, toward = self.rotation
        return View(np.stack([-right, up - 2 * (up @ toward) * toward, -toward]))


def upward(mesh: TriangleMesh) -> Floats:
    """Direction of the file that points up, (3,): y or z.

    Animals are mirror-symmetric from side to side, so the axis of the best mirror is not up. Of
    the rest, those on which the shape would stand (its center of mass is above its feet) come
    first, and of these the one with the least surface near the ground: feet, and not a rump or a
    back. Meshes without a preference are y-up, as most files are.
    """
    points = _sample(mesh.vertices)
    center = np.average(mesh.vertices, axis=0, weights=mesh.vertex_areas + 1e-300)
    tree = cKDTree(points)
    asymmetry = np.array(
        [np.mean(tree.query(_mirrored(points, center, axis))[0]) for axis in range(3)]
    )
    side = int(np.argmin(asymmetry))
    candidates = [axis for axis in (1, 2) if axis != side]
    standing = [axis for axis in candidates if _stands(mesh.vertices, center, axis)]
    choice = min(standing, key=lambda axis: _low_area(mesh, axis), default=candidates[0])
    direction: Floats = np.eye(3)[choice]
    return direction


def orbit_view(up: Floats, azimuth: float, elevation: float) -> Floats:
    """Rotation (rows right, up, toward the viewer) for angles in degrees around `up`."""
    reference = np.eye(3)[int(np.argmin(np.abs(up)))]
    first = np.cross(up, reference)
    first /= np.linalg.norm(first)
    second = np.cross(up, first)
    theta, phi = np.radians(azimuth), np.radians(elevation)
    toward = np.cos(phi) * (np.cos(theta) * first + np.sin(theta) * second) + np.sin(phi) * up
    right = np.cross(up, toward)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(toward, right), toward])


def best_view(mesh: TriangleMesh, region: Bools, up: Floats) -> View:
    """View in which the marked vertices (n,) bool show best, among 36 around `up`.

    The score is the visible marked area in the picture, plus a little for the outline of the
    whole; views from slightly above and from an oblique side are preferred when nearly equal.
    """
    mesh, region = _preview(mesh, np.asarray(region))
    marked = region[mesh.faces].sum(axis=1) >= 2
    if not marked.any():
        marked = np.ones(mesh.face_count, dtype=bool)
    total = max(float(mesh.face_areas[marked].sum()), np.finfo(float).tiny)
    size = max(float(np.linalg.norm(np.ptp(mesh.vertices, axis=0))), np.finfo(float).tiny)
    best, best_score = View(orbit_view(up, 0.0, 0.0)), -1.0
    turns = 360.0 * (np.arange(AZIMUTHS) + 0.5) / AZIMUTHS
    principal = _principal_azimuth(mesh, up)
    views = [
        (bonus * (1 + OBLIQUE_BONUS * abs(np.sin(2 * np.radians(turn)))), rotation)
        for elevation, bonus in zip(ELEVATIONS, ELEVATION_BONUS, strict=True)
        for turn in turns
        for rotation in [orbit_view(up, principal + turn, elevation)]
    ]
    areas = side_by_side(partial(_seen_areas, mesh, marked, turned, size) for _, turned in views)
    for (liking, rotation), (seen, outline, visible) in zip(views, areas, strict=True):
        score = liking * (seen / total + 0.25 * outline / mesh.area)
        if score > best_score + 1e-12:
            best, best_score = View(rotation, visible), score
    return best


def _preview(mesh: TriangleMesh, region: Bools) -> tuple[TriangleMesh, Bools]:
    """A large mesh with the vertices of each cell of a grid joined, and the region on it.

    Cells are smaller than the pixels by which views are compared, so the views look the same.
    """
    size = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    if mesh.vertex_count <= LARGEST_PREVIEW or not size > 0:
        return mesh, region
    count = 2 * PREVIEW_SIZE
    cells = ((mesh.vertices - mesh.vertices.min(axis=0)) * (count / size)).astype(np.int64)
    keys = (cells[:, 0] * (count + 1) + cells[:, 1]) * (count + 1) + cells[:, 2]
    _, first, joined = np.unique(keys, return_index=True, return_inverse=True)
    faces = joined.ravel()[mesh.faces]
    solid = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    if not solid.any():
        return mesh, region
    return TriangleMesh(mesh.vertices[first], faces[solid], name=mesh.name), region[first]


def _seen_areas(
    mesh: TriangleMesh, marked: Bools, rotation: Floats, size: float
) -> tuple[float, float, float]:
    """Projected area of marked and of all visible surface (l^2), share of marked area visible."""
    from sherd.drawing.raster_kernel import covered_faces  # noqa: PLC0415  numba loads on first use

    pixel = size / PREVIEW_SIZE
    placed = (mesh.vertices - mesh.vertices.min(axis=0)) @ rotation.T / pixel
    placed -= placed.min(axis=0)
    placed[:, 2] *= -1
    width, height = (int(extent) + 2 for extent in placed[:, :2].max(axis=0))
    faces = covered_faces(placed, mesh.faces, width=width, height=height)
    hit = faces[faces >= 0]
    on_region = hit[marked[hit]]
    # a pixel on a slanted face stands for more surface than it covers in the picture
    slant = np.maximum(np.abs(mesh.face_normals[on_region] @ rotation[2]), 0.2)
    total = max(float(mesh.face_areas[marked].sum()), np.finfo(float).tiny)
    visible = min(1.0, float((pixel**2 / slant).sum()) / total)
    return len(on_region) * pixel**2, len(hit) * pixel**2, visible


def _principal_azimuth(mesh: TriangleMesh, up: Floats) -> float:
    """Azimuth (degrees) from which the shape is longest from left to right."""
    points = _sample(mesh.vertices)
    points = points - points.mean(axis=0)
    flat = points - np.outer(points @ up, up)
    covariance = flat.T @ flat
    longest = np.linalg.eigh(covariance)[1][:, -1]
    zero, quarter = orbit_view(up, 0.0, 0.0)[2], orbit_view(up, 90.0, 0.0)[2]
    return float(np.degrees(np.arctan2(longest @ quarter, longest @ zero))) % 180.0 + 90.0


def _low_area(mesh: TriangleMesh, axis: int) -> float:
    """Area near the lowest point along `axis`, l^2."""
    height = mesh.vertices[:, axis] - mesh.vertices[:, axis].min()
    return float(mesh.vertex_areas[height <= LOW_SHARE * np.ptp(mesh.vertices, axis=0).max()].sum())


def _sample(points: Floats) -> Floats:
    return points[:: max(1, len(points) // SAMPLE_SIZE)]


def _mirrored(points: Floats, center: Floats, axis: int) -> Floats:
    mirrored = points.copy()
    mirrored[:, axis] = 2 * center[axis] - mirrored[:, axis]
    return mirrored


def _stands(vertices: Floats, center: Floats, axis: int) -> bool:
    """Whether the center of mass lies above the hull of the lowest points along `axis`."""
    height = vertices[:, axis] - vertices[:, axis].min()
    flat = np.delete(vertices, axis, axis=1)
    feet = flat[height <= CONTACT_SHARE * height.max()]
    try:
        hull = ConvexHull(feet)
    except (QhullError, ValueError):
        return False
    above = np.delete(center, axis)
    return bool((hull.equations[:, :2] @ above + hull.equations[:, 2] <= 0).all())
