"""The joint choice with neighbors as evidence: a piece that fills a gap is likely to belong there.

Appearance and deformation say how likely a piece lies right alone, whoever its neighbors are. Where
pieces were cut apart their borders coincide, and a piece in a wrong place meets others along a part
of its border only, and has not the size and shape of what the others leave. So the chances p of the
candidates are judged again among the pieces of a choice c,

    logit p' = logit p + W (max(phi - lambda - 1/2, 0) + max(g - 1/2, 0)),

phi being the share of its border that faces those of the chosen pieces, lambda the share of its
core that is in theirs, and g the intersection over union of its region with the gap that all of
them leave. What lies on another piece closes no hole. A border that meets nothing and a gap that is
larger say nothing against a piece: its neighbor may be missing, and pieces that overlap have
borders inside each other.

Chances depend on the choice and the choice on chances. Wanted is the choice of least E(c; p'(c)),
the energy of :mod:`sherd.puzzle.joint_choice`, among those that are settled: none is better by the
same chances. So each piece pays for itself, and what is unlikely is not taken for what it does to
the chances of its neighbors. Two neighbors may be right only together, so the choice by the chances
alone is not enough to begin with: every other candidate that would be likely enough in its piece's
stead is put into the choice, which then settles again.

That a place is one where a piece of such size and shape belongs does not say which of two alike
ones it is: two legs in each other's places leave no gap. So the chances that are given in the end
count borders only, and less.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.correspondence.confidence import MOST
from sherd.puzzle.joint_choice import (
    LEAST_CHANCE,
    MOST_NODES,
    Candidate,
    Choice,
    Ties,
    choice_among,
    energy_of,
    ties_of,
)

__all__ = ["choice_in_company"]

# Of the logit, for all of a border, and for a gap that is filled to the last vertex. The slopes of
# a logistic regression with the logit of the chance alone as an offset, over 105 trials of thirteen
# puzzles of animated animals in three and five pieces, 61 of the trials right (intersection over
# union with the true cell above 0.6). The mean logarithmic loss of 132 trials of 23 other puzzles
# of these animals falls from 0.39 to 0.19 by them.
CHOOSING = (12.0, 7.0)
# Of the chances that are given. The slope of the same for borders alone, over 94 trials of twelve
# of these puzzles, 56 of them right (error below 0.05), when chances alone were higher.
GIVEN = (4.7, 0.0)
# Of those 94 trials the ones that lay somewhere else, but on no other piece, met others along at
# most 0.54 of their borders. Of the gap wrong ones filled 0.46 of the thirteen puzzles.
BY_CHANCE = 0.5
# New neighbors change what is met; mostly the second choice is the last.
ROUNDS = 3
# From a better choice others are tried again, mostly to no avail; this bounds the time, as does it
# that all searches from other choices together have the nodes of the first one (MOST_NODES). Where
# these are spent what is left is an exchange of one candidate at a time.
SWEEPS = 4


def choice_in_company(
    pieces: Sequence[Sequence[Candidate]], areas: Floats, *, may_overlap: bool = False
) -> tuple[Choice, list[list[Candidate]]]:
    """The joint choice by chances among the chosen pieces, and the candidates with these chances.

    Parameters
    ----------
    pieces, areas, may_overlap
        As in :func:`sherd.puzzle.joint_choice.joint_choice`.
    """
    company = _Company(pieces, areas, may_overlap=may_overlap)
    best = company.settled(company.by_chances_alone())
    for _ in range(SWEEPS):
        before = best
        for start in company.others(before):
            found = company.settled(start)
            if found.settled and found.energy < best.energy:
                best = found
        if best is before:
            break
    judged = [list(some) for some in pieces]
    ties = company.ties
    given = company.chances_among(best.candidates, GIVEN)
    for piece, number, chance in zip(ties.owner, ties.number, given.tolist(), strict=True):
        judged[piece][number] = replace(judged[piece][number], chance=chance)
    return Choice(best.candidates, best.energy, company.proven), judged


@dataclass(frozen=True, eq=False)
class _Settled:
    """A choice whose chances followed it.

    Attributes
    ----------
    candidates
        (k,) number of each piece's candidate, -1 for none.
    energy, chances
        By the chances (c,) of all candidates among it.
    settled
        Whether no choice is better by these chances, as far as was looked.
    """

    candidates: Ints
    energy: float
    chances: Floats
    settled: bool


class _Company:
    """The candidates of all pieces, and how likely each is among a choice."""

    def __init__(
        self, pieces: Sequence[Sequence[Candidate]], areas: Floats, *, may_overlap: bool
    ) -> None:
        self.ties: Ties = ties_of(pieces, areas)
        self._areas, self._may_overlap = areas, may_overlap
        self._nodes_left = MOST_NODES
        # whether no search was broken off
        self.proven = True
        regions = [each.region for some in pieces for each in some]
        self._regions = np.array(regions, dtype=np.float64).reshape(-1, len(areas))

    def by_chances_alone(self) -> Ints:
        """The choice (k,) by what each is alone."""
        found = choice_among(self.ties, self.ties.chances, may_overlap=self._may_overlap)
        self.proven = found.proven
        return found.candidates

    def others(self, found: _Settled) -> Iterator[Ints]:
        """Choices (k,) with one candidate exchanged for another that is likely enough there.

        A chance among a choice does not depend on what that says of the candidate's own piece.
        """
        ties = self.ties
        likely = (found.chances >= LEAST_CHANCE) & ~self._is_in(found.candidates)
        for row in np.flatnonzero(likely):
            candidates = found.candidates.copy()
            candidates[ties.owner[row]] = ties.number[row]
            yield candidates

    def settled(self, candidates: Ints) -> _Settled:
        """What a choice (k,) becomes when chances and choices follow each other."""
        choice = Choice(candidates, 0.0, proven=True)
        for _ in range(ROUNDS):
            before = choice
            chances = self.chances_among(before.candidates, CHOOSING)
            choice = self._chosen_by(chances, before.candidates)
            if np.array_equal(choice.candidates, before.candidates):
                break
        chances = self.chances_among(choice.candidates, CHOOSING)
        return _Settled(
            candidates=choice.candidates,
            energy=energy_of(self.ties, chances, choice.candidates, may_overlap=self._may_overlap),
            chances=chances,
            settled=np.array_equal(choice.candidates, before.candidates),
        )

    def chances_among(self, candidates: Ints, weights: tuple[float, float]) -> Floats:
        """The chances (c,) of all candidates among those of other pieces in a choice (k,).

        Borders that meet and the gap that is filled have these weights.
        """
        ties = self.ties
        chosen = np.flatnonzero(self._is_in(candidates))
        other = ties.owner[:, None] != ties.owner[None, chosen]
        met = (ties.facing[:, chosen] * other).sum(axis=1) / np.maximum(ties.lengths, 1e-12)
        own = np.maximum(np.diag(ties.cores), 1e-12)
        lies_on = (ties.cores[:, chosen] * other).sum(axis=1) / own
        # where two borders are near both are counted, but no more than all of it is met
        closed = np.maximum(np.minimum(met, 1.0) - lies_on - BY_CHANCE, 0.0)
        filled = np.maximum(self._filled(chosen) - BY_CHANCE, 0.0)
        more = weights[0] * closed + weights[1] * filled
        odds = np.exp(more) * ties.chances / (1.0 - ties.chances)
        # what was sure alone is no less so
        chances: Floats = np.maximum(ties.chances, np.minimum(odds / (1.0 + odds), MOST))
        return chances

    def _chosen_by(self, chances: Floats, start: Ints | None) -> Choice:
        """The choice by these chances, or one better than `start` where no more nodes are left."""
        found = choice_among(
            self.ties,
            chances,
            may_overlap=self._may_overlap,
            start=start,
            most_nodes=self._nodes_left,
        )
        self._nodes_left -= found.nodes
        self.proven = self.proven and found.proven
        return found

    def _is_in(self, candidates: Ints) -> Bools:
        """(c,) bool, the candidates that a choice (k,) takes."""
        taken: Bools = self.ties.number == candidates[self.ties.owner]
        return taken

    def _filled(self, chosen: Ints) -> Floats:
        """(c,) intersection over union of regions with the gap that other pieces' chosen leave."""
        ties = self.ties
        covered = self._regions[chosen].sum(axis=0)
        filled = np.zeros(len(ties.owner))
        for piece in range(ties.count):
            rows = np.flatnonzero(ties.owner == piece)
            without = covered - self._regions[chosen[ties.owner[chosen] == piece]].sum(axis=0)
            gap = self._areas * (without == 0)
            both = self._regions[rows] @ gap
            either = float(gap.sum()) + ties.regions[rows] - both
            filled[rows] = both / np.maximum(either, 1e-12)
        return filled
