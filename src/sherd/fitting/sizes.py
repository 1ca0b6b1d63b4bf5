"""Local sizes: how much larger another individual is, where it was seen and beyond."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Floats
from sherd.fitting.as_rigid_as_possible import Elasticity
from sherd.results.fitted.fit_options import Sizing

__all__ = ["mean_growth", "sizes_of"]

# In sqrt(area of the full shape): sizes are those of regions, a stretched joint is none.
SIZE_LENGTH = 0.15
# Regions of 15 pairs of poses of one body stretched by up to 0.08 (log), most by less than 0.04.
STRETCH = 0.06
# Nobody's limbs are more than three times those of a template that could be matched.
LARGEST = 1.1


def mean_growth(elasticity: Elasticity, positions: Floats, confidence: Floats) -> float:
    """How much longer what was seen is on average, as a logarithm; 0 if nothing was seen."""
    growth = _growth(elasticity, positions)
    weights = elasticity.areas * confidence
    return float(weights @ growth / weights.sum()) if weights.any() else 0.0


def sizes_of(
    elasticity: Elasticity, positions: Floats, confidence: Floats, *, sizing: Sizing
) -> Floats:
    """The factor (n,) by which the full shape is enlarged at each vertex.

    Logarithms of the growth of what was seen are averaged over regions and continued harmonically
    to what was not. What a pose alone may do is no size, so that a shape that only moved keeps its
    own exactly; twice as much is believed as it is, and in between a part of it. Of another
    individual the mean of all that was seen is a size in any case, and only what regions differ
    from it is judged so.
    """
    if sizing == "none":
        return np.ones(len(confidence))
    growth = _growth(elasticity, positions)
    lengths = np.full(len(growth), SIZE_LENGTH)
    smooth = elasticity.smoothing(confidence, lengths)(growth[:, None], np.zeros((len(growth), 1)))
    whole = mean_growth(elasticity, positions, confidence) if sizing == "individual" else 0.0
    apart = smooth[:, 0] - whole
    believed = np.clip(np.abs(apart) / STRETCH - 1.0, 0.0, 1.0)
    sizes: Floats = np.exp(whole + believed * apart)
    return sizes


def _growth(elasticity: Elasticity, positions: Floats) -> Floats:
    growth = np.log(np.maximum(elasticity.fitted_sizes(positions), 1e-6))
    return np.clip(growth, -LARGEST, LARGEST)
