"""The chance that a placement as a whole is right: that the part belongs here at all."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sherd.arrays import Floats
from sherd.correspondence.confidence import measured_chance
from sherd.correspondence.labels.anchors import energy_ratio, first_labeling
from sherd.correspondence.labels.labeling import SAME_SCALE, labeling_problem
from sherd.correspondence.placements import anchor_problem
from sherd.correspondence.question import Question
from sherd.correspondence.working_placement import WorkingPlacement
from sherd.descriptors.rotation_shot import pooled_similarity, similarity, trusted_equally
from sherd.surface.described import RADII, DescribedSurface
from sherd.surface.transformed import mirrored

__all__ = [
    "FEATURELESS",
    "FEATURES",
    "belonging_chance",
    "first_energy_ratio",
    "mirrored_energies",
    "placement_chance",
    "placement_features",
    "self_likeness",
]

FEATURES = (
    "one", "first energy over chance", "energy over chance", "strain", "disagreement",
)  # fmt: skip
# A logistic regression over 49 placements: parts of a generated animal and of three animated ones
# on themselves in another pose, on each other, and six smooth shapes on all. None of 120 others was
# in it: of 40 right ones of SHREC'16 and FAUST (other people) two were below 0.65, of 68 foreign
# ones none was above 0.59, and of 24 parts on other species no wrong one was above 0.56. A fit
# to three times as many placements of the first kind was no better on those. Lack of similarity
# and the area of the part told nothing more.
COEFFICIENTS = (7.2, -9.7, -3.7, -0.4, -2.7)
# The same of the ratio of a first labeling alone, where no placement is known, and of the logarithm
# of the part's share of the area: small parts have fewer nodes far apart, and these tell places
# apart. Over 118 parts of the generated animal and of three animated ones on themselves and on
# each other, and smooth shapes: 3 of 41 that belong are below 0.65, none of 77 foreign ones is
# above. Of those 120 others 2 of 40 were below, none of 68 foreign ones above; on other species
# 20 of 24 were below.
FIRST_COEFFICIENTS = (9.1, -17.4, -0.96)
# Two placements farther apart disagree, and not more.
MOST_APART = 0.3
# Nodes farther apart than the two largest neighborhoods are wide see nothing in common.
FAR = 0.2
# Planes, spheres and tubes are like themselves by 0.9 and more everywhere, parts of animals by 0.7
# at most.
FEATURELESS = 0.85


def placement_features(
    part: DescribedSurface,
    best: WorkingPlacement,
    other: WorkingPlacement,
    energies: tuple[float, float],
    *,
    chance_energy: float,
) -> Floats:
    """Features (5,) of a placement, see `FEATURES`; near 0 when all is well.

    Energies of the first and of the last labeling over what they would be if nothing belonged
    together: the first has only similar places to choose from, so foreign parts do not bend into
    place; strain, and distance between the two placements, at most 0.3, means over the part.
    """
    areas = part.mesh.vertex_areas
    apart = best.distances_to(other)
    return np.array(
        [
            1.0,
            energies[0] / max(chance_energy, 1e-12),
            energies[1] / max(chance_energy, 1e-12),
            float(np.average(np.minimum(best.strain, 1.0), weights=areas)),
            float(np.average(np.minimum(apart, MOST_APART), weights=areas)),
        ]
    )


def self_likeness(part: DescribedSurface) -> float:
    """How similar far neighborhoods of the part are to each other on average, at most 1.

    Near 1 for a plane, a sphere or a tube, which fit wherever they fit at all.
    """
    nodes = part.sparse
    spectra = part.spectra_at(nodes.vertices)
    alike = similarity(spectra, trusted_equally(spectra, RADII))
    far = nodes.between > min(FAR, float(np.median(nodes.between)))
    np.fill_diagonal(far, val=False)
    return float(alike[far].mean()) if far.any() else 1.0


def placement_chance(features: Floats) -> float:
    """`1 / (1 + exp(-features @ coefficients))`, kept inside [0.005, 0.995]."""
    return measured_chance(float(features @ np.array(COEFFICIENTS)))


def first_energy_ratio(
    full: DescribedSurface, part: DescribedSurface, rng: np.random.Generator
) -> float:
    """Energy of a first labeling over what it would be if nothing belonged together.

    Says whether the part belongs at all without placing it: its nodes are labeled with the `coarse`
    samples of the full shape, which look as the `spread` vertices nearest to them do.
    """
    seen, labels = full.spread, full.coarse
    spectra = seen.axes.project(part.trusted_spectra(part.sparse.vertices))
    cells = labels.cells[seen.vertices]
    similar = pooled_similarity(seen.spectra, spectra, cells, len(labels))
    question = Question(full, part, SAME_SCALE, other_labels=labels)
    problem = labeling_problem(question, similar, rng)
    return energy_ratio(problem, first_labeling(problem), rng)


def mirrored_energies(questions: Sequence[Question], seed: int) -> list[float]:
    """Energies of first labelings of mirror images, one for each question.

    Of a left leg asked about a right one this is far lower than that of the leg itself. By chance
    both would cost the same.
    """
    return [
        first_labeling(
            anchor_problem(question.with_part(mirrored(question.part)), np.random.default_rng(seed))
        ).energy
        for question in questions
    ]


def belonging_chance(ratio: float, share: float) -> float:
    """The chance that the part belongs on the full shape.

    Parameters
    ----------
    ratio
        See :func:`first_energy_ratio`.
    share
        Area of the part over that of the full shape.
    """
    features = np.array([1.0, ratio, np.log(share)])
    return measured_chance(float(features @ np.array(FIRST_COEFFICIENTS)))
