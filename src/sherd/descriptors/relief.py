"""Relief: what a surface keeps when it is bent, at the size of a muscle, a knuckle or an ear.

Two limbs bend alike and are as thick and as long as each other. But skin that is the same has its
bumps, saddles and flat places where the other one has them, and they keep their Gaussian curvature
in every pose. Another animal has other bumps, but it has its shoulders, its withers and its hollows
where the first one has them: its form, which is the same at a larger size, of mean curvature. That
changes where a joint is bent, and hardly elsewhere.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from sherd.arrays import Floats
from sherd.mesh.geometry import angle_defects
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.diffusion import diffused
from sherd.spectral.operators import stiffness

__all__ = ["FINE", "JUDGED", "curvatures", "form", "relief", "relief_and_bulge"]

# In sqrt(area) of the larger piece. As fine as a right map is exact (0.01 to 0.02), and against
# what is around, so many times as far, which is as a limb is wide: that a limb is round is true of
# all limbs.
FINE, AROUND = 0.02, 3.5
# Widths of reliefs that say whether skin is the same where it slid to: the finer one tells most,
# the other one is not lost by what is left of the slide.
JUDGED = (0.04, 0.025)
# Form: as fine as the map of another species is exact, against what is around, the chest or the
# thigh that it belongs to. Chosen among widths from 0.02 to 0.2 on 27 pairs, mostly of SMAL: from
# 0.035 and 0.1 to 0.07 and 0.2 all tell right from wrong about as well.
FORM_FINE, FORM_COARSE = 0.05, 0.14


# several answers to one question ask for those of both of its surfaces, of three widths
@lru_cache(maxsize=6)
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


@lru_cache(maxsize=4)
def curvatures(mesh: TriangleMesh) -> tuple[Floats, Floats]:
    """Gaussian (n,) and mean (n,) curvature, averaged over `FORM_FINE`, 1 / length^2, 1 / length.

    The first is the same in every pose, the second where no joint bends, and says what the first
    does not: how thick a limb is.
    """
    curvatures = np.stack([_angle_defects(mesh), _mean_curvature(mesh)], axis=1)
    (averaged,) = _averaged(mesh, curvatures, (FORM_FINE,))
    return averaged[:, 0], averaged[:, 1]


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


def _averaged(mesh: TriangleMesh, curvatures: Floats, widths: tuple[float, ...]) -> list[Floats]:
    """Integrals (n, k) of curvatures at vertices as their means (n, k) over each width."""
    inside = curvatures.copy()
    inside[mesh.boundary_vertices] = 0.0
    areas = np.maximum(mesh.vertex_areas, 1e-12 * mesh.area / mesh.vertex_count)
    return [diffused(mesh, inside / areas[:, None], width) for width in widths]


def _signed_root(values: Floats) -> Floats:
    result: Floats = np.sign(values) * np.sqrt(np.abs(values))
    return result
