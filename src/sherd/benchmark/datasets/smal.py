"""Parts of animals matched with parts of other animals: SMAL shapes, cut on both sides."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sherd.arrays import Ints
from sherd.benchmark.datasets.overlaps import OverlapPair, OverlapSet
from sherd.benchmark.datasets.pairs import BenchmarkSettings, Pair, PairSet, seed_of
from sherd.errors import MeshFileError
from sherd.files.mesh_files import read_mesh
from sherd.mesh.surface_points import points_at_vertices
from sherd.shapes.truth import true_region

__all__ = ["AnimalOverlap", "AnimalParts", "smal_overlap_set", "smal_pairs", "smal_set"]


MAP_NAME = re.compile(r"(\w+?_\d+_([a-z]+)_\d+)_(\w+?_\d+_([a-z]+)_\d+)")


@dataclass(frozen=True)
class AnimalParts:
    """The files of one pair: `part` is matched with `full`, itself a part of another animal.

    Row i of `table` is the vertex of `full`, counted from 0, that vertex i of `part`
    corresponds to, or -1 where `full` lacks it.
    """

    name: str
    kind: str
    full: Path
    part: Path
    table: Path

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Both meshes and the map."""
        return (self.full, self.part, self.table)

    def load(self) -> Pair:
        """Read meshes and map. The truth is at vertices: right to about half an edge.

        Raises
        ------
        MeshFileError
            If a file is missing or the map does not fit the meshes.
        """
        full, part = read_mesh(self.full), read_mesh(self.part)
        rows = _vertices(self.table, part.vertex_count, full.vertex_count)
        present = rows >= 0
        if not present.any():
            raise MeshFileError(f"{self.table}: every row is -1, but some vertex must have a place")
        anywhere = int(full.faces[0, 0])
        truth = points_at_vertices(full, np.where(present, rows, anywhere))
        return Pair(self.name, full, part, truth, None, present)


@dataclass(frozen=True)
class AnimalOverlap:
    """The same pair, asked for what both parts share; the first shape is `full`."""

    parts: AnimalParts

    @property
    def name(self) -> str:
        """Name of the map."""
        return self.parts.name

    @property
    def kind(self) -> str:
        """Same or other species."""
        return self.parts.kind

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Both meshes and the map."""
        return self.parts.inputs

    def load(self) -> OverlapPair:
        """Read meshes and map; what the first shape shares is what the map's faces cover.

        Raises
        ------
        MeshFileError
            If a file is missing or the map does not fit the meshes.
        """
        pair = self.parts.load()
        there = np.ones(pair.part.vertex_count, bool) if pair.present is None else pair.present
        covered = true_region(pair.full, pair.part, pair.truth, present=there)
        # the stored parts are cut from animals with sqrt(area) = 1
        return OverlapPair(pair.name, pair.full, pair.part, pair.truth, covered, there, 1.0)


def smal_pairs(directory: Path) -> tuple[AnimalParts, ...]:
    """All pairs of a folder, by name, of kind ``"same species"`` or ``"other species"``.

    Parameters
    ----------
    directory
        Folder with ``shapes/<shape>.off`` and ``maps/<part>_<full>.vts``, a shape being called
        ``cuts_<number>_<species>_<number>``.

    Raises
    ------
    MeshFileError
        If the folder holds no such map.
    """
    found = []
    for table in sorted((directory / "maps").glob("*.vts")):
        match = MAP_NAME.fullmatch(table.stem)
        if match:
            part, species, full, other = match.groups()
            kind = "same species" if species == other else "other species"
            shapes = directory / "shapes"
            found.append(
                AnimalParts(table.stem, kind, shapes / f"{full}.off", shapes / f"{part}.off", table)
            )
    if not found:
        raise MeshFileError(
            f"{directory / 'maps'}: holds no files named <part>_<full>.vts with shapes like "
            "cuts_1_dog_06; give the folder that has maps/ and shapes/ in it"
        )
    return tuple(found)


def smal_set(directory: Path, settings: BenchmarkSettings | None = None) -> PairSet:
    """All pairs of a folder, shown as `settings` (the defaults if None) say.

    `match` assumes that the full shape is full; here it is not, so some vertices of the part have
    no place, and a part larger than the full shape is refused. Lengths are relative to the area of
    the second shape as stored, a part.

    Raises
    ------
    MeshFileError
        See :func:`smal_pairs`.
    """
    return PairSet(
        title="parts of different animals (SMAL)",
        data="SMAL, parts matched with parts; the method is not trained and takes the second "
        "for a full shape; errors of vertices inside the overlap",
        meshes="as stored",
        settings=settings or BenchmarkSettings(),
        pairs=smal_pairs(directory),
    )


def smal_overlap_set(directory: Path, settings: BenchmarkSettings | None = None) -> OverlapSet:
    """All pairs of a folder, asked for what both parts share.

    Raises
    ------
    MeshFileError
        See :func:`smal_pairs`.
    """
    pairs = sorted(smal_pairs(directory), key=lambda pair: seed_of(pair.name, 0))
    return OverlapSet(
        title="parts of different animals (PSMAL)",
        data="SMAL, parts of different animals; the method is not trained; errors of the truly "
        "shared vertices, in square roots of the whole's area",
        meshes="as stored",
        settings=settings or BenchmarkSettings(),
        pairs=tuple(AnimalOverlap(parts) for parts in pairs),
    )


def _vertices(path: Path, count: int, full_count: int) -> Ints:
    try:
        rows = np.loadtxt(path, dtype=np.int64, ndmin=1)
    except (OSError, ValueError) as error:
        raise MeshFileError(f"{path}: cannot be read as a map ({error})") from error
    if rows.shape != (count,):
        raise MeshFileError(
            f"{path}: has shape {rows.shape}, but a row for each of the {count} vertices is needed"
        )
    if len(rows) and not -1 <= rows.min() <= rows.max() < full_count:
        raise MeshFileError(f"{path}: names a vertex outside -1..{full_count - 1}")
    return rows
