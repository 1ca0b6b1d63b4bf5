"""What a benchmark of `overlap` asks: two incomplete shapes, and what they truly share."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from sherd.arrays import Bools
from sherd.benchmark.datasets.pairs import BenchmarkSettings
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["OverlapPair", "OverlapSet", "OverlapSource"]


@dataclass(frozen=True, eq=False)
class OverlapPair:
    """Two shapes, what of each the other has too, and where.

    Attributes
    ----------
    name, first, second
        The pair.
    truth
        (n_second,) points on `first`; without meaning where `second_shared` is False.
    first_shared, second_shared
        (n_first,) and (n_second,) bool, vertices that the other shape has.
    length
        sqrt(area) of the whole that `first` was cut from, in its unit: errors are measured in it.
    """

    name: str
    first: TriangleMesh
    second: TriangleMesh
    truth: SurfacePoints
    first_shared: Bools
    second_shared: Bools
    length: float


class OverlapSource(Protocol):
    """A pair that is not loaded yet."""

    @property
    def name(self) -> str:
        """Name of the pair, unique within its data set."""
        ...

    @property
    def kind(self) -> str:
        """Group that it is averaged in."""
        ...

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Every file that the pair depends on; one that does not exist counts as empty."""
        ...

    def load(self) -> OverlapPair:
        """Read meshes and ground truth; see the class for what is raised."""
        ...


@dataclass(frozen=True)
class OverlapSet:
    """The pairs of a data set, what is said about them, and how they are shown.

    Attributes
    ----------
    title, data, meshes
        Name of the data set, what its numbers mean, and where its triangles come from.
    settings
        How pairs are shown; rotation turns both shapes.
    pairs
        Names are unique; the first few are of all kinds.
    """

    title: str
    data: str
    meshes: str
    settings: BenchmarkSettings
    pairs: tuple[OverlapSource, ...]
