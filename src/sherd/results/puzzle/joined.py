"""Joined: pieces without a whole, which belong together, and the maps between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from sherd._version import __version__
from sherd.arrays import FrozenState
from sherd.errors import InvalidMeshError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.display import table_html
from sherd.results.overlap_result import SharedMap
from sherd.results.puzzle.assemble_options import AssembleOptions

__all__ = ["Joined", "PairAnswer"]


@dataclass(frozen=True)
class PairAnswer:
    """What is known of two pieces.

    Attributes
    ----------
    first, second
        Their numbers, ascending.
    evidence
        Share of a few nodes that are worth more than chance on the other piece, in [0, 1]; cheap.
    asked
        Whether they were on different sides of a question, in full or at a glance, alone or with
        their groups.
    chance
        The highest of these, that what both sides share was found rightly; 0 if not asked.
    joined
        Whether one was laid on the other when their groups were joined.
    """

    first: int
    second: int
    evidence: float
    asked: bool
    chance: float
    joined: bool


@dataclass(frozen=True, eq=False, repr=False)
class Joined(FrozenState):
    """The answer of :func:`sherd.join`; arrays are numbered as the user's pieces are.

    Attributes
    ----------
    pieces
        In the order given.
    groups
        Numbers of the pieces that belong together, largest group first; foreign ones are alone.
    pairs
        All pairs, those with most evidence first.
    maps
        By (here, there), of pieces of one group: the point of `there` for each vertex of `here`,
        whether there is one, and how surely; made consistent around loops.
    cycle_before, cycle_after
        Mean distance between a vertex and where it comes back to around loops of three pieces, in
        sqrt(area) of the largest piece: of what joins said, and of `maps`; NaN without loops. A
        place of a group is known from one piece, so joins alone seldom make a loop.
    timings
        Seconds by stage.
    options, version
        As given, and of sherd.
    notices
        What was adapted in each piece, in sentences.
    likely
        Of pieces that were joined last, when nothing was sure any more, the chance that they are
        where they were laid; above a half.
    by_twin
        Those of them, in order, that are told by their twin alone: the mirror image of a limb lies
        on the other limb of the pair. So would that of another body of the same kind.
    unplaced
        Pieces that belong to their group and are on no map to it, in order: they have its skin
        somewhere, or they, or their mirror image, fill a gap of it, they look like a part of it or
        of its mirror image, they are half likely to lie on it, or the skin of either is recognized
        there, as what is of another kind is not, but where they lie is not likely enough. Another
        body's piece of the same kind may do so as well.
    sure
        Whether two pieces at least surely belong together, whatever is said of others.
    """

    pieces: tuple[TriangleMesh, ...]
    groups: tuple[tuple[int, ...], ...]
    pairs: tuple[PairAnswer, ...]
    maps: Mapping[tuple[int, int], SharedMap]
    cycle_before: float
    cycle_after: float
    timings: Mapping[str, float]
    options: AssembleOptions
    version: str = field(default=__version__)
    notices: tuple[tuple[str, ...], ...] = ()
    likely: Mapping[int, float] = field(default_factory=dict)
    by_twin: tuple[int, ...] = ()
    unplaced: tuple[int, ...] = ()
    sure: bool = False

    def __post_init__(self) -> None:
        if sorted(k for group in self.groups for k in group) != list(range(len(self.pieces))):
            raise InvalidMeshError("each piece belongs to exactly one group")
        for (here, there), found in self.maps.items():
            if len(found.points) != self.pieces[here].vertex_count:
                raise InvalidMeshError(f"the map of piece {here} to {there} has another length")
        for name in ("maps", "timings", "likely"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))
        if not set(self.by_twin) <= set(self.likely):
            raise InvalidMeshError("what a twin tells is likely, so `likely` has its chance")
        if not all(0 <= k < len(self.pieces) for k in self.unplaced):
            raise InvalidMeshError("what is unplaced is one of the pieces")

    def __repr__(self) -> str:
        sizes = ", ".join(str(len(group)) for group in self.groups)
        return f"Joined({len(self.pieces)} pieces in groups of {sizes})"

    def _repr_html_(self) -> str:
        rows = {
            "groups": "; ".join(", ".join(self.named(k) for k in group) for group in self.groups),
            "pairs asked": str(sum(pair.asked for pair in self.pairs)),
            "cycle error": f"{self.cycle_before:.4f} before, {self.cycle_after:.4f} after",
        }
        return table_html(f"{len(self.pieces)} pieces", rows)

    def named(self, number: int) -> str:
        """The name of a piece, and how likely it belongs there if that is not sure."""
        name = self.pieces[number].name
        if number in self.unplaced:
            return f"{name} (belongs; where it lies is not known)"
        if number not in self.likely:
            return name
        reason = " by its twin" if number in self.by_twin else ""
        return f"{name} (likely{reason}, {self.likely[number]:.2f})"

    @property
    def group_of(self) -> tuple[int, ...]:
        """(k,) the group of each piece."""
        found = np.empty(len(self.pieces), dtype=np.int64)
        for number, group in enumerate(self.groups):
            found[list(group)] = number
        return tuple(found.tolist())
