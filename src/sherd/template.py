"""Template: all that depends on the full shape alone, made once and saved."""

from __future__ import annotations

import io
import os
import zipfile
import zlib
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Bools, Floats, Ints, Singles
from sherd.descriptors.rotation_shot import rotation_spectra
from sherd.descriptors.tangent_frames import geodesic_directions, smoothed_normals, tangent_axes
from sherd.errors import InfeasibleError, MeshFileError
from sherd.mesh.sides import check_sides
from sherd.mesh.surface_finder import SurfaceFinder
from sherd.mesh.surface_points import SurfacePoints, closest_points
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import write_bytes
from sherd.spectral.basis import EigenBasis, eigenbasis
from sherd.spectral.geodesics import Geodesics
from sherd.spectral.sampling import decimate, farthest_point_sample
from sherd.spectral.subdivision import split_long_edges

__all__ = [
    "AXIS_WIDTH",
    "NEAR",
    "RADII",
    "Template",
    "canonical",
    "refuse_tiny_part",
    "working_mesh",
]


# All lengths are in units of sqrt(area of the full shape).
# Neighborhoods from the smallest that holds some 40 vertices of a 10,000-vertex mesh to the
# width of a limb; larger ones meet the cut too often and change with the pose.
RADII = (0.04, 0.06, 0.10)
# The normal axis must not see single vertices (spacing 0.01 at 10,000 vertices) but still turn
# with the smallest neighborhood.
AXIS_WIDTH = 0.012
# Closer than this the gradient of a geodesic distance is unreliable: a few vertex spacings.
NEAR = 0.07
# 1,200 labels lie 0.03 apart, below the smallest radius; 700 were too few to pin directions.
LABEL_COUNT = 1200
# The smallest ball then holds ten vertices and more. Twice the usual 10,000 vertices are more than
# answers between vertices need.
LONGEST_EDGE = 0.025
MOST_VERTICES = 20_000
# Right triangles with edges of at least half the longest length have at most 20,000 vertices
# on area 1; a quarter more is for those that are not even.
ROOM = 1.25
# In area: a part 3e-5 of the length of the full shape lies between the vertices of any mesh.
SMALLEST_PART = 1e-9
# A disk that needs n vertices has 3.5 sqrt(n) at its border, a tenth of a thousand. A denser
# border, as large scans have, would leave the inside without vertices, so it is thinned as well.
LARGEST_BORDER = 0.2
# Raise when what is saved changes its meaning.
FORMAT = 1
BASIS_SIZE = 160


