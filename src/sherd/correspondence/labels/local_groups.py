"""Small groups of nodes that look like a place and lie there as neighbors do, wherever that is.

A labeling has one label for each node. Where two shapes share a third of themselves, all the rest
agrees on some other place, and the right labels are in no labeling that could be started from;
they are among the similar labels of each node all the same. So each node with each of its similar
labels is asked how well its neighbors could follow, with similar labels of their own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.correspondence.labels.consistent import PLACE_WIDTH
from sherd.correspondence.labels.labeling import (
    NOWHERE_COST,
    SIMILARITY_STEP,
    Labeling,
    Problem,
    pair_costs,
    unary_cost,
)
from sherd.correspondence.labels.saved import PRICE_SHARE

__all__ = ["local_groups"]

# Similar labels of each node, as many as a first labeling has.
CANDIDATES = 30
# Neighbors within two spacings of nodes: farther away similar labels rarely have the right one for
# all. With 0.2 right groups came later and fewer (12 pairs of a wolf's pieces), with 0.3 half.
REACH = 0.12
# A pair of neighbors off by two sigma is in conflict; nothing is said for it.
CONFLICT = 2.0
# A node joins a group if it fits its neighbors there half as well as perfectly.
FITS = 0.5
# Three rings of neighbors around the first one: the largest neighborhood that is compared.
RINGS = 3


def local_groups(problem: Problem, chance: float, count: int) -> list[Labeling]:
    """At most `count` labelings with a group of neighbors placed in each, the best supported first.

    Parameters
    ----------
    problem
        Whose price does not count.
    chance
        Energy per node where nothing belongs together.
    count
        How many groups.
    """
    near = _Near.of(problem, chance)
    support = near.support()
    order = np.argsort(-support, axis=None, kind="stable")
    groups: list[Labeling] = []
    for best in order:
        node, choice = divmod(int(best), support.shape[1])
        if len(groups) == count or support[node, choice] <= 0:
            break
        label = near.labels[node, choice]
        if not any(_said(problem, group, node, label) for group in groups):
            groups.append(near.group(node, choice))
    return groups


def _said(problem: Problem, group: Labeling, node: int, label: int) -> bool:
    """Whether a group lays a node about there already."""
    if not group.placed[node]:
        return False
    return bool(problem.labels.between[group.labels[node], label] < PLACE_WIDTH)


@dataclass(frozen=True, eq=False)
class _Near:
    """Similar labels of all nodes and how those of near neighbors fit each other.

    Attributes
    ----------
    labels, rotations
        (k, c) candidates.
    alike
        (k, c) in [0, 1]: 1 if as alike as the best, 0 if not worth the price of nowhere.
    edges, weights
        (e, 2) near neighbors and (e,) what each pair weighs.
    fits
        (e, c, c) in [0, 1]: 1 for the same length and directions, 0 in conflict.
    """

    labels: Ints
    rotations: Floats
    alike: Floats
    edges: Ints
    weights: Floats
    fits: Floats

    @classmethod
    def of(cls, problem: Problem, chance: float) -> _Near:
        """The most similar labels and what is known of neighbors within `REACH`."""
        labels = problem.most_similar(CANDIDATES)
        rotations = np.take_along_axis(problem.turns, labels, axis=1)
        near = problem.measures.length < REACH
        weights = problem.measures.weight[near]
        paid = pair_costs(problem, labels, rotations)[near] / weights[:, None, None]
        lacks = unary_cost(problem, labels, rotations, SIMILARITY_STEP)
        price = max(PRICE_SHARE * chance, 1e-12)
        return cls(
            labels,
            rotations,
            alike=np.clip(1.0 - lacks / price, 0.0, 1.0),
            edges=problem.edges[near],
            weights=weights,
            fits=np.clip(1.0 - paid / CONFLICT, 0.0, 1.0).astype(np.float64),
        )

    def support(self) -> Floats:
        """How well each candidate (k, c) is alike, times how well the neighbors could follow."""
        first, second = self.edges.T
        total, weight = np.zeros(self.alike.shape), np.zeros(len(self.alike))
        along = (self.fits * self.alike[second][:, None, :]).max(axis=2)
        back = (self.fits * self.alike[first][:, :, None]).max(axis=1)
        for end, best in ((first, along), (second, back)):
            np.add.at(total, end, self.weights[:, None] * best)
            np.add.at(weight, end, self.weights)
        result: Floats = self.alike * total / np.maximum(weight, 1e-12)[:, None]
        return result

    def group(self, node: int, choice: int) -> Labeling:
        """The node with its candidate, and ring by ring those that fit who is in it already."""
        chosen = np.full(len(self.alike), -1)
        chosen[node] = choice
        for _ in range(RINGS):
            joining = self._ring(chosen)
            if not (joining >= 0).any():
                break
            chosen = np.maximum(chosen, joining)
        placed: Bools = chosen >= 0
        rows, at = np.arange(len(chosen)), np.maximum(chosen, 0)
        local = np.where(placed, 0.0, NOWHERE_COST)
        return Labeling(self.labels[rows, at], self.rotations[rows, at], local, np.inf, placed)

    def _ring(self, chosen: Ints) -> Ints:
        """Of nodes (k,) beside those with a choice the candidate that fits, -1 where none does."""
        total, weight = np.zeros(self.alike.shape), np.zeros(len(chosen))
        for here, there in ((0, 1), (1, 0)):
            ends, others = self.edges[:, here], self.edges[:, there]
            rows = np.flatnonzero((chosen[ends] < 0) & (chosen[others] >= 0))
            to = chosen[others[rows]]
            fits = self.fits[rows, :, to] if here == 0 else self.fits[rows, to, :]
            np.add.at(total, ends[rows], self.weights[rows, None] * fits)
            np.add.at(weight, ends[rows], self.weights[rows])
        fit = total / np.maximum(weight, 1e-12)[:, None]
        best = (fit * self.alike).argmax(axis=1)
        rows = np.arange(len(best))
        joins = (fit[rows, best] > FITS) & (self.alike[rows, best] > 0)
        joining: Ints = np.where(joins, best, -1)
        return joining
