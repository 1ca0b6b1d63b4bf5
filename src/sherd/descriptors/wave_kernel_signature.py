"""Wave kernel signature: how likely a quantum particle of an energy is met at a point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from sherd.arrays import Floats
from sherd.descriptors.field import DescriptorField, SpectralSurface
from sherd.errors import OptionError
from sherd.spectral.basis import EigenBasis

__all__ = ["WaveKernel", "wave_kernel_signature"]


def wave_kernel_signature(basis: EigenBasis, energies: ArrayLike, width: float) -> Floats:
    """`sum_i phi_i(x)^2 exp(-(e - log lambda_i)^2 / (2 width^2)) / sum_i exp(...)`, (n, q), 1/l^2.

    Parameters
    ----------
    basis
        k eigenpairs; zero eigenvalues carry no wave and are left out.
    energies
        (q,) e, logarithms of eigenvalues.
    width
        Standard deviation of the energy distribution, in log eigenvalue, positive.

    Raises
    ------
    OptionError
        If the width is not positive.

    References
    ----------
    Aubry, Schlickewei, Cremers, *The wave kernel signature*, 2011, equation 9 and section 3.3.
    """
    if not width > 0:
        raise OptionError(f"wave kernel width is {width}, but must be positive")
    # eigenvalues of constants are 0 up to rounding
    live = basis.eigenvalues > 1e-9 * max(float(basis.eigenvalues[-1]), 1e-300)
    levels = np.log(basis.eigenvalues[live])
    gaps = np.atleast_1d(np.asarray(energies, dtype=np.float64))[None, :] - levels[:, None]
    exponent = -0.5 * (gaps / width) ** 2
    weights = np.exp(exponent - exponent.max(axis=0, initial=-np.inf))
    weights /= weights.sum(axis=0)
    signature: Floats = basis.eigenvectors[:, live] ** 2 @ weights
    return signature


@dataclass(frozen=True)
class WaveKernel:
    """Wave kernel signatures at fixed energies, times the area of the full shape.

    Attributes
    ----------
    energies
        Logarithms of eigenvalues times the area of the full shape.
    width
        In log eigenvalue.
    """

    energies: tuple[float, ...]
    width: float

    @property
    def name(self) -> str:
        """WKS."""
        return "WKS"

    @classmethod
    def between(cls, lowest: float, highest: float, count: int) -> WaveKernel:
        """`count` energies for eigenvalues (times area) from `lowest` to `highest`.

        The width is 7 spacings, the choice of Aubry et al. for overlapping bands.
        """
        energies = np.linspace(np.log(lowest), np.log(highest), count)
        spacing = (energies[-1] - energies[0]) / max(count - 1, 1)
        return cls(tuple(energies.tolist()), 7 * float(spacing))

    def describe(self, surface: SpectralSurface) -> DescriptorField:
        """(n, q); on a part the number of each band is scaled by the area ratio.

        A band holds a fixed number of eigenvalues in proportion to area (Weyl), and each
        phi^2 integrates to 1 over its own surface: times the surface's own area both have mean 1.
        """
        energies = np.array(self.energies) - 2 * np.log(surface.length)
        signature = wave_kernel_signature(surface.basis, energies, self.width)
        values = signature * surface.mesh.area
        # waves of eigenvalue lambda vary over sqrt(2) pi / sqrt(lambda): a half period in 2D
        reach = np.sqrt(2.0) * np.pi / np.exp(np.array(self.energies) / 2)
        valid = surface.cut_distance[:, None] >= reach[None, :]
        return DescriptorField(values, reach, valid)
