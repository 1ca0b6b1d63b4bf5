"""Compiled: spectra of neighborhoods and their comparison in all rotations.

Kernels on plain arrays; :mod:`sherd.descriptors.rotation_shot` says what spectra are.
"""

from __future__ import annotations

import math

import numpy as np

from sherd.compiled import compiled
from sherd.descriptors.shot_kernel import AZIMUTHS, BINS, vote

__all__ = ["FREQUENCIES", "best_rotation", "describe", "pool_cells", "similarity_of_two"]

FREQUENCIES = AZIMUTHS // 2 + 1


# Each histogram becomes a spectrum at once: all of them together would be four times the result.
@compiled()
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


@compiled()
def pool_cells(rows, parts, cells, waves, result):
    """Raise `result` to the similarity at each rotation of the vertices of each cell."""
    for row in range(rows[0], rows[1]):
        for vertex in range(len(cells)):
            best = result[row, cells[vertex]]
            numbers = _of_row(parts[:, row], vertex)
            for shift in range(waves.shape[1]):
                total = _turned(numbers, waves, shift)
                best[shift] = total if total > best[shift] else best[shift]


# One array holds all that the inner loop touches: vector lanes then need no proof that what is
# written is not what is read, and it is three times as fast as vertex by vertex.
@compiled()
def best_rotation(rows, parts, waves, first, result):
    """Similarity at the rotation where it is largest, of vertices from `first` on (q, n)."""
    count = parts.shape[2]
    memory = np.empty((AZIMUTHS + 1, count), np.float32)
    for row in range(rows[0], rows[1]):
        # entry by entry: to compile the assignment of a slice takes two seconds
        for number in range(AZIMUTHS):
            for vertex in range(count):
                memory[number, vertex] = parts[number, row, vertex]
        for vertex in range(count):
            memory[AZIMUTHS, vertex] = np.float32(-np.inf)
        for shift in range(waves.shape[1]):
            for vertex in range(count):
                total = _turned(_of_row(memory, vertex), waves, shift)
                best = memory[AZIMUTHS, vertex]
                memory[AZIMUTHS, vertex] = total if total > best else best
        for vertex in range(count):
            result[row, first + vertex] = memory[AZIMUTHS, vertex]


@compiled()
def _of_row(numbers, vertex):
    """The eight numbers of one comparison, as values that stay in registers."""
    return (
        numbers[0, vertex], numbers[1, vertex], numbers[2, vertex], numbers[3, vertex],
        numbers[4, vertex], numbers[5, vertex], numbers[6, vertex], numbers[7, vertex],
    )  # fmt: skip


@compiled()
def _turned(numbers, waves, shift):
    """Similarity at one rotation; without a loop over waves that over shifts takes vectors."""
    a, b, c, d, e, f, g, h = numbers
    return (
        a * waves[0, shift] + b * waves[1, shift] + c * waves[2, shift] + d * waves[3, shift]
        + e * waves[4, shift] + f * waves[5, shift] + g * waves[6, shift] + h * waves[7, shift]
    )  # fmt: skip


# Sums may be regrouped into vector lanes: the same on every run, and four times faster.
@compiled(fastmath={"reassoc", "contract"})
def similarity_of_two(full_spectra, vertex, part_spectra, point, waves, totals):
    """Similarity, best over rotation, of one full vertex with one part point, for kernels.

    `waves` come from :func:`sherd.descriptors.rotation_shot.shift_table`; `totals` is memory for
    one number of each rotation, given by callers who ask for many.
    """
    half = full_spectra.shape[2] // 2
    last = FREQUENCIES - 1
    for shift in range(len(totals)):
        totals[shift] = np.float32(0.0)
    for frequency in range(FREQUENCIES):
        real, imaginary = np.float32(0.0), np.float32(0.0)
        if frequency in (0, last):  # these have no imaginary part
            for k in range(half):
                real += part_spectra[frequency, point, k] * full_spectra[frequency, vertex, k]
            for shift in range(len(totals)):
                totals[shift] += real * waves[frequency, shift]
            continue
        for k in range(half):
            p = part_spectra[frequency, point, k]
            q = part_spectra[frequency, point, half + k]
            f = full_spectra[frequency, vertex, k]
            g = full_spectra[frequency, vertex, half + k]
            real += p * f + q * g
            imaginary += q * f - p * g
        other = FREQUENCIES + frequency - 1
        for shift in range(len(totals)):
            totals[shift] += real * waves[frequency, shift] + imaginary * waves[other, shift]
    best = totals[0]
    for shift in range(1, len(totals)):
        best = totals[shift] if totals[shift] > best else best
    return best
