"""Fit: the full shape in the pose and place of its pieces, and how good that is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from sherd._version import __version__
from sherd.arrays import Bools, Floats, FrozenState, Ints, frozen
from sherd.errors import InvalidMeshError
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.display import table_html
from sherd.results.fitted.completion import Completion
from sherd.results.fitted.fit_options import FitOptions
from sherd.results.status import Status
from sherd.results.transfer import TransferMethods, checked_vertices
from sherd.threads import cached_property

__all__ = ["DistanceSummary", "Fit", "FitCheck", "FittedPiece", "HiddenRegion", "PieceMap"]


@dataclass(frozen=True)
class DistanceSummary:
    """Distances from the vertices of one surface to another.

    Attributes
    ----------
    mean, most, largest
        Mean, what 95 % of the vertices are below, and the largest, in the unit of the pieces.
    mean_in_edges
        The mean, in mean edges of the surface that was measured from.
    """

    mean: float
    most: float
    largest: float
    mean_in_edges: float

    @staticmethod
    def of(distances: Floats, edge: float) -> DistanceSummary:
        """The summary of distances, of which NaN are left out; NaN if there are none."""
        known = distances[np.isfinite(distances)]
        if not len(known):
            return DistanceSummary(*(float("nan"),) * 4)
        mean = float(known.mean())
        return DistanceSummary(
            mean, float(np.quantile(known, 0.95)), float(known.max()), mean / edge
        )


@dataclass(frozen=True)
class HiddenRegion:
    """One connected part of the full shape that was never seen.

    Attributes
    ----------
    area
        Share of the full shape.
    kept
        Its area in the fit over that in the full shape, over the square of the size found.
    vertex
        Of it, the one farthest from what was seen.
    vertex_count
        Number of its vertices.
    """

    area: float
    kept: float
    vertex: int
    vertex_count: int


@dataclass(frozen=True)
class FitCheck:
    """What :meth:`Fit.check` re-derives from the meshes.

    Attributes
    ----------
    turned_faces
        Faces that are turned over beside those around them.
    hidden_area_kept
        Area of the faces that were not seen, over what it is in the full shape times the square of
        the size found; 1 if all was seen.
    new_intersections
        Faces that pierce others in the fit and not in the full shape.
    intersections_before
        Faces that pierce others in the full shape already.
    passed
        Whether no face is turned over, hidden area is kept within 5 %, and at most one face in a
        thousand is new among those that pierce others.
    """

    turned_faces: int
    hidden_area_kept: float
    new_intersections: int
    intersections_before: int
    passed: bool


@dataclass(frozen=True, eq=False, repr=False)
class FittedPiece(FrozenState):
    """What was fitted to: one piece, and how far it lies from the fit.

    Attributes
    ----------
    part
        The piece.
    points
        (n_part,) the closest point of the fit for each of its vertices.
    matched
        (n_part,) bool, False for clutter and for what the map has no place for.
    distances
        (n_part,) from each vertex to the fit, in the unit of the piece; also of clutter.
    scale
        What lengths of the part were multiplied by to match.
    """

    part: TriangleMesh
    points: SurfacePoints
    matched: Bools
    distances: Floats
    scale: float

    def __post_init__(self) -> None:
        count = self.part.vertex_count
        for name, kind in (("matched", np.bool_), ("distances", np.float64)):
            value = np.array(getattr(self, name), dtype=kind)
            if value.shape != (count,) or len(self.points) != count:
                raise InvalidMeshError(
                    f"{name} has shape {value.shape} and there are {len(self.points)} points, but "
                    f"{self.part.name} has {count} vertices"
                )
            object.__setattr__(self, name, frozen(value))

    @property
    def summary(self) -> DistanceSummary:
        """Of the matched vertices."""
        return DistanceSummary.of(
            np.where(self.matched, self.distances, np.nan), self.part.mean_edge_length
        )


@dataclass(frozen=True, eq=False, repr=False)
class PieceMap(FrozenState, TransferMethods):
    """The map between a piece and the full shape that a fit is, to carry values along.

    Attributes
    ----------
    full, part, points, matched, scale
        As of :class:`sherd.MatchResult`.
    """

    full: TriangleMesh
    part: TriangleMesh
    points: SurfacePoints
    matched: Bools
    scale: float


@dataclass(frozen=True, eq=False, repr=False)
class Fit(FrozenState):
    """The answer of :func:`sherd.fit`; arrays are numbered as the user's shapes are.

    Attributes
    ----------
    full
        The full shape as it was given.
    pieces
        What it was fitted to, all in one pose and place.
    positions
        (n, 3) its vertices in the pose, place and unit of the pieces.
    seen
        (n,) bool, whether a piece lies there.
    chance
        (n,) in [0, 1], that a vertex is within `options.near` sqrt(area) of where it truly is. What
        was not seen has a pose that nobody knows: its chance falls with the distance from the cut.
        None is above the chance of the match itself, and all are lower where what was seen is
        larger or smaller than the full shape, as another individual is.
    distances
        (n,) from each seen vertex to the pieces, in their unit; NaN where nothing was seen.
    strain
        (n,) relative strain of the edges at each vertex, the size that was found aside.
    sizes
        (n,) how many times larger the full shape was made there, beside the scale of the match.
    check
        Turned faces, area, intersections.
    hidden
        What was never seen, largest first.
    status, advice
        Whether the fit as a whole can be trusted, and what to do about it.
    timings
        Seconds by stage.
    options, version
        As given, and of sherd.
    notices
        What was adapted, in sentences.
    completion
        The scan, filled in; None unless asked for with `options.merge`.
    """

    full: TriangleMesh
    pieces: tuple[FittedPiece, ...]
    positions: Floats
    seen: Bools
    chance: Floats
    distances: Floats
    strain: Floats
    sizes: Floats
    check: FitCheck
    hidden: tuple[HiddenRegion, ...]
    status: Status
    advice: str
    timings: Mapping[str, float]
    options: FitOptions
    version: str = field(default=__version__)
    notices: tuple[str, ...] = ()
    completion: Completion | None = None

    def __post_init__(self) -> None:
        count = self.full.vertex_count
        for name in ("positions", "seen", "chance", "distances", "strain", "sizes"):
            value = np.array(getattr(self, name), dtype=bool if name == "seen" else np.float64)
            wanted = (count, 3) if name == "positions" else (count,)
            if value.shape != wanted:
                raise InvalidMeshError(f"{name} has shape {value.shape}, but {wanted} is needed")
            object.__setattr__(self, name, frozen(value))
        object.__setattr__(self, "timings", MappingProxyType(dict(self.timings)))

    def __repr__(self) -> str:
        names = ", ".join(repr(piece.part.name) for piece in self.pieces)
        return (
            f"Fit({self.full.name!r} to {names}: {self.status.name.lower()}, "
            f"{self.seen_share:.0%} seen)"
        )

    def _repr_html_(self) -> str:
        summary = self.scan_summary
        rows = {
            "status": self.advice,
            "seen": f"{self.seen_share:.1%} of the full shape",
            "scan to fit": f"mean {summary.mean:.3g}, 95 % below {summary.most:.3g}",
            "hidden": f"{len(self.hidden)} regions",
        }
        return table_html(f"{self.full.name} fitted", rows)

    @cached_property
    def mesh(self) -> TriangleMesh:
        """The full shape's vertices and faces, in the pose and place of the pieces."""
        return self.full.with_vertices(self.positions)

    @property
    def unit(self) -> float:
        """One sqrt(area of the full shape) in the unit of the pieces."""
        return self.full.length / self.pieces[0].scale

    @property
    def seen_share(self) -> float:
        """Share of the full shape's area that was seen."""
        areas = self.full.vertex_areas
        return float(areas @ self.seen / areas.sum())

    @property
    def scan_summary(self) -> DistanceSummary:
        """Distances from the matched vertices of all pieces to the fit."""
        known = np.concatenate([piece.distances[piece.matched] for piece in self.pieces])
        edges = [piece.part.mean_edge_length for piece in self.pieces]
        return DistanceSummary.of(known, float(np.mean(edges)))

    @property
    def fit_summary(self) -> DistanceSummary:
        """Distances from the seen vertices of the fit to the pieces."""
        return DistanceSummary.of(self.distances, self.mesh.mean_edge_length)

    def landmarks(self, vertices: ArrayLike) -> tuple[Floats, Bools, Floats]:
        """Where vertices (p,) of the full shape lie in the frame of the pieces.

        Returns
        -------
        positions, extrapolated, chance
            (p, 3) in the unit of the pieces; (p,) whether nothing was seen there; (p,) chance that
            the position is within `options.near` sqrt(area).

        Raises
        ------
        InvalidMeshError
            If a vertex does not exist.
        """
        wanted = checked_vertices(vertices, self.full, "full shape")
        return self.positions[wanted], ~self.seen[wanted], self.chance[wanted]

    def piece_map(self, number: int = 0) -> PieceMap:
        """The map between one of the pieces and the full shape."""
        piece = self.pieces[number]
        return PieceMap(self.full, piece.part, piece.points, piece.matched, piece.scale)

    def vertices_of_region(self, number: int) -> Ints:
        """The vertices of one of `hidden`, ascending."""
        from sherd.mesh.topology import component_labels  # noqa: PLC0415 - only asked here

        hidden = ~self.seen
        faces = self.full.faces[hidden[self.full.faces].all(axis=1)]
        labels = component_labels(faces, self.full.vertex_count)
        vertices: Ints = np.flatnonzero(hidden & (labels == labels[self.hidden[number].vertex]))
        return vertices
