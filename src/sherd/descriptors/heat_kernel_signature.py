"""Heat kernel signature: how much heat stays at a point after a time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from sherd.arrays import Bools, Floats
from sherd.descriptors.field import DescriptorField, SpectralSurface
from sherd.errors import OptionError
from sherd.spectral.basis import EigenBasis

__all__ = ["HeatKernel", "automatic_times", "boundary_affected", "heat_kernel_signature"]


# Heat that started at distance d from a reflecting edge has come back to its start in the amount
# exp(-d^2 / t) of what stays (the mirror image at distance 2d): 1.8 % at d = 2 sqrt(t).
AFFECTED_ROOTS = 2.0
# The truncated sum misses terms of weight exp(-lambda_k t) and less; e^-4 keeps the loss at the
# smallest time near 2 %, which also is what the boundary rule above allows.
TRUNCATION_EXPONENT = 4.0


def heat_kernel_signature(basis: EigenBasis, times: ArrayLike) -> Floats:
    """Auto-diffusivity `k_t(x, x) = sum_i exp(-lambda_i t) phi_i(x)^2`, (n, q), unit 1/l^2.

    Parameters
    ----------
    basis
        k eigenpairs; the sum is truncated there.
    times
        (q,) diffusion times, l^2, positive.

    Raises
    ------
    OptionError
        If a time is not positive.

    References
    ----------
    Sun, Ovsjanikov, Guibas, *A concise and provably informative multi-scale signature based on
    heat diffusion*, 2009, equation 3 at x = y.
    """
    moments = np.atleast_1d(np.asarray(times, dtype=np.float64))
    if not (moments > 0).all():
        raise OptionError(f"diffusion times are {moments}, but must be positive")
    decay = np.exp(-np.outer(basis.eigenvalues, moments))
    signature: Floats = basis.eigenvectors**2 @ decay
    return signature


def automatic_times(surfaces: list[SpectralSurface], count: int) -> Floats:
    """Times that every surface resolves and that leave half of each one's area unspoiled, l^2.

    Logarithmically spaced from `4 / lambda_k` (below it the truncated sum is wrong) to the time
    whose affected band, `2 sqrt(t)`, reaches the median cut distance by area. Where the two
    cross, the lower bound wins and all times are equal to it or slightly above.
    """
    shortest = max(
        TRUNCATION_EXPONENT / max(surface.basis.eigenvalues[-1], 1e-300) for surface in surfaces
    )
    # without any cut a time of area / 4 pi already sees the whole shape
    longest = min(surface.length**2 / (4 * np.pi) for surface in surfaces)
    for surface in surfaces:
        distance, areas = surface.cut_distance, surface.mesh.vertex_areas
        order = np.argsort(distance, kind="stable")
        half = np.searchsorted(np.cumsum(areas[order]), 0.5 * areas.sum())
        median = float(distance[order[min(half, len(order) - 1)]]) * surface.length
        longest = min(longest, (median / AFFECTED_ROOTS) ** 2)
    return np.geomspace(shortest, max(longest, 1.5 * shortest), count)


def boundary_affected(cut_distance: ArrayLike, times: ArrayLike) -> Bools:
    """True where the cut changes the signature by about 2 % or more: distance < 2 sqrt(t), (n, q).

    Parameters
    ----------
    cut_distance
        (n,) distance to the nearest cut.
    times
        (q,) diffusion times, in the square of the unit of `cut_distance`.
    """
    reach = AFFECTED_ROOTS * np.sqrt(np.asarray(times, dtype=np.float64))
    affected: Bools = np.asarray(cut_distance)[:, None] < reach[None, :]
    return affected


@dataclass(frozen=True)
class HeatKernel:
    """Heat kernel signatures at fixed times, each brought to the order of 1.

    `4 pi t k_t(x, x)` is 1 on a plane, whatever the unit, and `1 + K t / 3 + O(t^2)` at Gauss
    curvature K, so all times weigh alike.

    Attributes
    ----------
    times
        Diffusion times relative to the area of the full shape.
    """

    times: tuple[float, ...]

    @property
    def name(self) -> str:
        """HKS."""
        return "HKS"

    def describe(self, surface: SpectralSurface) -> DescriptorField:
        """(n, q) scaled signatures; see :class:`sherd.descriptors.field.Descriptor`."""
        relative = np.array(self.times)
        absolute = relative * surface.length**2
        values = 4 * np.pi * absolute * heat_kernel_signature(surface.basis, absolute)
        valid = ~boundary_affected(surface.cut_distance, relative)
        return DescriptorField(values, AFFECTED_ROOTS * np.sqrt(relative), valid)
