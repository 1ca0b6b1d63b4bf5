"""Trials: where each piece may lie, found for each alone, and what is asked of the joint choice."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import logit

from sherd.arrays import Bools, Floats
from sherd.correspondence.confidence import measured_chance
from sherd.errors import InfeasibleError
from sherd.mesh.sides import bulge
from sherd.mesh.sizes import check_sizes
from sherd.output import Stages
from sherd.place import PlacedPart, labeled_part, laid_part, placed_part
from sherd.puzzle.against import alike_there, log_odds_against, lowered
from sherd.puzzle.border import border_of
from sherd.puzzle.company import choice_in_company
from sherd.puzzle.joint_choice import LEAST_CHANCE, Candidate, shared_areas
from sherd.puzzle.partition import Partition
from sherd.puzzle.rigid.motion import RigidMotion
from sherd.results.advice import FOREIGN, SURE
from sherd.results.match_options import MatchOptions
from sherd.scan.either_side import SURE_BULGE, better_side
from sherd.scan.intake import Intake
from sherd.surface.template import Template

__all__ = [
    "CLASH",
    "MARGIN",
    "SCORE_SCALE",
    "Together",
    "Trial",
    "chosen_together",
    "clashes",
    "each_tried",
    "sure_of_side",
    "trial_chance",
    "trials_alone",
    "trials_of",
    "without_the_unlikely",
]

# Regions are claimed surely but for a strip of two vertex spacings along the border.
MARGIN = 0.02
# Two pieces clash if they claim more of the smaller one than right neighbors ever do.
CLASH = 0.3
# Placements whose regions have less in common than this are two places.
ANOTHER = 0.5
# A placement with a score lower by this is a third as likely to be right: as far apart as match
# takes a twin for plausible.
SCORE_SCALE = 0.1
# What is labeled turned over with so many times the energy of the first side is not laid, which is
# two thirds of the work. Of 22 pieces in doubt, in 21 puzzles of animals and people, that were
# turned over 15 are above, and none had a higher score. Elsewhere it would not do: of a horse in
# eight pieces a further trial that is above is needed.
LOST = 1.3

# Of one, the logit of the chance that match gives, and the score. A logistic regression over 63
# trials of six puzzles cut from a horse, a lion, a cat and a man, 40 of the trials right (error
# below 0.05), 23 of foreign pieces or in wrong places. The chance was made for parts of a fifth of
# a shape and more; of small ones, and where places are forbidden, the score tells more. With each
# puzzle held out in turn the area under the ROC is 0.85; of the chance alone, on all, it is 0.88,
# of this 0.91.
COEFFICIENTS = (-4.8, 0.29, 8.1)
# Where odds are lowered by a factor of e and more a piece must reach for its place as much as any
# other does. Of less a large piece of a cat or a lion would be refused that lies right, whose pose
# stretches its skin (alike by 0.29 and 0.32), and with it what lies beside it.
CLEARLY = -1.0


@dataclass(frozen=True, eq=False)
class Trial:
    """One piece, placed once; what it asks of the joint choice.

    Attributes
    ----------
    piece
        Its number.
    placed
        The placement, the best of both.
    partition
        Of the full shape, which knows how deep a vertex lies in a region.
    candidate
        Its region, the core of it, its border and its chance to be right.
    motion
        What brings a rigid piece there; None if it is not rigid.
    against
        What speaks against the place, in log odds, at most 0; nothing was laid by it.
    alike
        How alike its skin is there; None if that is not known, as of a rigid piece.
    """

    piece: int
    placed: PlacedPart
    partition: Partition
    candidate: Candidate
    motion: RigidMotion | None = None
    against: float = 0.0
    alike: float | None = None

    @property
    def chance(self) -> float:
        """That it is right."""
        return self.candidate.chance

    def lowered(self, chance: float) -> float:
        """The chance that it is right, by all else, if what speaks against it is asked as well."""
        return lowered(chance, self.against)

    @property
    def is_unlikely(self) -> bool:
        """Whether it is so unlikely, among the others, that it is not given a place."""
        return self.chance < (LEAST_CHANCE if self.against <= CLEARLY else FOREIGN)

    def with_chance(self, chance: float) -> Trial:
        """The same place, held to be as likely."""
        return replace(self, candidate=replace(self.candidate, chance=chance))


@dataclass(frozen=True, eq=False)
class Together:
    """What was chosen for all pieces together.

    Attributes
    ----------
    trials
        By piece the one that was chosen, with its chance among the others; refused ones have none.
    energy
        Of the choice.
    proven
        Whether no choice is better by the same chances; False if the search was broken off.
    """

    trials: dict[int, Trial]
    energy: float
    proven: bool


def trial_at(
    piece: int,
    placed: PlacedPart,
    partition: Partition,
    chance: float,
    motion: RigidMotion | None = None,
) -> Trial:
    """A piece placed once, with what it would claim."""
    best = placed.best
    border = border_of(placed.question.part.mesh, best.deformation.positions)
    core = partition.core(best.mask, MARGIN)
    return Trial(piece, placed, partition, Candidate(best.mask, core, chance, border), motion)


def trials_alone(
    template: Template,
    intakes: Sequence[Intake],
    options: MatchOptions,
    stages: Stages,
    partition: Partition,
) -> tuple[list[Trial], dict[int, str]]:
    """Each piece placed as if it were alone; of those that cannot lie there, the reason."""

    def tried(piece: int, intake: Intake) -> list[Trial]:
        return trials_of(piece, _placed(template, intake, options, stages), partition)

    return each_tried(template, intakes, tried)


def each_tried(
    template: Template,
    intakes: Sequence[Intake],
    tried: Callable[[int, Intake], list[Trial]],
) -> tuple[list[Trial], dict[int, str]]:
    """The trials of all pieces; of those that cannot lie on the full shape, the reason."""
    found: list[Trial] = []
    refused: dict[int, str] = {}
    for piece, intake in enumerate(intakes):
        try:
            check_sizes(template.intake.mesh, intake.mesh)
            found += tried(piece, intake)
        except InfeasibleError as error:
            refused[piece] = str(error)
    return found, refused


def chosen_together(
    trials: Sequence[Trial], count: int, areas: Floats, *, may_overlap: bool = False
) -> Together:
    """The trials that are chosen jointly, with their chances among each other.

    Parameters
    ----------
    trials
        Of `count` pieces; those that are refused have none in the answer.
    areas, may_overlap
        As in :func:`sherd.puzzle.joint_choice.joint_choice`.

    Notes
    -----
    A gap that a piece fills speaks for it in the choice, but not for the chance that is given: see
    :mod:`sherd.puzzle.company`. So a copy of a piece that lies somewhere else, or a piece of
    something else that was bent into a gap, may be chosen for one of about its size. What has so
    small a chance then that a match would be said not to belong, or less than a piece must reach
    for a place where something clearly speaks against it, is taken out of the trials, and the rest
    is chosen anew.
    """

    def chosen(left: Sequence[Trial]) -> Together:
        own = [[trial for trial in left if trial.piece == k] for k in range(count)]
        return _chosen_together(own, areas, may_overlap=may_overlap)

    return without_the_unlikely(trials, chosen)


def without_the_unlikely(
    trials: Sequence[Trial], choose: Callable[[Sequence[Trial]], Together]
) -> Together:
    """What is chosen of trials, once what is unlikely then was taken out, one after another."""
    left = list(trials)
    while True:
        found = choose(left)
        unlikely = [trial for trial in found.trials.values() if trial.is_unlikely]
        if not unlikely:
            return found
        least = min(unlikely, key=lambda trial: trial.chance)
        left = [each for each in left if each.candidate.region is not least.candidate.region]


def _chosen_together(
    own: Sequence[Sequence[Trial]], areas: Floats, *, may_overlap: bool
) -> Together:
    """The same, however unlikely what is chosen is."""
    choice, among = choice_in_company(
        [[trial.candidate for trial in some] for some in own], areas, may_overlap=may_overlap
    )
    judged = [
        [
            replace(each, chance=trial.lowered(each.chance))
            for trial, each in zip(some, those, strict=True)
        ]
        for some, those in zip(own, among, strict=True)
    ]
    chosen = {}
    for k, c in enumerate(choice.candidates.tolist()):
        if c >= 0:
            chosen[k] = own[k][c].with_chance(judged[k][c].chance)
    found = {
        k: trial.with_chance(
            _chance_of_places(
                judged[k][int(choice.candidates[k])],
                _elsewhere(int(choice.candidates[k]), own[k], judged[k]),
                [other.candidate.core for i, other in chosen.items() if i != k],
                areas,
            )
        )
        for k, trial in chosen.items()
    }
    return Together(found, choice.energy, choice.proven)


def _chance_of_places(
    best: Candidate, others: Sequence[Candidate], taken: Sequence[Bools], areas: Floats
) -> float:
    """The chance of the best of the places where a piece may lie, of which one at most is right.

    Odds against lying nowhere are o = p / (1 - p), so it is o / (1 + o + o'), o' being those of the
    likeliest other place that is not taken.
    """
    occupied = np.logical_or.reduce([np.zeros(len(areas), dtype=bool), *taken])
    odds = [
        _odds(each.chance)
        for each in others
        if areas @ (each.core & occupied) <= CLASH * (areas @ each.core)
    ]
    return _odds(best.chance) / (1.0 + _odds(best.chance) + max(odds, default=0.0))


def _odds(chance: float) -> float:
    return chance / (1.0 - chance)  # a chance is never 1


def _elsewhere(
    chosen: int, trials: Sequence[Trial], judged: Sequence[Candidate]
) -> list[Candidate]:
    """The trials of one piece, as judged, that are at another place than the chosen one."""
    return [
        each
        for k, each in enumerate(judged)
        if k != chosen and _are_two_places(trials[chosen], trials[k])
    ]


def _are_two_places(one: Trial, other: Trial) -> bool:
    """Whether two trials of one piece are two places: of rigid ones each motion is.

    A piece that is turned in its place covers the same, but no point of it lies where it did.
    """
    rigid = one.motion is not None and other.motion is not None
    return rigid or _is_another(one.candidate.region, other.candidate.region)


def _is_another(region: Bools, other: Bools) -> bool:
    """Whether two regions (n,) have so little in common that they are two places."""
    both, either = np.count_nonzero(region & other), np.count_nonzero(region | other)
    return bool(both < ANOTHER * either)


def clashes(trials: Sequence[Trial], areas: Floats) -> dict[int, set[int]]:
    """By piece the pieces that lie in the same place, of these trials."""
    if not trials:
        return {}
    shared = shared_areas([trial.candidate.core for trial in trials], areas)
    own = np.diag(shared)
    found: dict[int, set[int]] = {}
    for here, trial in enumerate(trials):
        for there, other in enumerate(trials):
            least = CLASH * min(own[here], own[there])
            if other.piece != trial.piece and shared[here, there] > least:
                found.setdefault(trial.piece, set()).add(other.piece)
    return found


def _placed(
    template: Template, intake: Intake, options: MatchOptions, stages: Stages
) -> PlacedPart:
    """The piece placed, on the other side too where that may be outside."""

    def turned(part: Intake, found: PlacedPart) -> PlacedPart | None:
        labeled = labeled_part(template, part, options, stages, twin=False)
        lost = labeled.energy > LOST * found.labeling_energy
        return None if lost else laid_part(labeled, stages)

    return better_side(
        intake,
        options.side,
        lambda side: placed_part(template, side, options, stages, twin=False),
        score=lambda placed: placed.best.score,
        sure=lambda part, placed: sure_of_side(part, placed.chance),
        rival=turned,
    )


def sure_of_side(part: Intake, chance: float) -> bool:
    """Whether a piece that lies where it does with this chance need not be turned over."""
    if chance < SURE:
        return part.side_known and len(part.mesh.boundary_vertices) == 0
    return part.side_known or bulge(part.mesh) >= SURE_BULGE


def trial_chance(chance: float, score: float) -> float:
    """The chance that a placement is right, by that of :func:`sherd.match` and its score."""
    # a chance is never 0 or 1
    features = np.array([1.0, logit(chance), score])
    return measured_chance(float(features @ np.array(COEFFICIENTS)))


def trials_of(piece: int, placed: PlacedPart, partition: Partition) -> list[Trial]:
    """The placement, and the other one if it is another place.

    A rival elsewhere is none: two legs on each other's places, or a large piece on a missing one's,
    may fit and fill the whole a little better. Who lies in each other's way is asked elsewhere.
    """
    chance = trial_chance(placed.chance, placed.best.score)
    found = [trial_at(piece, placed, partition, chance)]
    best, other = placed.best, placed.other
    if _is_another(best.mask, other.mask):
        less = float(np.exp((other.score - best.score) / SCORE_SCALE))
        swapped = replace(placed, best=other, other=best, rival=best)
        found.append(trial_at(piece, swapped, partition, chance * less))
    return [_seen_there(trial) for trial in found]


def _seen_there(trial: Trial) -> Trial:
    """The same with what its skin and its folds say of the place."""
    best = trial.placed.best
    alike = alike_there(best)
    return replace(trial, alike=alike, against=log_odds_against(best, alike))
