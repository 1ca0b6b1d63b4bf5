"""Which placement of each piece, or none: all pieces decided together.

    E(c) = - sum_i s_i area(R_i)        s_i = (p_i - p_0) / (1 - p_0)
           + omega (sum_i |border R_i| - sum_{i < j} |border R_i and border R_j facing|)
           + kappa sum_{i < j} max(s_i, s_j, 0) area(R_i and R_j)

over the choice c of one candidate, with region R_i and chance p_i to be right, or none for each
piece. What two share is taken from their cores, which leave out a strip along the border where
placements are inexact, as a share of the smaller one. It is the multi-phase Mumford-Shah energy

    E(u) = sum_i integral u_i f_i + (omega / 2) sum_i Per(u_i),    u_0 + u_1 + ... + u_k = 1

for memberships that are constant on the candidates' regions and a gap, i = 0, at no price: what is
no more likely to be right than p_0 is left out; a border against the gap is paid for, one that two
pieces share only once, so a piece that fills a hole costs none; and a place that is used twice,
where memberships cannot sum to 1, is paid for with more than the surer of both gains there. Two
that are hardly sure may reach into each other's places, as their borders are off; a sure one gives
nothing up.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from sherd.arrays import Bools, Floats, Ints
from sherd.puzzle.border import Border, facing_lengths

__all__ = [
    "LEAST_CHANCE",
    "MOST_NODES",
    "Candidate",
    "Choice",
    "Ties",
    "choice_among",
    "energy_of",
    "joint_choice",
    "shared_areas",
    "ties_of",
]

# Price of area that two pieces claim, over what the surer one gains by it. Above 1, so that what
# lies wholly where a surer piece lies is refused; not far above, so that two sure scans may share
# two thirds of one.
KAPPA = 1.25
# What a piece must reach for a place: foreign pieces on whole shapes had 0.27 and less, but for one
# of five (0.52), right ones 0.25 and more, so borders and places taken must tell some apart.
LEAST_CHANCE = 0.2
# Price of border against the gap, in sqrt(area): a disk of 2 % of the area that touches no other
# must be 0.6 sure, one of a tenth 0.4. Half as much chooses alike on cats in three and in twelve
# pieces, but takes a foreign piece with a chance of 0.24 that lies in the open but for 0.4 of its
# border; from 0.012 on that one is refused.
OMEGA = 0.02
# Nodes of the search; puzzles of a dozen pieces need some dozens, 20 pieces with three likely
# places each on a ring some ten thousand. Beyond it, after a third of a second, the best choice
# that was found stands: thirty alike pieces are chosen anew a hundred times while they are placed.
MOST_NODES = 40_000


@dataclass(frozen=True, eq=False)
class Candidate:
    """One place where a piece may lie.

    Attributes
    ----------
    region
        (n,) bool, the vertices of the full shape that it covers.
    core
        (n,) bool, those of them that are not near its border: what it surely claims.
    chance
        That the piece belongs there.
    border
        Its border on the full shape, at unit scale.
    """

    region: Bools
    core: Bools
    chance: float
    border: Border


@dataclass(frozen=True)
class Choice:
    """One candidate for each piece.

    Attributes
    ----------
    candidates
        (k,) number of each piece's candidate, -1 for none.
    energy
        Of the choice; 0 is that of none at all.
    proven
        Whether no choice is better; False if the search was broken off.
    nodes
        Of the search, that were looked at.
    """

    candidates: Ints
    energy: float
    proven: bool
    nodes: int = 0


@dataclass(frozen=True, eq=False)
class Ties:
    """What the candidates of all pieces have to do with each other, whatever their chances.

    Attributes
    ----------
    count
        Of pieces.
    owner, number
        (c,) the piece of each candidate, and which of its candidates it is.
    chances
        (c,) of the candidates as they came.
    regions, lengths
        (c,) area of each region and length of its border.
    facing
        (c, c) length along which two borders face each other.
    cores
        (c, c) area that two cores have in common; on the diagonal that of one.
    """

    count: int
    owner: Ints
    number: Ints
    chances: Floats
    regions: Floats
    lengths: Floats
    facing: Floats
    cores: Floats

    @property
    def claimed_twice(self) -> Floats:
        """(c, c) area of the smaller region that two claim: as much of it as of its core.

        Cores alone would make it cheap to lay one hand on another: most of a finger is near its
        border.
        """
        own = np.diag(self.cores)
        share = self.cores / np.maximum(np.minimum.outer(own, own), 1e-12)
        claimed: Floats = np.minimum(share, 1.0) * np.minimum.outer(self.regions, self.regions)
        return claimed


def ties_of(pieces: Sequence[Sequence[Candidate]], areas: Floats) -> Ties:
    """The ties of the candidates of each piece; `areas` (n,) are of the full shape's vertices."""
    flat = [(k, c) for k, some in enumerate(pieces) for c in range(len(some))]
    some = [pieces[k][c] for k, c in flat]
    pairs = np.array(flat, dtype=np.int64).reshape(-1, 2)
    return Ties(
        count=len(pieces),
        owner=pairs[:, 0],
        number=pairs[:, 1],
        chances=np.array([each.chance for each in some]),
        regions=np.array([float(areas @ each.region) for each in some]),
        lengths=np.array([each.border.length for each in some]),
        facing=facing_lengths([each.border for each in some]),
        cores=shared_areas([each.core for each in some], areas),
    )


