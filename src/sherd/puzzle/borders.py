"""Borders drawn together: pieces of one whole meet where they were cut apart.

Each piece alone is good to a vertex spacing or two, and slides along featureless stretches; its
neighbors know where it must end. Each vertex on a piece's border is drawn to the middle between
itself and the nearest border of another piece, the pieces staying elastic, some times.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from sherd.arrays import Bools
from sherd.correspondence.question import Pins, Question
from sherd.correspondence.registration import Deformation, registered_to_surface
from sherd.correspondence.working_placement import (
    SECOND_REACHES,
    Queries,
    WorkingPlacement,
    judged_placement,
    look_inside,
)
from sherd.place import PlacedPart
from sherd.puzzle.border import BorderFit, border_of, nearest_borders

__all__ = ["bordering", "cut_apart", "drawn_to_borders", "fits_of"]

# How firmly borders draw: below this length the elasticity decides, above it the border.
FIRMNESS = 0.008
ROUNDS = 3
# Mean gap between borders below which the pieces overlap by more than placements are off: a vertex
# spacing.
LEAST_GAP = -0.01
# A border vertex off by half a vertex spacing is where it belongs; then nothing is drawn.
TOGETHER = 0.005


def cut_apart(parts: Collection[PlacedPart]) -> bool:
    """Whether pieces that lie beside each other were cut from one surface, where they meet.

    Where they were not cut apart but scanned, they overlap everywhere. Placements that are off
    leave as many cracks as overlaps.
    """
    fits = fits_of([part.question for part in parts], [part.best for part in parts])
    gaps = np.concatenate([fit.gap for fit in fits]) if fits else np.empty(0)
    gaps = gaps[np.isfinite(gaps)]
    return len(gaps) > 0 and float(gaps.mean()) >= LEAST_GAP


def bordering(parts: Mapping[int, PlacedPart]) -> dict[int, PlacedPart]:
    """By piece its placement with borders drawn together, of pieces that were cut apart."""
    drawn = drawn_to_borders(
        [part.question for part in parts.values()],
        [part.best for part in parts.values()],
        [part.queries for part in parts.values()],
    )
    return {
        piece: replace(part, best=best)
        for (piece, part), best in zip(parts.items(), drawn, strict=True)
    }


def fits_of(
    questions: Sequence[Question], placements: Sequence[WorkingPlacement]
) -> list[BorderFit]:
    """How the borders of these placements fit each other."""
    return nearest_borders(
        [
            border_of(question.part.mesh, place.deformation.positions)
            for question, place in zip(questions, placements, strict=True)
        ]
    )


def drawn_to_borders(
    questions: Sequence[Question],
    placements: Sequence[WorkingPlacement],
    queries: Sequence[Queries],
) -> list[WorkingPlacement]:
    """The placements with borders drawn together, each judged anew."""
    deformations = [place.deformation for place in placements]
    looks = [
        look_inside(question, place, each)
        for question, place, each in zip(questions, deformations, queries, strict=True)
    ]
    drawn: Bools = np.zeros(len(placements), dtype=bool)
    for _ in range(ROUNDS):
        borders = [
            border_of(question.part.mesh, place.positions)
            for question, place in zip(questions, deformations, strict=True)
        ]
        moved: list[Deformation] = []
        for k, (fit, border) in enumerate(zip(nearest_borders(borders), borders, strict=True)):
            near = np.isfinite(fit.gap)
            if not (np.abs(fit.gap[near]) > TOGETHER).any():
                moved.append(deformations[k])
                continue
            drawn[k] = True
            here = border.positions[border.at_vertices]
            pins = Pins(
                border.vertices[near],
                0.5 * (here[near] + fit.places[near]),
                np.empty((0, 2), dtype=np.int64),
                FIRMNESS,
            )
            moved.append(
                registered_to_surface(
                    replace(questions[k], pins=pins),
                    deformations[k],
                    looks[k],
                    reaches=SECOND_REACHES[-1:],
                    slides=2,
                )
            )
        deformations = moved
    return [
        judged_placement(question, place, look) if changed else before
        for question, place, look, before, changed in zip(
            questions, deformations, looks, placements, drawn, strict=True
        )
    ]
