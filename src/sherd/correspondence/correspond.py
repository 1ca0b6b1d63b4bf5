"""The stages of dense correspondence, each a function on frozen objects.

:mod:`sherd.match` calls them in order and reads as the summary of the method.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sherd.arrays import Singles
from sherd.correspondence.anchors import find_anchors
from sherd.correspondence.hypothesis import (
    Hypothesis,
    Queries,
    mirrored_queries,
    roughly_settled,
    settled,
)
from sherd.correspondence.labeling import SETTINGS, SIMILARITY_STEP, Labeling, make_problem
from sherd.correspondence.part_data import (
    PartData,
    mirrored,
    part_spectra,
    trusted_by_cut,
    trusted_equally,
)
from sherd.descriptors.rotation_shot import pooled_similarity
from sherd.template import Template

__all__ = ["Twin", "anchored", "looked_again", "mirrored_twin"]


# Once the region is known, neighborhoods agree better, and lack of similarity says more.
SECOND_STEP = 0.5 * SIMILARITY_STEP


@dataclass(frozen=True, eq=False)
class Twin:
    """The best orientation-reversing placement, and the part's mirror image that it places."""

    part: PartData
    hypothesis: Hypothesis


def anchored(
    template: Template,
    part: PartData,
    rng: np.random.Generator,
    *,
    inside: Singles | None = None,
    settings: tuple[float, ...] = SETTINGS,
) -> Labeling:
    """Label the part's nodes, jointly, by similarity and consistency.

    With `inside`, spectra of the full shape seen within a region, the part's neighborhoods are
    taken to be complete; without, they count less near the cut. `settings` say how lengths and
    directions are compared.
    """
    spectra = part_spectra(part, part.nodes)
    trusted = (
        trusted_by_cut(part, part.nodes, spectra) if inside is None else trusted_equally(spectra)
    )
    similarity = pooled_similarity(
        template.spectra if inside is None else inside,
        trusted,
        template.cells,
        len(template.label_vertices),
    )
    problem = make_problem(template, part, similarity, rng, settings=settings)
    if inside is None:
        return find_anchors(problem)
    return find_anchors(problem, step=SECOND_STEP, rounds=2)


def looked_again(
    template: Template,
    part: PartData,
    first: Hypothesis,
    queries: Queries,
    rng: np.random.Generator,
    *,
    settings: tuple[float, ...] = SETTINGS,
) -> Hypothesis:
    """A second placement, from anchors that see the full shape inside the first one's region."""
    labeling = anchored(template, part, rng, inside=first.inside_spectra, settings=settings)
    return settled(template, part, labeling, queries)


def mirrored_twin(
    template: Template,
    part: PartData,
    queries: Queries,
    rng: np.random.Generator,
    *,
    settings: tuple[float, ...] = SETTINGS,
) -> Twin:
    """The best placement of the part's mirror image, as the left leg for the right."""
    image = mirrored(part)
    labeling = anchored(template, image, rng, settings=settings)
    found = roughly_settled(template, image, labeling, mirrored_queries(queries))
    return Twin(image, found)