def joint_choice(
    pieces: Sequence[Sequence[Candidate]], areas: Floats, *, may_overlap: bool = False
) -> Choice:
    """The choice of least energy; see the module.

    Parameters
    ----------
    pieces
        Candidates of each piece.
    areas
        (n,) of the vertices of the full shape.
    may_overlap
        Whether a place may be used twice at no price.
    """
    ties = ties_of(pieces, areas)
    return choice_among(ties, ties.chances, may_overlap=may_overlap)


def choice_among(
    ties: Ties,
    chances: Floats,
    *,
    may_overlap: bool = False,
    start: Ints | None = None,
    most_nodes: int | None = None,
) -> Choice:
    """The choice of least energy by these chances (c,) of the candidates.

    Parameters
    ----------
    ties, chances
        Of all candidates.
    may_overlap
        As in :func:`joint_choice`.
    start
        A choice (k,) that a better one is looked for to; none at all if None.
    most_nodes
        When the search is broken off; `MOST_NODES` if None.

    Notes
    -----
    Branch and bound, piece after piece by descending gain, in groups that share places: exact,
    unless it is broken off.
    """
    gain, cost = _gain_and_cost(ties, chances, may_overlap=may_overlap)
    chosen = np.full(ties.count, -1, dtype=np.int64)
    begun = np.zeros(len(gain), dtype=bool) if start is None else ties.number == start[ties.owner]
    left = MOST_NODES if most_nodes is None else most_nodes
    energy, proven, nodes = 0.0, True, 0
    for group in _groups(ties.owner, cost, ties.count):
        known = np.flatnonzero(begun & np.isin(ties.owner, group))
        search = _Search(group, ties.owner, gain, cost, known, left - nodes)
        energy -= search.best_gain
        proven = proven and not search.broken_off
        nodes += search.nodes
        for row in search.best:
            chosen[ties.owner[row]] = ties.number[row]
    return Choice(chosen, energy, proven, nodes)


def energy_of(ties: Ties, chances: Floats, candidates: Ints, *, may_overlap: bool = False) -> float:
    """The energy of a choice (k,) by these chances (c,) of all candidates."""
    gain, cost = _gain_and_cost(ties, chances, may_overlap=may_overlap)
    taken = np.flatnonzero(ties.number == candidates[ties.owner])
    return float(0.5 * cost[np.ix_(taken, taken)].sum() - gain[taken].sum())


def _gain_and_cost(ties: Ties, chances: Floats, *, may_overlap: bool) -> tuple[Floats, Floats]:
    """What each candidate (c,) gains by itself, and what each two of them (c, c) cost together."""
    sure = (chances - LEAST_CHANCE) / (1 - LEAST_CHANCE)
    gain = ties.regions * sure - OMEGA * ties.lengths
    cost = -OMEGA * ties.facing
    if not may_overlap:
        surest = np.maximum(np.maximum.outer(sure, sure), 0.0)
        cost = cost + KAPPA * surest * ties.claimed_twice
    cost[ties.owner[:, None] == ties.owner[None, :]] = 0.0
    return gain, cost


