"""Soft matching: where could each sample of the part lie? No correspondence is decided.

Every sample y of the part spreads one unit of probability p_y over candidates x, vertices that
stand for all of the full shape. Three things shape it: the similarity of the two neighborhoods, the
*context* (what lies around y must lie around x, as a bag of words with no order or direction), and
the *capacity* (no place can be used twice, since the part is a piece of the full shape). The sum
over the samples, weighted by their areas, is a membership in [0, 1] with the area of the part: the
constraint of the paper, met before any region is drawn.

References
----------
Bronstein, Bronstein, Guibas, Ovsjanikov, *Shape Google*, 2011, section 4.2: words in their spatial
context through the heat kernel. Sinkhorn and Knopp, 1967: scaling to given margins; here the
margin of the full shape is an upper bound, so its scale never rises above one. The combination is
our own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sherd.arrays import Bools, Floats, Singles

__all__ = ["MatchGeometry", "soft_match", "spread"]


# Temperature of the similarity: a right partner on another pose and meshing scores about this much
# below the best of all vertices (median 0.01 on the generated animal). Half and double the value
# change the answer little, because context decides between what similarity leaves open.
TEMPERATURE = 0.01
# Widths of the context, in sqrt(area of the full shape): from the size of a limb's girth, which
# tells body parts apart, down to the largest SHOT radius, below which SHOT itself is the context.
CONTEXT_WIDTHS = (0.15, 0.15, 0.15, 0.15, 0.10, 0.10, 0.10, 0.10)
# Weight of the context: about as many independent neighborhoods as fit into a context disk of
# width 0.15 around a SHOT disk of radius 0.1, beyond the first.
CONTEXT_WEIGHT = 6.0
# Density below which a context counts as absent, relative to probability spread over everything:
# a sample with a wrong context must stay possible, or one bad neighbor would veto it.
ABSENT = 0.1
# Waves that heat flow leaves so little of are left out: all in phase, a hundredth of `ABSENT`.
FADED = 1e-5
# The capacity acts on mass smoothed over the spacing of samples, since one sample stands for its
# whole cell. 200 samples of half the surface lie 0.05 apart.
CAPACITY_WIDTH = 0.04
# Log probability, beside the best, of what is impossible: 1e-26 in all places together changes
# nothing, and products with it still are ordinary numbers, which processors multiply far faster.
IMPOSSIBLE = np.float32(-60.0)
# Scaling steps per round; the rounds go on where the last one stopped.
CAPACITY_STEPS = 3


@dataclass(frozen=True, eq=False)
class MatchGeometry:
    """What soft matching needs beside the similarities; lengths in sqrt(area of the full shape).

    Attributes
    ----------
    sample_areas
        (q,) share of each sample in the part's area; sums to 1.
    trust
        (q,) in (0, 1], how undisturbed by the cut the sample's neighborhood is.
    sample_distances
        (q, q) geodesic distances between the samples, inf where not connected.
    areas
        (n,) share of the full shape's area that each candidate stands for; sums to 1.
    part_fraction
        Area of the part over area of the full shape.
    eigenvalues, eigenvectors
        (k,) and, at the candidates, (n, k) of the full shape at area 1.
    """

    sample_areas: Floats
    trust: Floats
    sample_distances: Floats
    areas: Floats
    part_fraction: float
    eigenvalues: Floats
    eigenvectors: Singles


def soft_match(
    similarity: Singles, geometry: MatchGeometry, *, forbidden: Bools | None = None
) -> Singles:
    """Probability (q, n) float32 that sample y lies at candidate x; each row sums to 1.

    Parameters
    ----------
    similarity
        (q, n) in [-1, 1].
    geometry
        Areas, distances and the basis that smooths.
    forbidden
        (n,) candidates that no sample may use; None allows all.

    Notes
    -----
    A round costs `4 q n k` operations; 0.6 s in all for 200 samples and 10,000 vertices.
    """
    best = similarity.max(axis=1, keepdims=True)
    areas = np.maximum(geometry.areas, 1e-12).astype(np.float32)
    # such arrays are the largest of all, so they are changed in place where nobody needs them
    likelihood = similarity - best
    likelihood /= np.float32(TEMPERATURE)
    likelihood += np.log(areas)
    if forbidden is not None:
        likelihood[:, forbidden] = -np.float32(1e4)  # impossible, and sums stay finite
    capacity = _Capacity(geometry, np.float32(1.0) if forbidden is None else ~forbidden)
    probability = capacity.normalized(likelihood.copy())
    for width in CONTEXT_WIDTHS:
        neighbors = _neighbor_weights(geometry, width)
        density = spread(probability, geometry, width)
        density += np.float32(ABSENT)
        np.log(density, out=density)
        context = np.matmul(neighbors, density, out=probability)
        context *= np.float32(CONTEXT_WEIGHT)
        context += likelihood
        probability = capacity.normalized(context)
    return probability


def spread(
    mass: Singles, geometry: MatchGeometry, width: float, *, onto: Singles | None = None
) -> Singles:
    """Density (q, n) of masses (q, n) after heat flow of standard deviation `width`, never < 0.

    A total mass of 1 spread evenly has density 1. With `onto`, eigenvectors (m, k) at other
    vertices of the same shape, the density (q, m) there.
    """
    decay = np.exp(-0.5 * width**2 * geometry.eigenvalues).astype(np.float32)
    size = int(np.searchsorted(-decay, -FADED))  # eigenvalues ascend
    vectors = geometry.eigenvectors if onto is None else onto
    coefficients = (mass @ geometry.eigenvectors[:, :size]) * decay[:size]
    density: Singles = np.asarray(coefficients @ vectors[:, :size].T)
    np.maximum(density, 0.0, out=density)  # a truncated heat kernel dips below 0 far away
    return density


class _Capacity:
    """Row-normalizes log probabilities while a price keeps every place from being used twice."""

    def __init__(self, geometry: MatchGeometry, free: Bools | np.float32) -> None:
        self._geometry, self._free = geometry, free
        self._mass = (geometry.sample_areas * geometry.part_fraction).astype(np.float32)
        self._price = np.zeros(len(geometry.areas), dtype=np.float32)

    def normalized(self, weight: Singles) -> Singles:
        """Probabilities (q, n) in place of log probabilities."""
        weight -= weight.max(axis=1, keepdims=True)
        np.maximum(weight, IMPOSSIBLE, out=weight)
        np.exp(weight, out=weight)  # once: a price is a factor of its place
        for _ in range(CAPACITY_STEPS):
            factor = np.exp(-self._price) * self._free
            rows = weight @ factor
            mass = np.asarray(factor * ((self._mass / rows) @ weight), dtype=np.float32)
            used = spread(mass[None], self._geometry, CAPACITY_WIDTH)[0]
            # a free place lowers its price again, never below nothing
            self._price += np.log(np.maximum(used, np.float32(1e-3)))
            np.maximum(self._price, 0.0, out=self._price)
        weight *= factor
        weight /= rows[:, None]
        return weight


def _neighbor_weights(geometry: MatchGeometry, width: float) -> Singles:
    """Weight (q, q) of each other sample in the context of a sample, rows sum to 1 or are 0."""
    distances = np.where(np.isfinite(geometry.sample_distances), geometry.sample_distances, 1e3)
    weights = np.exp(-0.5 * (distances / width) ** 2) * (geometry.trust * geometry.sample_areas)
    np.fill_diagonal(weights, 0.0)
    total = weights.sum(axis=1, keepdims=True)
    result: Singles = np.divide(
        weights, total, out=np.zeros_like(weights), where=total > 1e-12
    ).astype(np.float32)
    return result
