"""DescriptorField: numbers per vertex, with the vertices that the cut of a part spoils marked.

A descriptor is one file that offers a frozen dataclass with :class:`Descriptor`'s method; whatever
takes a descriptor takes any of them. All lengths that a descriptor knows are relative to
sqrt(area of the full shape), which the :class:`SpectralSurface` brings along, so full shape and
part are described in the same unit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from sherd.arrays import Bools, Floats, frozen
from sherd.errors import InvalidMeshError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.basis import EigenBasis

__all__ = ["Descriptor", "DescriptorField", "SpectralSurface"]


@dataclass(frozen=True, eq=False)
class SpectralSurface:
    """What descriptors are computed from.

    Attributes
    ----------
    mesh
        Full shape or part.
    basis
        Its first eigenpairs.
    length
        sqrt(area of the full shape), l: the same for the full shape and its parts.
    cut_distance
        (n,) geodesic distance to the nearest cut, in units of `length`; inf where there is none.
    """

    mesh: TriangleMesh
    basis: EigenBasis
    length: float
    cut_distance: Floats


@dataclass(frozen=True, eq=False)
class DescriptorField:
    """Descriptors of every vertex.

    Attributes
    ----------
    values
        (n, d) float64.
    reach
        (d,) how far each number looks, in units of `SpectralSurface.length`.
    valid
        (n, d) bool: False where the cut is nearer than `reach`, so that the part's number
        differs from that of the full shape.
    """

    values: Floats
    reach: Floats
    valid: Bools

    def __post_init__(self) -> None:
        if self.values.ndim != 2 or self.valid.shape != self.values.shape:
            raise InvalidMeshError(
                f"values has shape {self.values.shape} and valid {self.valid.shape}, "
                "but both must be (n, d)"
            )
        if self.reach.shape != self.values.shape[1:]:
            raise InvalidMeshError(
                f"reach has shape {self.reach.shape}, but {self.values.shape[1:]} is needed"
            )
        for name in ("values", "reach", "valid"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    @property
    def interior(self) -> Bools:
        """(n,) True where every number is valid."""
        return np.asarray(self.valid.all(axis=1), dtype=np.bool_)


class Descriptor(Protocol):
    """Anything that describes the vertices of a surface."""

    @property
    def name(self) -> str:
        """What tables and messages call it."""

    def describe(self, surface: SpectralSurface) -> DescriptorField:
        """The field on one surface; full shape and part must give comparable numbers."""
