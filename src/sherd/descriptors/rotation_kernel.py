"""Compiled: spectra of neighborhoods and their comparison in all rotations.

Kernels on plain arrays; :mod:`sherd.descriptors.rotation_shot` says what spectra are.
"""

from __future__ import annotations

import math

import numpy as np

from sherd.compiled import compiled
from sherd.descriptors.shot_kernel import AZIMUTHS, BINS, vote

__all__ = ["FREQUENCIES", "describe", "pool_cells", "similarity_of_two"]

FREQUENCIES = AZIMUTHS // 2 + 1


# Each histogram becomes a spectrum at once: all of them together would be four times the result.
@compiled(nogil=True)
def describe(  # noqa: PLR0913
    rows, vertices, normals, weights, queries, x_axes, z_axes, radii, cells, waves, result
):
    """Write the spectra (5, q, 2 c) of the query vertices."""
    half = len(radii) * BINS
    histogram, total = np.empty((len(radii), AZIMUTHS, BINS)), np.empty(BINS)
    for row in range(rows[0], rows[1]):
        histogram[:] = 0.0
        frame = (x_axes[row], z_axes[row])
        vote(vertices, normals, weights, queries[row], frame, radii, cells, histogram)
        for k in range(len(radii)):
            norm = math.sqrt((histogram[k] ** 2).sum())
            scale = 1.0 / norm if norm > 0.0 else 1.0
            for frequency in range(FREQUENCIES):
                for part in range(2):
                    start = part * half + k * BINS
                    total[:] = 0.0
                    for azimuth in range(AZIMUTHS):
                        wave = scale * waves[frequency, part, azimuth]
                        for entry in range(BINS):
                            total[entry] += histogram[k, azimuth, entry] * wave
                    for entry in range(BINS):
                        result[frequency, row, start + entry] = total[entry]


@compiled(nogil=True, fastmath={"reassoc", "contract"})
def pool_cells(rows, parts, cells, waves, result):
    """Maximum over the vertices of each cell of the similarity at each rotation."""
    shifts = waves.shape[1]
    for row in range(rows[0], rows[1]):
        result[row] = np.float32(-1.0)
        for vertex in range(len(cells)):
            cell = cells[vertex]
            if cell < 0:
                continue
            for shift in range(shifts):
                total = np.float32(0.0)
                for wave in range(AZIMUTHS):
                    total += parts[wave, row, vertex] * waves[wave, shift]
                result[row, cell, shift] = max(result[row, cell, shift], total)


# Sums may be regrouped into vector lanes: the same on every run, and four times faster.
@compiled(fastmath={"reassoc", "contract"})
def similarity_of_two(full_spectra, vertex, part_spectra, point, waves):
    """Similarity, best over rotation, of one full vertex with one part point, for kernels.

    `waves` come from :func:`sherd.descriptors.rotation_shot.shift_table`.
    """
    half = full_spectra.shape[2] // 2
    last = FREQUENCIES - 1
    totals = np.zeros(waves.shape[1], np.float32)
    for frequency in range(FREQUENCIES):
        p, f = part_spectra[frequency, point], full_spectra[frequency, vertex]
        real, imaginary = np.float32(0.0), np.float32(0.0)
        if frequency in (0, last):  # these have no imaginary part
            for k in range(half):
                real += p[k] * f[k]
            for shift in range(len(totals)):
                totals[shift] += real * waves[frequency, shift]
            continue
        for k in range(half):
            real += p[k] * f[k] + p[half + k] * f[half + k]
            imaginary += p[half + k] * f[k] - p[k] * f[half + k]
        turned = waves[FREQUENCIES + frequency - 1]
        for shift in range(len(totals)):
            totals[shift] += real * waves[frequency, shift] + imaginary * turned[shift]
    return totals.max()
