"""Landmarks that several templates place on one specimen: their middle, and how far they differ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sherd.arrays import Floats
from sherd.errors import InputError
from sherd.landmarks.carried import CarriedLandmarks
from sherd.landmarks.landmark_list import Landmarks

__all__ = ["geometric_median", "median_landmarks"]

# Weiszfeld's steps shrink the error by a constant factor; a hundred leave nothing of it.
STEPS = 100
# A step below this share of the spread of the points ends it.
STILL = 1e-9


def median_landmarks(carried: Sequence[CarriedLandmarks]) -> CarriedLandmarks:
    """One answer of several, each from another template.

    A landmark lies at the geometric median of where the templates that find it place it, and is
    missing unless half of them do. It is good if half of these say so. Templates that say that the
    specimen is foreign do not count unless all do.

    Raises
    ------
    InputError
        If there is none, or they are of several specimens or of landmarks with other names.

    References
    ----------
    Zhang, Porto, Rolfe, Kocatulum, Maga, *Automated landmarking via multiple templates*, 2022, take
    the median of each coordinate; the geometric median does not depend on how the axes run.
    """
    _check(carried)
    first, names = carried[0], carried[0].landmarks.names
    templates = tuple(name for each in carried for name in each.templates)
    known = [_in_order(each, names) for each in carried if "foreign" not in each.status]
    if not known:
        return replace(first, templates=templates)
    positions = np.stack([each.landmarks.positions for each in known])
    chances = np.stack([each.confidence for each in known])
    good = np.array([[word == "good" for word in each.status] for each in known])
    middle, spread = np.full((len(names), 3), np.nan), np.full(len(names), np.nan)
    confidence, status = np.full(len(names), np.nan), ["missing"] * len(names)
    for row in range(len(names)):
        there = np.isfinite(positions[:, row]).all(axis=1)
        if 2 * there.sum() < len(known):
            continue
        middle[row] = geometric_median(positions[there, row])
        apart = np.linalg.norm(positions[there, row] - middle[row], axis=1)
        spread[row] = np.median(apart) if there.sum() > 1 else np.nan
        confidence[row] = np.median(chances[there, row])
        status[row] = "good" if 2 * good[there, row].sum() >= there.sum() else "doubtful"
    space, source = first.landmarks.space, first.landmarks.source
    return CarriedLandmarks(
        specimen=first.specimen,
        templates=templates,
        landmarks=Landmarks(names, middle, space=space, source=source),
        confidence=confidence,
        status=tuple(status),
        spread=spread,
    )


def _check(carried: Sequence[CarriedLandmarks]) -> None:
    if not carried:
        raise InputError("no landmarks are given to take the median of")
    first = carried[0]
    for other in carried[1:]:
        if other.specimen != first.specimen:
            raise InputError(
                f"landmarks of {other.specimen} and of {first.specimen} have no median"
            )
        if set(other.landmarks.names) != set(first.landmarks.names):
            raise InputError(
                f"{first.specimen}: the templates {first.templates[0]} and {other.templates[0]} "
                "have landmarks of other names; name the same points alike"
            )


def _in_order(carried: CarriedLandmarks, names: tuple[str, ...]) -> CarriedLandmarks:
    """The same landmarks in the order of these names."""
    old = carried.landmarks
    order = [old.names.index(name) for name in names]
    return replace(
        carried,
        landmarks=Landmarks(names, old.positions[order], space=old.space, source=old.source),
        confidence=carried.confidence[order],
        status=tuple(carried.status[k] for k in order),
        spread=carried.spread[order],
    )


def geometric_median(points: Floats) -> Floats:
    """The point (3,) with the least sum of distances to points (t, 3).

    Weiszfeld's iteration from the mean; distances of zero count as the smallest share of the
    spread, so that a median on a point stays there. Of two points it is their middle.
    """
    middle: Floats = points.mean(axis=0)
    size = float(np.linalg.norm(points - middle, axis=1).max())
    for _ in range(STEPS):
        apart = np.maximum(np.linalg.norm(points - middle, axis=1), STILL * size)
        if size == 0:
            break
        moved: Floats = (points / apart[:, None]).sum(axis=0) / (1 / apart).sum()
        still = np.linalg.norm(moved - middle) <= STILL * size
        middle = moved
        if still:
            break
    return middle
