"""Rotation-searched SHOT: histograms of normals whose tangent rotation stays open.

Classic SHOT turns every neighborhood into a local frame first, and such frames jump near cuts
and on limbs. Here only the normal axis is fixed; the tangent axis is arbitrary, and two
neighborhoods are compared in all rotations at once by correlation over the azimuth. Every
comparison so yields a similarity *and* a rotation, and mirrored neighborhoods do not agree.

A *spectrum* is the Fourier transform of the histogram over its 8 azimuth bins: an array
(5, q, 2 c) float32 of frequencies 0 to 4, points, and real then imaginary parts of the
c = (number of radii) * 44 remaining bins. The histogram of each radius has Euclidean norm 1.

References
----------
Salti, Tombari, Di Stefano, *SHOT: unique signatures of histograms for surface and texture
description*, 2014: section 4, with soft votes. Deviations: no local frame from the covariance,
votes weighted by vertex area (meshing cancels), several radii.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from itertools import product

import numpy as np
from numpy.typing import NDArray

from sherd.arrays import Floats, Ints, Singles, blocks_of_rows
from sherd.descriptors.rotation_kernel import FREQUENCIES, best_rotation, describe, pool_cells
from sherd.descriptors.shot_kernel import AZIMUTHS, BINS
from sherd.mesh.vertex_cells_kernel import sorted_into_cells
from sherd.threads import one_blas_thread, over_rows, side_by_side

__all__ = [
    "mirrored_spectra",
    "pooled_similarity",
    "rotation_spectra",
    "shift_table",
    "similarity",
    "trusted_by_cut",
    "trusted_equally",
    "weighted_spectra",
]


# The first and last of the frequencies have no imaginary part.
_REAL, _IMAGINARY = range(FREQUENCIES), range(1, FREQUENCIES - 1)

# Part points, and full vertices, that are compared at a time. BLAS copies both factors first, which
# for 25 points and all vertices took longer than the product (three times as long in all); more
# vertices take no less time, only memory.
POINTS, VERTICES = 250, 640


def rotation_spectra(
    vertices: Floats,
    normals: Floats,
    weights: Floats,
    queries: Ints,
    *,
    x_axes: Floats,
    z_axes: Floats,
    radii: tuple[float, ...],
) -> Singles:
    """Spectra (5, q, 2 c) of the neighborhoods of the query vertices.

    Parameters
    ----------
    vertices, normals
        (n, 3) positions and unit normals.
    weights
        (n,) weight of each vertex as a neighbor: its area, or zero to hide it.
    queries
        (q,) vertices described.
    x_axes, z_axes
        (q, 3) frame of each query; turning `x_axes` turns the phases and nothing else.
    radii
        Radii of the neighborhoods, in the unit of `vertices`.
    """
    cells = sorted_into_cells(vertices, max(radii))
    result = np.empty((FREQUENCIES, len(queries), 2 * len(radii) * BINS), dtype=np.float32)
    over_rows(
        describe, len(queries), np.ascontiguousarray(vertices), np.ascontiguousarray(normals),
        np.array(weights), queries, np.ascontiguousarray(x_axes), np.ascontiguousarray(z_axes),
        np.array(radii), cells, _wave_table(), result,
    )  # fmt: skip
    return result


def _wave_table() -> Floats:
    """Real and imaginary waves (5, 2, 8) of the Fourier transform over 8 azimuth bins."""
    # Parseval over 8 bins: frequencies 1 to 3 stand for two waves each
    share = np.sqrt(np.array([1.0, 2.0, 2.0, 2.0, 1.0]) / AZIMUTHS)
    angles = 2.0 * np.pi * np.outer(np.arange(FREQUENCIES), np.arange(AZIMUTHS)) / AZIMUTHS
    table: Floats = share[:, None, None] * np.stack([np.cos(angles), -np.sin(angles)], axis=1)
    return table


def weighted_spectra(spectra: Singles, weights: NDArray[np.floating]) -> Singles:
    """Multiply the radii of `spectra` (5, q, 2 c) by `weights` (q, r), brought to row sums 1.

    Apply it to one side only: the similarity of the weighted spectrum with an ordinary one is
    then the weighted mean of the similarities of the radii, at most 1.
    """
    share = weights / weights.sum(axis=1, keepdims=True)
    columns = np.tile(np.repeat(share, BINS, axis=1), 2).astype(np.float32)
    result: Singles = spectra * columns
    return result


def trusted_by_cut(
    spectra: Singles, cut_distance: Floats, radii: tuple[float, ...], least: float
) -> Singles:
    """`spectra` (5, q, 2 c), a neighborhood that the cut makes incomplete counting less.

    Its weight is the distance (q,) to the cut over its radius, at least `least`.
    """
    trust = np.clip(cut_distance[:, None] / np.array(radii), least, 1.0)
    return weighted_spectra(spectra, trust)


def trusted_equally(spectra: Singles, radii: tuple[float, ...]) -> Singles:
    """`spectra` whose radii all count the same.

    So they should when the full shape is described inside the same region.
    """
    return weighted_spectra(spectra, np.ones((spectra.shape[1], len(radii))))


def mirrored_spectra(spectra: Singles) -> Singles:
    """Spectra of the mirrored surface: azimuths run backward, so phases change sign."""
    half = spectra.shape[2] // 2
    return np.concatenate([spectra[:, :, :half], -spectra[:, :, half:]], axis=2)


def similarity(full_spectra: Singles, part_spectra: Singles) -> Singles:
    """Similarity (q, n) of each part point with each full vertex, best over rotation."""
    result = np.empty((part_spectra.shape[1], full_spectra.shape[1]), dtype=np.float32)
    waves = shift_table()
    for rows, columns, parts in _compared(full_spectra, part_spectra):
        over_rows(best_rotation, parts.shape[1], parts, waves, columns.start, result[rows])
    return result


def pooled_similarity(
    full_spectra: Singles, part_spectra: Singles, cells: Ints, cell_count: int, *, shifts: int = 16
) -> Singles:
    """Best similarity (q, cells, shifts) of each part point with the vertices of each cell.

    Entry (i, l, s) compares at rotation `2 pi s / shifts`: the angle of a direction in the frame
    of part point i minus the angle of the same direction in the frame of the full vertex.
    """
    result = np.full((part_spectra.shape[1], cell_count, shifts), -1.0, dtype=np.float32)
    waves = shift_table(shifts)
    for rows, columns, parts in _compared(full_spectra, part_spectra):
        over_rows(pool_cells, parts.shape[1], parts, cells[columns], waves, result[rows])
    return result


def _compared(
    full_spectra: Singles, part_spectra: Singles
) -> Iterator[tuple[slice, slice, Singles]]:
    """Slices of part points and of full vertices, and the 8 numbers that rotations are made from.

    All blocks (8, q', n') are written to one place of 5 MB, so one must be used before the next is
    asked for; one BLAS thread for each product keeps the bits independent of the number of cores.
    """
    half = part_spectra.shape[2] // 2
    widths = [2 * half if k in _IMAGINARY else half for k in _REAL]
    turned = np.concatenate([part_spectra[:, :, half:], -part_spectra[:, :, :half]], axis=2)
    points = blocks_of_rows(part_spectra.shape[1], POINTS)
    vertices = blocks_of_rows(full_spectra.shape[1], VERTICES)
    memory = np.empty(AZIMUTHS * POINTS * VERTICES, dtype=np.float32)
    with one_blas_thread():
        for rows, columns in product(points, vertices):
            shape = (AZIMUTHS, rows.stop - rows.start, columns.stop - columns.start)
            parts = memory[: math.prod(shape)].reshape(shape)
            products: list[tuple[Singles, Singles, Singles]] = [
                (part_spectra[k, rows, :width], full_spectra[k, columns, :width].T, parts[k])
                for k, width in zip(_REAL, widths, strict=True)
            ]
            products += [
                (turned[k, rows], full_spectra[k, columns].T, parts[FREQUENCIES + k - 1])
                for k in _IMAGINARY
            ]
            side_by_side([partial(np.matmul, *factors) for factors in products])
            yield rows, columns, parts


def shift_table(shifts: int = 16) -> Singles:
    """Waves (8, shifts) that turn the 8 numbers of a comparison into similarity by rotation."""
    angles = 2.0 * np.pi * np.arange(shifts) / shifts
    table = np.empty((AZIMUTHS, shifts), dtype=np.float32)
    for frequency in range(FREQUENCIES):
        table[frequency] = np.cos(frequency * angles)
        if 0 < frequency < FREQUENCIES - 1:
            table[FREQUENCIES + frequency - 1] = -np.sin(frequency * angles)
    return table
