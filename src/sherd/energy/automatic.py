"""Automatic choice of lambda_r, which the paper leaves open: by the energy of the crisp region.

The relaxed problem is a means: what is wanted is a crisp region. So every candidate is relaxed,
thresholded to the part's area and cleaned, and the crisp regions are compared by one energy that
knows no relaxation and no lambda_r::

    crisp(M) = |P' A 1_M - q|^2 / |q|^2 + 0.2 * length(boundary of M) / sqrt(s)

Too little regularity makes ragged regions (long boundary), too much ignores the descriptors
(large residual), and both show here.

Examples
--------
>>> from sherd.energy.subspace import subspace_region
>>> choose = lambda problem, basis: chosen_regularity(
...     problem, lambda candidate: [subspace_region(candidate, basis).membership]
... )
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from sherd.arrays import Bools, Floats
from sherd.energy.cleanup import clean_region
from sherd.energy.mumford_shah import data_term
from sherd.energy.problem import RegionProblem
from sherd.errors import OptionError
from sherd.mesh import topology

__all__ = ["REGULARITIES", "RegularityChoice", "chosen_regularity", "crisp_energy"]


# Half decades around 0.1. Below, all-vertex answers are ragged; above, smoothness wins over any
# descriptor, because a membership that is constant costs at most 1 in the data term.
REGULARITIES = (0.01, 0.03, 0.1, 0.3, 1.0)
# What a boundary of length sqrt(s) is worth, in relative data residual squared. On 13 pairs of the
# generated animal (4 solvers and descriptors) any value from 0.1 to 0.3 chose within 2 IoU points
# of the best candidate; a limb's single cut costs 0.2, a scattered region several times that.
BOUNDARY_WORTH = 0.2


@dataclass(frozen=True, eq=False)
class RegularityChoice:
    """The choice and what it was made from.

    Attributes
    ----------
    regularity
        The chosen lambda_r.
    membership
        (n,), the relaxed answer there.
    core
        (n,) bool, its crisp region, of the problem's area.
    answer
        Which of the memberships at that regularity, from 0.
    regularities, energies
        All candidates with the crisp energy of the best answer of each.
    """

    regularity: float
    membership: Floats
    core: Bools
    answer: int
    regularities: tuple[float, ...]
    energies: tuple[float, ...]


def chosen_regularity(
    problem: RegionProblem,
    solve: Callable[[RegionProblem], Sequence[Floats]],
    *,
    candidates: Sequence[float] = REGULARITIES,
) -> RegularityChoice:
    """The lambda_r whose crisp region has the least crisp energy.

    Parameters
    ----------
    problem
        The energy; its own regularity is not used.
    solve
        Called with the problem under each candidate; returns memberships (n,), one or several.
    candidates
        Values of lambda_r to try; ties go to the earlier one.

    Raises
    ------
    OptionError
        If there is no candidate or `solve` returns nothing.
    """
    if not candidates:
        raise OptionError("no candidate for the regularity was given")
    adjacency = topology.adjacency(problem.faces, problem.vertex_count)
    best: RegularityChoice | None = None
    least, energies = np.inf, []
    for regularity in candidates:
        weights = replace(problem.weights, regularity=regularity)
        found = []
        for number, membership in enumerate(solve(problem.with_weights(weights))):
            core = clean_region(
                membership, problem.vertex_areas, problem.part_area, adjacency=adjacency
            )
            found.append(crisp_energy(problem, core))
            if found[-1] < least:
                least = found[-1]
                best = RegularityChoice(regularity, membership, core, number, (), ())
        if not found:
            raise OptionError("the solver returned no membership")
        energies.append(min(found))
    if best is None:
        raise OptionError("no candidate for the regularity gave a finite energy")
    return replace(best, regularities=tuple(candidates), energies=tuple(energies))


def crisp_energy(problem: RegionProblem, mask: Bools) -> float:
    """Energy of a crisp region (n,) bool; see the module docstring.

    The length of the boundary is the total variation of the mask, which on a mesh runs along
    edges and is up to 1.3 times the length of a smooth curve; the same for every candidate.
    """
    indicator = mask.astype(np.float64)
    slopes = (problem.gradient @ indicator).reshape(-1, 3)
    length = float(problem.face_areas @ np.linalg.norm(slopes, axis=1))
    return data_term(problem, indicator) + BOUNDARY_WORTH * length / math.sqrt(problem.part_area)