def shared_areas(masks: Sequence[Bools], areas: Floats) -> Floats:
    """(c, c) area that each two of the masks (n,) have in common."""
    table = np.array(masks, dtype=np.float64).reshape(len(masks), len(areas))
    shared: Floats = (table * areas) @ table.T
    return shared


def _groups(owner: Ints, cost: Floats, count: int) -> list[Ints]:
    """Pieces in groups; candidates of different groups share nothing."""
    first, second = np.nonzero(cost)
    links = sparse.coo_array(
        (np.ones(len(first)), (owner[first], owner[second])), shape=(count, count)
    )
    number, labels = csgraph.connected_components(links.tocsr(), directed=False)
    return [np.flatnonzero(labels == group) for group in range(number)]


class _Search:
    """Depth first through the pieces of one group.

    What the rest can still gain is at most the sum over its pieces of the best candidate's gain,
    less what that costs beside those that are taken, and with half of each border that it can share
    with the rest, as that pays for both.
    """

    def __init__(
        self, group: Ints, owner: Ints, gain: Floats, cost: Floats, known: Ints, most_nodes: int
    ) -> None:
        # at best a candidate has all the borders that it can share with the others' best
        reward = np.maximum(-cost, 0.0)
        of_piece = [np.flatnonzero(owner == piece) for piece in group]
        most = gain + sum(
            (reward[:, some].max(axis=1) for some in of_piece if len(some)), np.zeros(len(gain))
        )
        options = [some[most[some] > 0] for some in of_piece]
        options = sorted(
            (some for some in options if len(some)), key=lambda some: -most[some].max()
        )
        self._rows = np.concatenate([*options, np.empty(0, dtype=np.int64)])
        self._starts = np.cumsum([0, *map(len, options)])
        self._cost = cost[np.ix_(self._rows, self._rows)]
        self._halves = self._half_rewards(reward[np.ix_(self._rows, self._rows)])
        self._most_nodes = most_nodes
        self.nodes = 0
        self.broken_off = False
        self.best = known.tolist()
        self.best_gain = float(gain[known].sum() - 0.5 * cost[np.ix_(known, known)].sum())
        if self.best_gain <= 0.0:
            self.best, self.best_gain = [], 0.0
        self._descend(0, [], 0.0, gain[self._rows])

    def _half_rewards(self, reward: Floats) -> list[Floats]:
        """By depth, for each candidate of the rest, half of the borders that it can share with it.

        With one candidate of each piece of the rest, the best.
        """
        starts = self._starts[:-1]
        if not len(starts):
            return []
        of_piece = np.maximum.reduceat(reward, starts, axis=1)
        of_rest = np.cumsum(of_piece[:, ::-1], axis=1)[:, ::-1]
        return [0.5 * of_rest[start:, depth] for depth, start in enumerate(starts)]

    def _descend(self, depth: int, taken: list[int], total: float, left: Floats) -> None:
        """`left` (r,) is what each candidate of the rest gains beside those that are taken."""
        if self.nodes >= self._most_nodes:
            self.broken_off = True
            return
        self.nodes += 1
        if total > self.best_gain:
            self.best, self.best_gain = list(taken), total
        if depth == len(self._halves):
            return
        starts = self._starts[depth:]
        hoped = left + self._halves[depth]
        tops = np.maximum.reduceat(hoped, starts[:-1] - starts[0])
        if total + float(np.maximum(tops, 0.0).sum()) <= self.best_gain:
            return
        count = int(starts[1] - starts[0])
        for number in np.argsort(-hoped[:count], kind="stable").tolist():
            row = int(starts[0]) + number
            further = left[count:] - self._cost[row, starts[1] :]
            self._descend(
                depth + 1, [*taken, int(self._rows[row])], total + float(left[number]), further
            )
        self._descend(depth + 1, taken, total, left[count:])
