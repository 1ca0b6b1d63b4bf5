"""Where near its present place each vertex of the part looks most alike."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from sherd.descriptors.rotation_shot import shift_table, similarity_of_two
from sherd.mesh.vertex_cells import sorted_into_cells, vertices_in_ball
from sherd.template import Template
from sherd.threads import over_rows

__all__ = ["Look", "similar_places"]

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Ints = NDArray[np.int64]

# Similarities within 0.02 of the best are equally good.
SOFTNESS = 0.02
# A target that is spread wider than a vertex spacing is a weak one.
SPREAD = 0.012
# The largest ball on two sheets of 20,000 vertices holds 300. Crumpled pages may fill one with
# thousands; every tenth will do.
MOST_PLACES = 400


@dataclass(frozen=True, eq=False)
class Look:
    """Which neighborhoods are compared.

    Attributes
    ----------
    vertices
        (q,) vertices of the part that look for similar places.
    full_spectra, part_spectra
        Spectra of all vertices of the full shape, and of these vertices.
    trust
        (q,) weight of each in [0, 1].
    """

    vertices: Ints
    full_spectra: Singles
    part_spectra: Singles
    trust: Floats


def similar_places(
    template: Template, positions: Floats, look: Look, *, reach: float
) -> tuple[Floats, Floats, Floats]:
    """Where near its place each query vertex looks most alike: soft maximum over a ball.

    `positions` (n', 3) are the places of all vertices of the part, `reach` the radius of the ball.

    Returns
    -------
    targets, confidence, similarity
        (q, 3) places, (q,) in [0, 1]: low where equally similar places are far apart, and (q,)
        the best similarity.
    """
    here = positions[look.vertices]
    # the nearest vertex is always compared, and says which sheet of the surface is meant
    nearest: Ints = np.asarray(template.vertex_tree.query(here, workers=-1)[1])
    unit = template.unit
    targets = np.empty((len(here), 3))
    confidence, similarity = np.empty(len(here)), np.empty(len(here))
    over_rows(
        _most_alike, len(here), here, nearest, sorted_into_cells(unit.vertices, reach),
        (unit.vertices, template.normals, unit.vertex_areas),
        (look.full_spectra, look.part_spectra, shift_table()), reach,
        (targets, confidence, similarity),
    )  # fmt: skip
    return targets, confidence, similarity


@numba.njit(cache=True, nogil=True)
def _most_alike(rows, here, nearest, cells, surface, spectra, reach, answers):  # type: ignore[no-untyped-def]
    """Write targets, confidence and similarity; see :func:`similar_places`."""
    vertices, normals, areas = surface
    full_spectra, part_spectra, waves = spectra
    targets, confidence, similarity = answers
    for row in range(rows[0], rows[1]):
        near = vertices_in_ball(here[row], reach, vertices, cells)
        if len(near) == 0:
            near = nearest[row : row + 1]
        near = near[:: 1 + len(near) // MOST_PLACES]
        count = len(near)
        score, offset = np.empty(count), np.empty((count, 3))
        up = normals[nearest[row]]
        best, alike = -np.inf, -np.inf
        for k in range(count):
            vertex = near[k]
            value = similarity_of_two(full_spectra, vertex, part_spectra, row, waves)
            alike = max(alike, value)
            distance, agreement = 0.0, 0.0
            for axis in range(3):
                offset[k, axis] = vertices[vertex, axis] - here[row, axis]
                distance += offset[k, axis] ** 2
                agreement += normals[vertex, axis] * up[axis]
            # of two equally similar places the nearer one
            score[k] = value - 0.5 * SOFTNESS * distance / (0.6 * reach) ** 2
            if agreement < 0.2:
                score[k] -= 1.0  # another sheet
            best = max(best, score[k])
        total, spread = 0.0, 0.0
        mean = np.zeros(3)
        for k in range(count):
            score[k] = math.exp((score[k] - best) / SOFTNESS) * areas[near[k]]
            total += score[k]
            mean += score[k] * offset[k]
        mean /= max(total, 1e-300)
        for k in range(count):
            spread += score[k] * ((offset[k] - mean) ** 2).sum()
        spread /= max(total, 1e-300)
        targets[row] = here[row] + mean
        confidence[row] = 1.0 / (1.0 + spread / SPREAD**2)
        similarity[row] = alike
