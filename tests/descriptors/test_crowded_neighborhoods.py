"""Balls with more neighbors than a histogram needs are sampled evenly."""

from __future__ import annotations

import numpy as np

from sherd.descriptors.shot_kernel import MOST_VOTES, shot_histograms


def histogram(count: int) -> np.ndarray:
    """Of the pole of a small sphere with `count` vertices, all inside the ball."""
    height = np.linspace(1, -1, count)
    angle = np.arange(count) * np.pi * (3 - np.sqrt(5))
    ring = np.sqrt(1 - height**2)
    normals = np.stack([ring * np.cos(angle), ring * np.sin(angle), height], axis=1)
    return shot_histograms(
        0.04 * normals,
        normals,
        np.full(count, 1 / count),
        np.array([0]),
        x_axes=np.array([[1.0, 0, 0]]),
        z_axes=np.array([[0.0, 0, 1]]),
        radii=(0.1,),
    )[0, 0]


def test_a_crowded_ball_looks_like_a_sparse_one() -> None:
    sparse, crowded = histogram(MOST_VOTES), histogram(12 * MOST_VOTES + 5)
    assert (sparse * crowded).sum() > 0.999
