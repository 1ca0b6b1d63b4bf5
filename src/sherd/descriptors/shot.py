"""SHOT: chiral signature of the surface around a point, in a local reference frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from sherd.arrays import Floats, Ints, Singles
from sherd.descriptors.field import DescriptorField, SpectralSurface
from sherd.descriptors.shot_kernel import neighborhood_moments, shot_histograms
from sherd.errors import OptionError
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["Shot", "local_frames", "shot"]


def shot(
    mesh: TriangleMesh,
    radius: float,
    *,
    queries: ArrayLike | None = None,
    weights: ArrayLike | None = None,
) -> Singles:
    """Signature of histograms of orientations at the query vertices, (q, 352) float32, norm 1.

    Parameters
    ----------
    mesh
        The surface.
    radius
        Radius of the ball, l. sherd states it relative to sqrt(area of the full shape), for
        full shape and part alike.
    queries
        (q,) vertices; all when None.
    weights
        (n,) area of each vertex, l^2; the vertex areas of the mesh when None. Zero hides a vertex.

    Raises
    ------
    OptionError
        If the radius is not positive.

    Notes
    -----
    Chiral: a mirrored shape gives another signature, so left and right differ. Changes within
    `radius` of a cut; in the limit of fine meshes independent of meshing, pose and position.

    References
    ----------
    Tombari, Salti, Di Stefano, *Unique signatures of histograms for local surface
    description*, 2010, equations 1-2 and section 3. Deviations: area weights; the z axis takes
    its sign from the mesh normal, since the majority vote of the paper flips up to 10 % of the
    vertices; the x axis points to the side of the center of mass, which is continuous.
    """
    if not radius > 0:
        raise OptionError(f"SHOT radius is {radius}, but must be positive")
    wanted = (
        np.arange(mesh.vertex_count) if queries is None else np.asarray(queries, dtype=np.int64)
    )
    areas = mesh.vertex_areas if weights is None else np.asarray(weights, dtype=np.float64)
    x_axes, z_axes = local_frames(mesh, radius, queries=wanted, weights=areas)
    histograms = shot_histograms(
        mesh.vertices,
        mesh.vertex_normals,
        areas,
        wanted,
        x_axes=x_axes,
        z_axes=z_axes,
        radii=(radius,),
    )
    return histograms.reshape(len(wanted), -1).astype(np.float32)


def local_frames(
    mesh: TriangleMesh, radius: float, *, queries: Ints, weights: Floats
) -> tuple[Floats, Floats]:
    """X and z axis of the frame of each query vertex, (q, 3) each, unit and orthogonal.

    Principal directions of the weighted neighborhood: z the direction of least spread on the
    side of the vertex normal, x the direction of largest spread on the side of its mean.
    """
    covariance, mean = neighborhood_moments(mesh.vertices, weights, queries, radius=radius)
    _, axes = np.linalg.eigh(covariance)
    z_axes, x_axes = axes[:, :, 0], axes[:, :, 2]
    z_axes = z_axes * _sign(np.einsum("qc,qc->q", z_axes, mesh.vertex_normals[queries]))
    x_axes = x_axes * _sign(np.einsum("qc,qc->q", x_axes, mean))
    return np.ascontiguousarray(x_axes), np.ascontiguousarray(z_axes)


def _sign(values: Floats) -> Floats:
    return np.where(values < 0, -1.0, 1.0)[:, None]


@dataclass(frozen=True)
class Shot:
    """SHOT of several radii side by side.

    Attributes
    ----------
    radii
        Relative to sqrt(area of the full shape).
    """

    radii: tuple[float, ...] = (0.07,)

    @property
    def name(self) -> str:
        """SHOT."""
        return "SHOT"

    def describe(self, surface: SpectralSurface) -> DescriptorField:
        """(n, 352 per radius); see :class:`sherd.descriptors.field.Descriptor`."""
        blocks = [shot(surface.mesh, radius * surface.length) for radius in self.radii]
        reach = np.repeat(np.array(self.radii), [block.shape[1] for block in blocks])
        valid = surface.cut_distance[:, None] >= reach[None, :]
        values = np.concatenate(blocks, axis=1).astype(np.float64)
        return DescriptorField(values, reach, valid)
