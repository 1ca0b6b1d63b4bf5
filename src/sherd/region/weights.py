"""Automatic choice of the paper's parameters."""

from __future__ import annotations

import math

from sherd.energy.problem import EnergyWeights
from sherd.results.locate_options import LocateOptions
from sherd.spectral.basis import EigenBasis

__all__ = ["chosen_weights"]


def chosen_weights(options: LocateOptions, basis: EigenBasis, part_area: float) -> EnergyWeights:
    """The weights of `options`, with what it leaves open chosen for this basis and area.

    The energy is dimensionless, so its weights carry over from shape to shape; only the phase
    field's width must not be finer than the basis resolves: half a wave of the last eigenvector,
    `pi / sqrt(lambda_k)`, in units of sqrt(s).
    """
    defaults = EnergyWeights()
    resolved = math.pi / math.sqrt(max(float(basis.eigenvalues[-1]), 1e-300) * part_area)
    # wider than the part itself says nothing; this happens with a handful of eigenvectors only
    width = min(max(defaults.phase_width, resolved), 1.0)
    return EnergyWeights(
        regularity=defaults.regularity if options.regularity is None else options.regularity,
        smoothness=defaults.smoothness if options.smoothness is None else options.smoothness,
        boundary=defaults.boundary if options.boundary is None else options.boundary,
        phase_width=width if options.phase_width is None else options.phase_width,
    )
