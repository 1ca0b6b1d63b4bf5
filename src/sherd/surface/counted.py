"""Numbers and angles as whole multiples of a step: fewer bytes, and exact once rounded."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sherd.arrays import Singles

__all__ = ["TURN", "counts_of", "numbers_of", "round_to_counts", "steps_of"]

# Counts reach so far on either side of 0 and still are float32 exactly when multiplied by a power
# of two; the one below them stands for what is infinite.
MOST = 32767
INFINITE = -32768
# Below it all numbers are 0: float32 would lose its exactness.
LEAST_STEP = 2.0**-100
# Steps of a turn: of 1e-4 radians, as directions are rounded for files, in two bytes. With one, in
# steps of 1.4 degrees, a match stays as good (SHREC'16), but of 50 overlaps of different species
# four more were wrong.
TURN = 65536


def counts_of(values: Singles) -> tuple[NDArray[np.int16], float]:
    """Counts (any shape) and the step that give `values` back, as near as half a step.

    The step is the least power of two by which `MOST` counts reach the largest finite number. It is
    the same or finer for numbers that are :func:`round_to_counts`, so these come back exactly.

    Parameters
    ----------
    values
        Finite or +inf, not nan.
    """
    step = _step_of(values)
    counts = np.full(values.shape, INFINITE, dtype=np.int16)
    np.rint(values / np.float32(step), out=counts, where=np.isfinite(values), casting="unsafe")
    return counts, step


def _step_of(values: Singles) -> float:
    # no copy of the finite ones: these arrays are the largest of all
    finite = np.isfinite(values)
    largest = values.max(where=finite, initial=0.0), -values.min(where=finite, initial=0.0)
    most = float(max(largest))
    return float(max(LEAST_STEP, 2.0 ** np.ceil(np.log2(most / MOST)))) if most > 0 else 1.0


def numbers_of(counts: NDArray[np.int16], step: float) -> Singles:
    """The numbers (float32) of :func:`counts_of`."""
    values: Singles = counts * np.float32(step)
    if counts.size and counts.min() == INFINITE:  # rarely: to look for it takes a tenth of the time
        values[counts == INFINITE] = np.inf
    return values


def round_to_counts(values: Singles) -> None:
    """Give `values`, in place, the bits that they have once they were stored as counts."""
    step = np.float32(_step_of(values))
    values /= step  # a power of two: nothing is lost
    np.rint(values, out=values)
    values *= step
    values += np.float32(0.0)  # counts know no negative zero


def steps_of(angles: NDArray[np.floating]) -> NDArray[np.uint16]:
    """Angles (any shape), in radians, in steps of a turn over `TURN`, from 0 on."""
    steps: NDArray[np.int64] = np.rint(angles * (TURN / (2.0 * np.pi))).astype(np.int64)
    return (steps & (TURN - 1)).astype(np.uint16)
