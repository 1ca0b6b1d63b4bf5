"""Placement: one place where the part lies, as every question answers it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sherd.arrays import Bools, Floats, FrozenState, frozen
from sherd.errors import InvalidMeshError
from sherd.mesh.surface_points import SurfacePoints

__all__ = ["Placement"]


@dataclass(frozen=True, eq=False, repr=False)
class Placement(FrozenState):
    """One place of the part on the full shape; what was not asked or is not known is None.

    Attributes
    ----------
    mask
        (n_full,) bool, the region.
    membership
        (n_full,) float in [0, 1], the same, soft.
    score
        Mean similarity of the neighborhoods, less mean strain where points are known; at most 1.
        For methods that match integrals, 1 minus the relative data residual.
    mirrored
        True if the place fits only a mirror image of the part.
    points
        A point of the full shape for every vertex of the part; None if only a region was sought.
    matched
        (n_part,) bool, False where the full shape seems to have no such point; the point there
        is the best guess.
    confidence
        (n_part,) float in [0, 1], chance that the error is below 0.05 sqrt(area of full).

    Raises
    ------
    InvalidMeshError
        If arrays that belong together have different lengths, or a confidence is outside [0, 1].

    Examples
    --------
    >>> place = Placement(mask=np.array([True, False]), membership=np.array([0.9, 0.2]), score=0.8)
    >>> place.name, place.points is None
    ('elsewhere', True)
    """

    mask: Bools
    membership: Floats
    score: float
    mirrored: bool = False
    points: SurfacePoints | None = None
    matched: Bools | None = None
    confidence: Floats | None = None

    def __post_init__(self) -> None:
        mask = np.array(self.mask, dtype=bool)
        membership = np.array(self.membership, dtype=np.float64)
        if mask.shape != membership.shape or mask.ndim != 1:
            raise InvalidMeshError(
                f"mask has shape {mask.shape} and membership {membership.shape}, but both must "
                "be (n_full,)"
            )
        object.__setattr__(self, "mask", frozen(mask))
        object.__setattr__(self, "membership", frozen(membership))
        for name, kind in (("matched", np.bool_), ("confidence", np.float64)):
            self._check(name, kind)
        known = self.confidence
        if known is not None and not ((known >= 0) & (known <= 1)).all():
            raise InvalidMeshError("confidence must lie in [0, 1]")

    def _check(self, name: str, kind: type[np.generic]) -> None:
        value = getattr(self, name)
        if value is None:
            return
        array = np.array(value, dtype=kind)
        count = 0 if self.points is None else len(self.points)
        if array.shape != (count,):
            raise InvalidMeshError(f"{name} has shape {array.shape}, but there are {count} points")
        object.__setattr__(self, name, frozen(array))

    def __repr__(self) -> str:
        kind = ", mirrored" if self.mirrored else ""
        share = f"{int(self.mask.sum())} of {len(self.mask)} vertices"
        return f"Placement(score {self.score:.3f}{kind}, {share})"

    @property
    def name(self) -> str:
        """What tables call it among alternatives: ``"mirrored twin"`` or ``"elsewhere"``."""
        return "mirrored twin" if self.mirrored else "elsewhere"
