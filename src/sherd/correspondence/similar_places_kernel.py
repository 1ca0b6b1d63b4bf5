"""Compiled: the soft maximum of similarity over a ball.

Kernels on plain arrays; :mod:`sherd.correspondence.similar_places` says what is compared.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sherd.arrays import Floats, Singles
from sherd.compiled import compiled
from sherd.descriptors.rotation_kernel import similarity_of_two
from sherd.mesh.vertex_cells_kernel import vertices_in_ball

__all__ = ["Sheet", "Spectra", "most_alike"]

# Similarities within 0.02 of the best are equally good.
SOFTNESS = 0.02
# Cosine between two normals below which they are those of two sheets.
SAME_SHEET = 0.2
# A target that is spread wider than a vertex spacing is a weak one.
SPREAD = 0.012
# The largest ball on two sheets of 20,000 vertices holds 300. Crumpled pages may fill one with
# thousands; every tenth will do.
MOST_PLACES = 400


class Sheet(NamedTuple):
    """The full shape's vertices (n, 3), unit normals (n, 3) and vertex areas (n,)."""

    vertices: Floats
    normals: Floats
    areas: Floats


class Spectra(NamedTuple):
    """Of the full shape's vertices and of the part's queries, and the waves of a comparison."""

    full: Singles
    part: Singles
    waves: Singles


@compiled()
def most_alike(  # noqa: PLR0913
    rows, here, nearest, cells, sheet, spectra, reach, targets, confidence, similarity
):
    """Write targets, confidence and similarity; see :func:`similar_places`."""
    vertices, normals, areas = sheet
    full_spectra, part_spectra, waves = spectra
    mean = np.empty(3)
    totals = np.empty(waves.shape[1], np.float32)
    for row in range(rows[0], rows[1]):
        near = vertices_in_ball(here[row], reach, vertices, cells)
        if len(near) == 0:
            near = nearest[row : row + 1]
        stride = 1 + len(near) // MOST_PLACES
        count = 1 + (len(near) - 1) // stride
        score, offset = np.empty(count), np.empty((count, 3))
        up = normals[nearest[row]]
        best, alike = -np.inf, -np.inf
        for k in range(count):
            vertex = near[k * stride]
            score[k] = -np.inf
            distance, agreement = 0.0, 0.0
            for axis in range(3):
                offset[k, axis] = vertices[vertex, axis] - here[row, axis]
                distance += offset[k, axis] ** 2
                agreement += normals[vertex, axis] * up[axis]
            if agreement < SAME_SHEET and vertex != nearest[row]:
                continue
            value = similarity_of_two(full_spectra, vertex, part_spectra, row, waves, totals)
            alike = max(alike, value)
            # of two equally similar places the nearer one
            score[k] = value - 0.5 * SOFTNESS * distance / (0.6 * reach) ** 2
            best = max(best, score[k])
        if best == -np.inf:  # a ball on another sheet only
            score[0], best = 0.0, 0.0
            for axis in range(3):
                offset[0, axis] = vertices[nearest[row], axis] - here[row, axis]
            alike = similarity_of_two(full_spectra, nearest[row], part_spectra, row, waves, totals)
        total, spread = 0.0, 0.0
        mean[0], mean[1], mean[2] = 0.0, 0.0, 0.0
        for k in range(count):
            score[k] = math.exp((score[k] - best) / SOFTNESS) * areas[near[k * stride]]
            total += score[k]
            for axis in range(3):
                mean[axis] += score[k] * offset[k, axis]
        for axis in range(3):
            mean[axis] /= max(total, 1e-300)
            targets[row, axis] = here[row, axis] + mean[axis]
        for k in range(count):
            for axis in range(3):
                spread += score[k] * (offset[k, axis] - mean[axis]) ** 2
        spread /= max(total, 1e-300)
        confidence[row] = 1.0 / (1.0 + spread / SPREAD**2)
        similarity[row] = alike
