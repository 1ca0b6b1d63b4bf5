"""What a benchmark of `match` asks: pairs with ground truth, and how they are shown to it."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from sherd.arrays import Bools
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["BenchmarkSettings", "Pair", "PairSet", "PairSource", "seed_of"]


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


@dataclass(frozen=True)
class BenchmarkSettings:
    """How parts are shown to the method.

    Parameters
    ----------
    rotate
        Turn every part at random.
    unknown_scale
        Scale every part by a random factor in [1/2, 2] and tell the method only that it is unknown.
    points
        Take the faces from every part; which side is outside is then unknown as well.
    seed
        Seed of rotations, factors, cuts and of the method.
    """

    rotate: bool = False
    unknown_scale: bool = False
    points: bool = False
    seed: int = 0


@dataclass(frozen=True)
class PairSet:
    """The pairs of a data set, and what is said about them.

    Attributes
    ----------
    title, data, meshes
        Name of the data set, what its numbers mean, and where its triangles come from, for readers
        of bench.json and bench.html.
    settings
        How parts are shown to the method, and the seed with which the pairs were drawn.
    pairs
        Names are unique.
    """

    title: str
    data: str
    meshes: str
    settings: BenchmarkSettings
    pairs: tuple[PairSource, ...]


def seed_of(name: str, seed: int) -> int:
    """A seed for one pair: that of the run plus a hash of the pair's name."""
    return seed + int(hashlib.sha256(name.encode()).hexdigest()[:6], 16)