class Template:
    """What matching needs to know about the full shape, computed on first use and kept.

    Everything below is stated in units of `length = sqrt(area of full)`, so that neither the unit
    of the file nor a scaling of both shapes matters.

    Parameters
    ----------
    full
        The full shape.

    Attributes
    ----------
    placed, unit
        The full shape scaled to area 1, its center at the origin, turned to its principal axes; and
        the same surface as a mesh of moderate size and even edges, on which all work is done. They
        are equal for an even mesh of moderate size.
    label_vertices, label_distances, label_directions
        (s,) vertices that stand for all others, farthest-point samples; (s, n) float32 geodesic
        distances; (s, s) float32 angles at which geodesics leave a label for another.
    cells
        (n,) the label nearest to each vertex.
    normals, x_axes
        (n, 3) tangent frame of each vertex.
    spectra
        (5, n, 2 c) float32, see :mod:`sherd.descriptors.rotation_shot`.
    basis
        The first eigenpairs of the unit shape.

    Examples
    --------
    >>> from sherd.shapes.creature import creature
    >>> template = Template(creature(5000))
    >>> round(template.unit.area, 6)
    1.0
    """

    def __init__(self, full: TriangleMesh) -> None:
        self.full = full

    def prepare(self) -> None:
        """Compute now all that matching needs, instead of on first use."""
        _ = (self.spectra, self.label_to_label, self.label_directions)

    @cached_property
    def placed(self) -> TriangleMesh:
        """The full shape itself, scaled to area 1 and turned to its principal axes."""
        return canonical(self.full, self.length)

    @cached_property
    def unit(self) -> TriangleMesh:
        """The working mesh: the placed shape, meshed anew if it is large or uneven."""
        return working_mesh(self.placed)

    @cached_property
    def own_vertices(self) -> SurfacePoints | None:
        """Where the vertices of `placed` lie on `unit`; None if they are the same mesh."""
        same = self.unit is self.placed or np.array_equal(self.unit.faces, self.placed.faces)
        return None if same else closest_points(self.unit, self.placed.vertices)

    @cached_property
    def finder(self) -> SurfaceFinder:
        """Closest points on the unit shape."""
        return SurfaceFinder(self.unit)

    @cached_property
    def own_finder(self) -> SurfaceFinder:
        """Closest points on the placed shape, whose faces the user counts."""
        return self.finder if self.own_vertices is None else SurfaceFinder(self.placed)

    @cached_property
    def vertex_tree(self) -> cKDTree:
        """The vertices of the unit shape, to find those near a place."""
        return cKDTree(self.unit.vertices)

    @property
    def length(self) -> float:
        """sqrt(area) of the full shape, in its own unit."""
        return self.full.length

    @cached_property
    def basis(self) -> EigenBasis:
        """The first eigenpairs of the unit shape."""
        return eigenbasis(self.unit, BASIS_SIZE)

    @cached_property
    def geodesics(self) -> Geodesics:
        """The geodesic solver of the unit shape."""
        return Geodesics(self.unit)

    @cached_property
    def _labels(self) -> tuple[Ints, Singles]:
        # Split edges add vertices to the working mesh but nothing to its shape: distances are
        # measured on the mesh before the split, at a third of the cost, and carried over.
        split = self.placed.vertex_count < self.unit.vertex_count
        ruler = self.placed if split else self.unit
        count = min(LABEL_COUNT, len(np.unique(ruler.faces)))
        # the start is the vertex farthest from the center: it does not depend on numbering
        start = int(np.linalg.norm(ruler.vertices, axis=1).argmax())
        vertices, distances = farthest_point_sample(Geodesics(ruler), count, start=start)
        rows = distances.astype(np.float32)
        if not split:
            return vertices, rows
        added = closest_points(ruler, self.unit.vertices[ruler.vertex_count :])
        corners, weights = ruler.faces[added.faces], added.barycentric.astype(np.float32)
        # a corner of weight 0 may lie on another component, infinitely far
        carried = sum(
            np.where(weights[:, k] > 0, rows[:, corners[:, k]], 0.0) * weights[:, k]
            for k in range(3)
        )
        return vertices, np.concatenate([rows, carried], axis=1)

    @property
    def label_vertices(self) -> Ints:
        """(s,) vertices that stand for all others."""
        return self._labels[0]

    @property
    def label_distances(self) -> Singles:
        """(s, n) geodesic distance from each label."""
        return self._labels[1]

    @cached_property
    def label_to_label(self) -> Singles:
        """(s, s) geodesic distances between the labels."""
        between = self.label_distances[:, self.label_vertices]
        return np.ascontiguousarray(np.minimum(between, between.T))

    @cached_property
    def cells(self) -> Ints:
        """(n,) the label nearest to each vertex."""
        nearest = self.label_distances.argmin(axis=0)
        nearest[self.label_vertices] = np.arange(len(self.label_vertices))
        cells: Ints = nearest
        return cells

    @cached_property
    def normals(self) -> Floats:
        """(n, 3) smoothed unit normals."""
        return smoothed_normals(self.unit, AXIS_WIDTH)

    @cached_property
    def x_axes(self) -> Floats:
        """(n, 3) first tangent axis, nearly parallel within each cell."""
        labels = self.label_vertices
        reference = np.tile([1.0, 0.3, 0.2], (len(labels), 1))
        axes = tangent_axes(self.normals[labels], reference)
        return tangent_axes(self.normals, axes[self.cells])

    @cached_property
    def label_directions(self) -> Singles:
        """(s, s) angle of the geodesic from label to label, in the frame of the first."""
        labels = self.label_vertices
        return geodesic_directions(
            self.unit,
            labels,
            self.label_distances,
            x_axes=self.x_axes[labels],
            z_axes=self.normals[labels],
            near=NEAR,
        )

    @cached_property
    def label_headings(self) -> Singles:
        """(s, s, 2) cosine and sine of `label_directions`."""
        angles = self.label_directions
        return np.stack([np.cos(angles), np.sin(angles)], axis=2)

    @cached_property
    def spectra(self) -> Singles:
        """(5, n, 2 c) rotation-searched SHOT of every vertex."""
        return self._spectra_of(np.arange(self.unit.vertex_count), self.unit.vertex_areas)

    def spectra_within(self, mask: Bools) -> Singles:
        """Spectra as a part sees them that covers `mask` (n,): only the area inside counts.

        Vertices outside keep their ordinary spectra.
        """
        inside = np.flatnonzero(mask)
        spectra = self.spectra.copy()
        spectra[:, inside] = self._spectra_of(inside, self.unit.vertex_areas * mask)
        return spectra

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write mesh and everything computed to one ``.npz`` file, atomically.

        Raises
        ------
        OutputError
            If the file cannot be written.
        """
        self.prepare()
        arrays = {name: getattr(self, name) for name in _SAVED}
        stream = io.BytesIO()
        np.savez(
            stream, format=FORMAT, name=self.full.name,
            vertices=self.full.vertices, faces=self.full.faces,
            unit_vertices=self.unit.vertices, unit_faces=self.unit.faces, **arrays,
        )  # fmt: skip
        write_bytes(path, stream.getvalue())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Template:
        """Read what :meth:`save` wrote; matching with it gives the same bits.

        Raises
        ------
        MeshFileError
            If the file is missing, damaged, or of another version of sherd.
        """
        try:
            with Path(path).open("rb") as stream, np.load(stream, allow_pickle=False) as stored:
                content: dict[str, Any] = dict(stored)
        except (OSError, ValueError, TypeError, EOFError, zipfile.BadZipFile, zlib.error) as error:
            reason = getattr(error, "strerror", None) or "damaged, or no template"
            raise MeshFileError(
                f"{path}: cannot be read as a template ({reason}); make it again"
            ) from error
        missing = {"format", "name", "vertices", "faces", "unit_vertices", "unit_faces", *_SAVED}
        missing -= set(content)
        if missing or content["format"].tolist() != FORMAT or not _fit(content):
            raise MeshFileError(f"{path}: is no template of this version of sherd; make it again")
        full = TriangleMesh(content["vertices"], content["faces"], name=str(content["name"]))
        template = cls(full)
        unit = TriangleMesh(content["unit_vertices"], content["unit_faces"], name=full.name)
        template.__dict__["unit"] = unit
        template.__dict__["_labels"] = (content["label_vertices"], content["label_distances"])
        for name in ("label_directions", "normals", "spectra"):
            template.__dict__[name] = content[name]
        return template

    def _spectra_of(self, vertices: Ints, weights: Floats) -> Singles:
        return rotation_spectra(
            self.unit.vertices,
            self.normals,
            weights,
            vertices,
            x_axes=self.x_axes[vertices],
            z_axes=self.normals[vertices],
            radii=RADII,
        )


def _fit(content: dict[str, Any]) -> bool:
    """Whether stored arrays have the shapes and kinds that belong together."""
    labels, vertices = content["label_vertices"], len(np.atleast_1d(content["unit_vertices"]))
    count = len(np.atleast_1d(labels))
    shapes = {
        "label_vertices": (count,),
        "label_distances": (count, vertices),
        "label_directions": (count, count),
        "normals": (vertices, 3),
    }
    if any(content[name].shape != shape for name, shape in shapes.items()):
        return False
    spectra = content["spectra"]
    if spectra.ndim != 3 or spectra.shape[1] != vertices or count == 0:
        return False
    if any(content[name].dtype.kind != "f" for name in _SAVED if name != "label_vertices"):
        return False
    return bool(labels.dtype.kind == "i" and 0 <= labels.min() <= labels.max() < vertices)


_SAVED = ("label_vertices", "label_distances", "label_directions", "normals", "spectra")


def refuse_tiny_part(part: TriangleMesh, full: TriangleMesh) -> None:
    """Raise InfeasibleError if the part is a dot on the full shape."""
    if part.area < SMALLEST_PART * full.area:
        raise InfeasibleError(
            f"{part.name} has {part.area / full.area:.2g} times the area of {full.name}, too "
            "little to be found there; are the two in different units?"
        )


def working_mesh(mesh: TriangleMesh) -> TriangleMesh:
    """`mesh` (in the template's unit) with a vertex wherever one is needed, and not many more.

    Neighborhoods are compared by their vertices, so both shapes need some in every ball: long
    edges are split, which leaves the surface and the given vertices as they are; only hair-thin
    faces, which would take vertices without end, keep longer edges. A mesh with many more vertices
    than answers need is decimated before.

    Raises
    ------
    InvalidMeshError
        If the faces do not agree on which side is outside.
    """
    most = int(MOST_VERTICES * max(mesh.area, 0.1))
    if mesh.vertex_count > most:
        keep = len(mesh.boundary_vertices) <= LARGEST_BORDER * most
        mesh = decimate(mesh, most, keep_border=keep)[0]
    check_sides(mesh)
    room = int(ROOM * most)
    vertices, faces = split_long_edges(mesh.vertices, mesh.faces, LONGEST_EDGE, most=room)
    if len(vertices) == mesh.vertex_count:
        return mesh
    return TriangleMesh(vertices, faces, name=mesh.name)


def canonical(mesh: TriangleMesh, length: float) -> TriangleMesh:
    """`mesh` divided by `length`, its center at the origin, its principal axes the coordinates.

    The signs of the axes make the third moments positive, up to the last, which keeps the shape's
    handedness. So a motion of the file changes what follows by rounding errors only.
    """
    areas = mesh.vertex_areas / mesh.area
    centered = (mesh.vertices - areas @ mesh.vertices) / length
    _, axes = np.linalg.eigh(centered.T @ (areas[:, None] * centered))
    axes *= np.where(areas @ (centered @ axes) ** 3 < 0, -1.0, 1.0)
    axes[:, 0] *= np.sign(np.linalg.det(axes))
    return TriangleMesh(centered @ axes, mesh.faces, name=mesh.name)
