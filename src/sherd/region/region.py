"""Region: where the part lies on the full shape, with the proof that it is one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sherd.arrays import Bools, Floats
from sherd.energy.cleanup import pieces
from sherd.energy.convergence import Convergence
from sherd.energy.mumford_shah import EnergyTerms
from sherd.energy.problem import EnergyWeights
from sherd.mesh import topology
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.region.options import LocateOptions

__all__ = ["Found", "Placement", "Region", "RegionCheck"]


@dataclass(frozen=True, eq=False)
class Placement:
    """One place where the part could lie.

    Attributes
    ----------
    name
        ``"best"``, ``"mirrored twin"`` or ``"elsewhere"``.
    membership
        (n,) float in [0, 1].
    mask
        (n,) bool.
    score
        Mean similarity of the part's neighborhoods with those of the place, at most 1; for
        methods that match integrals, 1 minus the relative data residual.
    mirrored
        True if the place fits only a mirror image of the part.
    """

    name: str
    membership: Floats
    mask: Bools
    score: float
    mirrored: bool


@dataclass(frozen=True, eq=False)
class Found:
    """What a method of locating hands back; :class:`Region` explains each."""

    membership: Floats
    mask: Bools
    phase_field: Floats
    score: float
    energy: EnergyTerms
    status: Convergence
    alternatives: tuple[Placement, ...]
    weights: EnergyWeights


@dataclass(frozen=True)
class RegionCheck:
    """What :meth:`Region.check` found, re-derived from the meshes alone.

    Attributes
    ----------
    area_error
        Area of the mask over area of the part, minus 1.
    membership_area_error
        The same for the integral of the membership.
    lowest, highest
        Extremes of the membership.
    piece_count
        Connected pieces of the mask.
    decided
        Share of the full shape's area where the membership is below 0.25 or above 0.75.
    passed
        Areas within 5 %, membership in [0, 1] and nothing undefined.
    """

    area_error: float
    membership_area_error: float
    lowest: float
    highest: float
    piece_count: int
    decided: float
    passed: bool


@dataclass(frozen=True, eq=False)
class Region:
    """The answer of :func:`sherd.locate`; all arrays are numbered as the full shape's vertices.

    Attributes
    ----------
    full, part
        The meshes of the question.
    membership
        (n,) float in [0, 1], soft.
    mask
        (n,) bool, crisp; its area is that of the part.
    phase_field
        (n,) float in [0, 1], near 0 at the region's boundary.
    score
        See :class:`Placement`.
    energy
        Terms of the energy at the answer.
    status
        Why the solver stopped, with advice.
    alternatives
        Other placements, best first, for example the left twin of a right leg.
    options
        As given, with the automatic choices filled in.
    timings
        Seconds by stage.
    version
        Of sherd.
    working_vertices
        Number of vertices of the meshes that were searched, by "full" and "part". Large or uneven
        shapes are searched on a mesh of moderate size; the answer is carried back.
    """

    full: TriangleMesh
    part: TriangleMesh
    membership: Floats
    mask: Bools
    phase_field: Floats
    score: float
    energy: EnergyTerms
    status: Convergence
    alternatives: tuple[Placement, ...]
    options: LocateOptions
    timings: Mapping[str, float]
    version: str
    working_vertices: Mapping[str, int]

    @property
    def area(self) -> float:
        """Area of the mask, l^2."""
        return float(self.full.vertex_areas[self.mask].sum())

    @property
    def area_fraction(self) -> float:
        """Area of the part over area of the full shape."""
        return self.part.area / self.full.area

    def check(self) -> RegionCheck:
        """Re-derive areas, bounds and pieces from the meshes; see :class:`RegionCheck`."""
        areas, u = self.full.vertex_areas, self.membership
        wanted = min(self.part.area, self.full.area)
        adjacency = topology.adjacency(self.full.faces, self.full.vertex_count)
        area_error = self.area / wanted - 1
        membership_error = float(areas @ u) / wanted - 1
        # one vertex more or less is the best a mask can do on a coarse mesh
        slack = 0.05 + float(areas.max()) / wanted
        bounded = bool(u.min() >= 0 and u.max() <= 1)
        return RegionCheck(
            area_error=area_error,
            membership_area_error=membership_error,
            lowest=float(u.min()),
            highest=float(u.max()),
            piece_count=int(pieces(self.mask, adjacency).max()) + 1,
            decided=float(areas[np.abs(u - 0.5) > 0.25].sum() / self.full.area),
            passed=bounded and abs(area_error) <= slack and abs(membership_error) <= slack,
        )
