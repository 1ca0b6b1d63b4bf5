"""Assembly: which piece lies where on the whole, what is missing and what does not belong."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from sherd._version import __version__
from sherd.arrays import Floats, FrozenState, Ints, frozen
from sherd.errors import InvalidMeshError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.advice import SURE
from sherd.results.display import table_html
from sherd.results.match_result import MatchResult
from sherd.results.puzzle.assemble_options import AssembleOptions
from sherd.results.status import Status

__all__ = ["Assembly", "AssemblyCheck", "Contact", "Gap", "PieceAnswer", "SharedPlace"]

# Memberships sum to 1 but for rounding.
ROUNDING = 1e-9


@dataclass(frozen=True, eq=False, repr=False)
class PieceAnswer(FrozenState):
    """What was found out about one piece.

    Attributes
    ----------
    part
        The piece.
    placed
        Whether it has a place.
    reason
        Why it was refused, or what to think of its place, in a sentence.
    chance
        That it belongs where it lies or, refused, where it would lie; in [0, 1].
    match
        Its points and their confidence, as :func:`sherd.match` gives them; of a refused piece the
        best guess, None if there is none.
    instead
        The piece that has the place where a refused one fits; None if it is refused otherwise.
    transform
        (4, 4) rotation and translation that bring a rigid piece onto the full shape, in the unit of
        the files: `transform @ (x, y, z, 1)`; None unless rigid.
    """

    part: TriangleMesh
    placed: bool
    reason: str
    chance: float
    match: MatchResult | None = None
    instead: int | None = None
    transform: Floats | None = None

    def __post_init__(self) -> None:
        if self.placed and self.match is None:
            raise InvalidMeshError(f"{self.part.name} is placed, but has no points")
        if self.transform is not None:
            object.__setattr__(self, "transform", frozen(np.array(self.transform, dtype=float)))

    @property
    def sure(self) -> bool:
        """Whether it is placed and nothing speaks against its place."""
        good = self.match is not None and self.match.status is Status.GOOD
        return self.placed and good and self.chance >= SURE

    @property
    def on_full(self) -> TriangleMesh | None:
        """A rigid piece as it lies on the full shape, in its frame; None unless it is placed so."""
        if not self.placed or self.transform is None:
            return None
        turned = self.part.vertices @ self.transform[:3, :3].T
        return self.part.with_vertices(turned + self.transform[:3, 3])

    def __repr__(self) -> str:
        word = "placed" if self.placed else "refused"
        return f"PieceAnswer({self.part.name!r}: {word}, chance {self.chance:.2f})"


@dataclass(frozen=True)
class Contact:
    """Two pieces that touch.

    Attributes
    ----------
    first, second
        Numbers of the pieces, ascending.
    length
        Of their common border on the full shape, in its unit.
    apart
        Mean distance between the borders of both where they lie, in the unit of the full shape; NaN
        if no border is near the other.
    gap
        The same with a sign: positive where a crack is open, negative where the pieces overlap.
    """

    first: int
    second: int
    length: float
    apart: float
    gap: float


@dataclass(frozen=True)
class SharedPlace:
    """Area of the full shape that two placed pieces both cover, in its unit squared."""

    first: int
    second: int
    area: float


@dataclass(frozen=True)
class Gap:
    """One connected part of the full shape that no piece covers.

    Attributes
    ----------
    area
        In the unit of the full shape squared.
    vertex
        Of it, the one deepest inside.
    vertex_count
        Number of its vertices.
    """

    area: float
    vertex: int
    vertex_count: int


@dataclass(frozen=True)
class AssemblyCheck:
    """What :meth:`Assembly.check` re-derives.

    Attributes
    ----------
    sums_off
        Largest difference from 1 of the sum of all memberships of a vertex.
    area_ratio
        Area that was given to pieces over that of the placed pieces; below 1 where they overlap.
    passed
        Whether memberships are at least 0 and sum to 1, and nothing is given to a refused piece.
    """

    sums_off: float
    area_ratio: float
    passed: bool


@dataclass(frozen=True, eq=False, repr=False)
class Assembly(FrozenState):
    """The answer of :func:`sherd.assemble`; arrays are numbered as the user's shapes are.

    Attributes
    ----------
    full
        The whole.
    pieces
        One answer for each piece, in the order given.
    labels
        (n_full,) number of the piece that each vertex is given to; -1 is the gap.
    memberships
        (k, n_full) float in [0, 1]: how far each vertex belongs to each piece, soft at borders.
        The gap has what is missing to 1.
    gaps
        What no piece covers, largest first.
    contacts
        Which pieces touch, longest border first.
    shared
        Places that two pieces share, largest first.
    energy
        Of the joint choice of placements; 0 is that of none at all.
    timings
        Seconds by stage.
    options, version
        As given, and of sherd.
    notices
        What was adapted in the full shape, in sentences.
    proven
        Whether no joint choice of placements has less energy; False if the search for one was
        broken off, as many pieces with many alike places can be chosen in too many ways.
    """

    full: TriangleMesh
    pieces: tuple[PieceAnswer, ...]
    labels: Ints
    memberships: Floats
    gaps: tuple[Gap, ...]
    contacts: tuple[Contact, ...]
    shared: tuple[SharedPlace, ...]
    energy: float
    timings: Mapping[str, float]
    options: AssembleOptions
    version: str = field(default=__version__)
    notices: tuple[str, ...] = ()
    proven: bool = True

    def __post_init__(self) -> None:
        count = self.full.vertex_count
        labels = np.array(self.labels, dtype=np.int64)
        memberships = np.array(self.memberships, dtype=np.float64).reshape(-1, count)
        if labels.shape != (count,) or len(memberships) != len(self.pieces):
            raise InvalidMeshError(
                f"labels have shape {labels.shape} and memberships {memberships.shape}, but "
                f"({count},) and ({len(self.pieces)}, {count}) are needed"
            )
        object.__setattr__(self, "labels", frozen(labels))
        object.__setattr__(self, "memberships", frozen(memberships))
        object.__setattr__(self, "timings", MappingProxyType(dict(self.timings)))

    def __repr__(self) -> str:
        return (
            f"Assembly({len(self.placed)} of {len(self.pieces)} pieces placed on "
            f"{self.full.name!r}, gap {self.gap_share:.1%})"
        )

    def _repr_html_(self) -> str:
        rows = {
            "placed": ", ".join(self.pieces[k].part.name for k in self.placed) or "none",
            "refused": "; ".join(
                f"{piece.part.name}: {piece.reason}" for piece in self.pieces if not piece.placed
            )
            or "none",
            "gap": f"{self.gap_share:.1%} of the full shape",
        }
        return table_html(f"{len(self.pieces)} pieces on {self.full.name}", rows)

    @property
    def placed(self) -> tuple[int, ...]:
        """Numbers of the placed pieces."""
        return tuple(k for k, piece in enumerate(self.pieces) if piece.placed)

    @property
    def refused(self) -> tuple[int, ...]:
        """Numbers of the refused pieces."""
        return tuple(k for k, piece in enumerate(self.pieces) if not piece.placed)

    @property
    def status(self) -> Status:
        """Good if each placed piece is sure of its place, and one is; refusals are answers.

        And if no other choice of places is better.
        """
        known = [piece.sure for piece in self.pieces if piece.placed]
        good = bool(known) and all(known) and self.proven
        return Status.GOOD if good else Status.DOUBTFUL

    @property
    def gap_membership(self) -> Floats:
        """(n_full,) how far each vertex belongs to no piece."""
        rest: Floats = np.clip(1.0 - self.memberships.sum(axis=0), 0.0, 1.0)
        return rest

    @property
    def gap_area(self) -> float:
        """Area that no piece covers, in the unit of the full shape squared."""
        return float(self.full.vertex_areas @ (self.labels < 0))

    @property
    def gap_share(self) -> float:
        """The same as a share of the full shape."""
        return min(self.gap_area / self.full.area, 1.0)  # rounding

    def check(self) -> AssemblyCheck:
        """Re-derive sums and areas; see :class:`AssemblyCheck`."""
        total = self.memberships.sum(axis=0)
        off = float(np.maximum(total - 1.0, 0.0).max(initial=0.0))
        given = self.full.area - self.gap_area
        own = sum(
            piece.part.area * (1.0 if piece.match is None else piece.match.scale**2)
            for piece in self.pieces
            if piece.placed
        )
        least = float(self.memberships.min(initial=0.0))
        used = np.unique(self.labels[self.labels >= 0])
        passed = off <= ROUNDING and least >= 0 and set(used.tolist()) <= set(self.placed)
        return AssemblyCheck(off, given / own if own else float("nan"), passed)
