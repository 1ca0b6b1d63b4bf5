"""LocateResult: where the part lies on the full shape, with the proof that it does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from sherd._version import __version__
from sherd.arrays import Bools, Floats, FrozenState
from sherd.drawing.exhibit import Exhibit, Layer
from sherd.energy.cleanup import pieces
from sherd.energy.convergence import Convergence
from sherd.energy.mumford_shah import EnergyTerms
from sherd.mesh import topology
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.advice import Doubts
from sherd.results.display import picture_html, table_html
from sherd.results.locate_options import LocateOptions
from sherd.results.placement import Placement
from sherd.results.status import Status

__all__ = ["LocateCheck", "LocateResult"]

# A region is grown until the next vertex would overshoot, and interpolation to other vertices adds
# the curvature of the mesh: a few percent.
AREA_LIMIT = 0.05


@dataclass(frozen=True)
class LocateCheck:
    """What :meth:`LocateResult.check` found, re-derived from the meshes alone.

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

    Examples
    --------
    >>> LocateCheck(0.01, 0.0, 0.0, 1.0, piece_count=1, decided=0.97, passed=True).passed
    True
    """

    area_error: float
    membership_area_error: float
    lowest: float
    highest: float
    piece_count: int
    decided: float
    passed: bool


@dataclass(frozen=True, eq=False, repr=False)
class LocateResult(FrozenState):
    """The answer of :func:`sherd.locate`; arrays are numbered as the full shape's vertices are.

    Attributes
    ----------
    full, part
        The shapes of the question.
    best
        The answer: its membership and its mask, whose area is that of the part.
    alternatives
        Other placements, best first, for example the left twin of a right leg.
    phase_field
        (n,) float in [0, 1], near 0 at the region's boundary.
    energy
        Terms of the energy at the answer.
    convergence
        Why the solver stopped, with advice.
    options
        As given, with the automatic choices filled in.
    timings
        Seconds by stage.
    version
        Of sherd.
    working_vertices
        Number of vertices of the meshes that were searched, by "full" and "part". Large or uneven
        shapes are searched on a mesh of moderate size; the answer is carried back.
    notices
        What was adapted in the shapes, in sentences, by "full" and "part".
    chance
        That the part belongs on the full shape at all, in [0, 1]; None where it was not asked, as
        by the methods of the papers.
    featureless
        Whether the part looks the same everywhere, so that it fits anywhere.

    Examples
    --------
    >>> from sherd.locate import locate
    >>> from sherd.shapes import creature, cut_by_ball, whole
    >>> full = creature(5000)
    >>> result = locate(full, cut_by_ball(whole(creature(5000, pose="walk"), full), 0, 0.5).mesh)
    >>> result.check().passed
    True
    """

    full: TriangleMesh
    part: TriangleMesh
    best: Placement
    alternatives: tuple[Placement, ...]
    phase_field: Floats
    energy: EnergyTerms
    convergence: Convergence
    options: LocateOptions
    timings: Mapping[str, float]
    version: str = field(default=__version__)
    working_vertices: Mapping[str, int] = field(default_factory=dict)
    notices: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    chance: float | None = None
    featureless: bool = False

    def __repr__(self) -> str:
        return (
            f"LocateResult({self.part.name!r} on {self.full.name!r}: score {self.score:.3f}, "
            f"{self.area_fraction:.0%} of the area)"
        )

    def _repr_html_(self) -> str:
        membership = self.membership[self.mask]
        rows = {
            "status": self.advice,
            "coverage": f"{self.area_fraction:.1%} of the full shape",
            "mean membership of the region": f"{membership.mean() if len(membership) else 0:.2f}",
            "score": f"{self.score:.3f}",
            "alternatives": ", ".join(repr(other) for other in self.alternatives) or "none",
            "to see it": "sherd.show(result), sherd.plot(result)",
        }
        title = f"{self.part.name} on {self.full.name}"
        shown = Layer("membership", self.membership, range=(0, 1), color_map="ember")
        scene = Exhibit(title, self.full, self.part, full_layers=(shown,), region=self.mask)
        return table_html(title, rows) + picture_html(scene)

    @property
    def doubts(self) -> Doubts:
        """What speaks against the part's belonging here."""
        chance = 1.0 if self.chance is None else self.chance
        return Doubts(chance=chance, featureless=self.featureless)

    @property
    def trusted(self) -> bool:
        """Whether the solver converged and nothing speaks against the part's belonging here."""
        return self.convergence.succeeded and self.doubts.status is Status.GOOD

    @property
    def advice(self) -> str:
        """What to do about it, in a sentence."""
        belongs = self.doubts.status is Status.GOOD
        return self.convergence.advice if belongs else self.doubts.advice

    @property
    def mask(self) -> Bools:
        """(n,) bool, crisp; its area is that of the part."""
        return self.best.mask

    @property
    def membership(self) -> Floats:
        """(n,) float in [0, 1], soft."""
        return self.best.membership

    @property
    def score(self) -> float:
        """Of the best placement, at most 1."""
        return self.best.score

    @property
    def area(self) -> float:
        """Area of the mask, l^2."""
        return float(self.full.vertex_areas[self.mask].sum())

    @property
    def area_fraction(self) -> float:
        """Area of the part over area of the full shape."""
        return self.part.area / self.full.area

    def check(self) -> LocateCheck:
        """Re-derive areas, bounds and pieces from the meshes; see :class:`LocateCheck`."""
        areas, u = self.full.vertex_areas, self.membership
        wanted = min(self.part.area, self.full.area)
        adjacency = topology.adjacency(self.full.faces, self.full.vertex_count)
        area_error = self.area / wanted - 1
        membership_error = float(areas @ u) / wanted - 1
        # one vertex more or less is the best a mask can do on a coarse mesh
        slack = AREA_LIMIT + float(areas.max()) / wanted
        bounded = bool(u.min() >= 0 and u.max() <= 1)
        return LocateCheck(
            area_error=area_error,
            membership_area_error=membership_error,
            lowest=float(u.min()),
            highest=float(u.max()),
            piece_count=int(pieces(self.mask, adjacency).max()) + 1,
            decided=float(areas[np.abs(u - 0.5) > 0.25].sum() / self.full.area),
            passed=bounded and abs(area_error) <= slack and abs(membership_error) <= slack,
        )
