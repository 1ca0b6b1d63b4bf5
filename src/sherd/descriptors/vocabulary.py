"""Vocabulary: soft words, so that an integral of descriptors becomes a histogram."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from scipy.cluster.vq import kmeans2

from sherd.arrays import Floats, frozen
from sherd.errors import OptionError

__all__ = ["Vocabulary", "learn_vocabulary"]


# More samples than this do not move the words of a vocabulary of a few hundred.
SAMPLE_LIMIT = 5000


@dataclass(frozen=True, eq=False)
class Vocabulary:
    """Words in a descriptor space.

    Attributes
    ----------
    words
        (w, d) cluster centers.
    softness
        Distance at which a word's weight has fallen to exp(-1/2).
    """

    words: Floats
    softness: float

    def histograms(self, descriptors: Floats) -> Floats:
        """Soft assignment of each descriptor (n, d) to the words, (n, w), rows sum to 1.

        `exp(-|p - word|^2 / (2 softness^2))`, normalized.

        References
        ----------
        Bronstein, Bronstein, Guibas, Ovsjanikov, *Shape Google*, 2011, equation 14.
        """
        squared = (
            (descriptors**2).sum(axis=1)[:, None]
            - 2 * descriptors @ self.words.T
            + (self.words**2).sum(axis=1)[None, :]
        )
        exponent = -0.5 * np.maximum(squared, 0.0) / self.softness**2
        weights = np.exp(exponent - exponent.max(axis=1, keepdims=True))
        result: Floats = weights / weights.sum(axis=1, keepdims=True)
        return result


def learn_vocabulary(descriptors: Floats, size: int, *, rng: np.random.Generator) -> Vocabulary:
    """Cluster descriptors (n, d) of the full shape into `size` words by k-means.

    The softness is the median distance of a descriptor to its word: each vertex then speaks mainly
    for one or two words, and small changes change the histogram a little.

    Raises
    ------
    OptionError
        If `size` is below 1 or above the number of descriptors.
    """
    if not 1 <= size <= len(descriptors):
        raise OptionError(f"vocabulary size is {size}, but 1 to {len(descriptors)} is possible")
    sample = descriptors
    if len(sample) > SAMPLE_LIMIT:
        sample = sample[rng.choice(len(sample), SAMPLE_LIMIT, replace=False)]
    with warnings.catch_warnings():
        # an empty cluster keeps its center of the round before, which is harmless for soft words
        warnings.simplefilter("ignore", UserWarning)
        words, nearest = kmeans2(sample, size, iter=15, minit="++", rng=rng)
    spread = np.linalg.norm(sample - words[nearest], axis=1)
    softness = float(np.median(spread)) or 1e-12
    return Vocabulary(np.asarray(frozen(words), dtype=np.float64), softness)
