"""Found: what a method of locating hands back, on the working mesh of the full shape."""

from __future__ import annotations

from dataclasses import dataclass

from sherd.arrays import Floats
from sherd.energy.convergence import Convergence
from sherd.energy.mumford_shah import EnergyTerms
from sherd.energy.problem import EnergyWeights
from sherd.results.placement import Placement

__all__ = ["Found"]


@dataclass(frozen=True, eq=False)
class Found:
    """See :class:`sherd.results.locate_result.LocateResult`; `weights` are those of the energy."""

    best: Placement
    alternatives: tuple[Placement, ...]
    phase_field: Floats
    energy: EnergyTerms
    convergence: Convergence
    weights: EnergyWeights
