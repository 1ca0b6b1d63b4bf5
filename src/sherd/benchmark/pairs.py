"""What a benchmark of `match` is made of: pairs of a full shape and a part, with ground truth."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from sherd.arrays import Bools
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["Pair", "PairSource", "rotated", "seed_of"]


@dataclass(frozen=True, eq=False)
class Pair:
    """A full shape, a part of it, and where each vertex of the part lies on the full shape.

    Attributes
    ----------
    truth, mirrored_truth
        (n_part,) surface points on `full`: the true ones, and those of the left/right mirror map
        where the data set has one, otherwise None.
    present
        (n_part,) bool, False where the full shape has no such point and `truth` means nothing;
        None if all are present.
    """

    name: str
    full: TriangleMesh
    part: TriangleMesh
    truth: SurfacePoints
    mirrored_truth: SurfacePoints | None
    present: Bools | None = None


class PairSource(Protocol):
    """A pair that is not loaded yet: files, and what is done with them."""

    @property
    def name(self) -> str:
        """Name of the pair, unique within its data set."""
        ...

    @property
    def kind(self) -> str:
        """Group that it is averaged in, such as ``"cuts"``."""
        ...

    @property
    def full(self) -> Path:
        """File of the full shape."""
        ...

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Every file that the pair depends on; one that does not exist counts as empty."""
        ...

    def load(self) -> Pair:
        """Read meshes and ground truth; see the class for what is raised."""
        ...


def rotated(mesh: TriangleMesh, seed: int) -> TriangleMesh:
    """The mesh turned at random, uniformly over all rotations."""
    frame, triangular = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    frame = frame * np.sign(np.diag(triangular))
    frame[:, 0] *= np.sign(np.linalg.det(frame))
    return mesh.with_vertices(mesh.vertices @ frame.T)


def seed_of(name: str, seed: int) -> int:
    """A seed for one pair: that of the run plus a hash of the pair's name."""
    return seed + int(hashlib.sha256(name.encode()).hexdigest()[:6], 16)
