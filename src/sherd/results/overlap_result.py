"""Overlap: what two incomplete shapes share, and which point is which."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from sherd._version import __version__
from sherd.arrays import Bools, Floats, FrozenState, frozen
from sherd.errors import InvalidMeshError
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.advice import UnfollowedLandmark
from sherd.results.display import table_html
from sherd.results.overlap_options import OverlapOptions
from sherd.results.status import Status

__all__ = ["Overlap", "OverlapCheck", "SharedMap", "StrainCurve"]

# There and back, on average where matched, in mean edges of the shape: half an edge.
CLOSED_IN_EDGES = 0.5
# Both sides of what is shared are one surface in two poses: skin stretches by some percent, and a
# border runs along other edges on each.
AREA_LIMIT = 0.2


@dataclass(frozen=True, eq=False, repr=False)
class SharedMap(FrozenState):
    """Where each vertex of one shape lies on the other, or that it lies nowhere.

    Attributes
    ----------
    points
        (n,) points of the other shape; where unmatched, the best guess.
    matched
        (n,) bool, whether the other shape has the vertex: the shared region of this shape.
    membership
        (n,) float in [0, 1], the region, soft.
    confidence
        (n,) float in [0, 1], chance that the vertex is shared and its point within 0.05 of the
        truth, in units of the larger shape's sqrt(area).
    """

    points: SurfacePoints
    matched: Bools
    membership: Floats
    confidence: Floats

    def __post_init__(self) -> None:
        count = len(self.points)
        for name, kind in (("matched", np.bool_), ("membership", float), ("confidence", float)):
            values = np.array(getattr(self, name), dtype=kind)
            if values.shape != (count,):
                raise InvalidMeshError(
                    f"{name} has shape {values.shape}, but there are {count} points"
                )
            object.__setattr__(self, name, frozen(values))

    def __repr__(self) -> str:
        return f"SharedMap({int(self.matched.sum())} of {len(self.points)} vertices matched)"


@dataclass(frozen=True)
class StrainCurve:
    """How the shared area grows with the accepted strain, everything else unchanged.

    Attributes
    ----------
    strains
        Accepted strains, ascending.
    first, second
        Share of each shape's area that would be shared.
    """

    strains: tuple[float, ...]
    first: tuple[float, ...]
    second: tuple[float, ...]


@dataclass(frozen=True)
class OverlapCheck:
    """What :meth:`Overlap.check` re-derives from the meshes.

    Attributes
    ----------
    area_ratio
        Shared area of the second shape, at the scale found, over that of the first.
    there_and_back
        Mean distance between a matched vertex and where its point is brought back to, both ways,
        in mean edges of its shape.
    passed
        Whether something is shared, the areas agree within 20 % and there and back within half an
        edge.
    """

    area_ratio: float
    there_and_back: float
    passed: bool


@dataclass(frozen=True, eq=False, repr=False)
class Overlap(FrozenState):
    """The answer of :func:`sherd.overlap`; all arrays are numbered as the user's shapes are.

    Attributes
    ----------
    first, second
        The shapes of the question.
    second_to_first, first_to_second
        The point of the other shape for every vertex, which are matched, and how surely.
    scale
        Factor that the second was enlarged by.
    status
        Whether the answer as a whole can be trusted; with advice.
    chance
        That the answer as a whole is right, in [0, 1].
    curve
        Shared area against accepted strain.
    timings
        Seconds by stage.
    options, version
        As given, and of sherd.
    notices
        What was adapted in the shapes, in sentences, by "first" and "second".
    advice
        What to do about the status; the status's own if empty.
    unfollowed_landmarks
        Landmarks that the answer does not follow; its `part_vertex` is that of the second shape.
    """

    first: TriangleMesh
    second: TriangleMesh
    second_to_first: SharedMap
    first_to_second: SharedMap
    scale: float
    status: Status
    chance: float
    curve: StrainCurve
    timings: Mapping[str, float]
    options: OverlapOptions
    version: str = field(default=__version__)
    working_vertices: Mapping[str, int] = field(default_factory=dict)
    notices: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    advice: str = ""
    unfollowed_landmarks: tuple[UnfollowedLandmark, ...] = ()

    def __post_init__(self) -> None:
        if not self.advice:
            object.__setattr__(self, "advice", self.status.advice)
        for side, mesh in ((self.second_to_first, self.second), (self.first_to_second, self.first)):
            if len(side.points) != mesh.vertex_count:
                raise InvalidMeshError(
                    f"a map has {len(side.points)} points, but {mesh.name} has "
                    f"{mesh.vertex_count} vertices"
                )

    def __repr__(self) -> str:
        return (
            f"Overlap({self.first.name!r} and {self.second.name!r}: {self.status.name.lower()}, "
            f"share {self.shared_of_first:.0%} of the first, {self.shared_of_second:.0%} of the "
            "second)"
        )

    def _repr_html_(self) -> str:
        rows = {
            "status": self.advice,
            "shared": f"{self.shared_of_first:.1%} of the first, {self.shared_of_second:.1%} of "
            "the second",
            "chance": f"{self.chance:.2f}",
            "scale": f"{self.scale:.4g}",
        }
        return table_html(f"{self.first.name} and {self.second.name}", rows)

    @property
    def shared_of_first(self) -> float:
        """Share of the first shape's area that the second has too."""
        areas = self.first.vertex_areas
        return min(float(areas @ self.first_to_second.matched / areas.sum()), 1.0)  # rounding

    @property
    def shared_of_second(self) -> float:
        """Share of the second shape's area that the first has too."""
        areas = self.second.vertex_areas
        return min(float(areas @ self.second_to_first.matched / areas.sum()), 1.0)

    def there_and_back(self) -> tuple[Floats, Floats]:
        """Distance between each vertex and where its point is brought back to, in its shape's unit.

        (n_first,) and (n_second,).
        """
        one, other = self.first_to_second, self.second_to_first
        here = one.points.interpolate(self.second, other.points.positions(self.first))
        there = other.points.interpolate(self.first, one.points.positions(self.second))
        return (
            np.linalg.norm(here - self.first.vertices, axis=1),
            np.linalg.norm(there - self.second.vertices, axis=1),
        )

    def check(self) -> OverlapCheck:
        """Re-derive areas and there and back from the meshes; see :class:`OverlapCheck`."""
        first, second = self.first, self.second
        one, other = self.first_to_second.matched, self.second_to_first.matched
        area = float(first.vertex_areas @ one)
        ratio = float(second.vertex_areas @ other) * self.scale**2 / area if area else float("nan")
        here, there = self.there_and_back()
        gaps = [here[one] / first.mean_edge_length, there[other] / second.mean_edge_length]
        back = float(np.mean(np.concatenate(gaps))) if one.any() and other.any() else float("nan")
        passed = abs(ratio - 1) < AREA_LIMIT and back < CLOSED_IN_EDGES
        return OverlapCheck(ratio, back, bool(passed))
