"""Pairs of single-camera views: full of holes, a third of their vertices on ragged borders."""

from __future__ import annotations

import re
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sherd.arrays import Ints
from sherd.benchmark.datasets.overlaps import OverlapPair, OverlapSet
from sherd.benchmark.datasets.pairs import BenchmarkSettings, seed_of
from sherd.errors import MeshFileError
from sherd.mesh.surface_points import points_at_vertices
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["ViewPair", "single_view_set"]

FILE_NAME = re.compile(r"\w+?_\d+_([a-z]+)\d+_([a-z]+)\d+")
NAMES = (
    "vertices_1", "faces_1", "vertices_2", "faces_2", "map_12", "map_21",
    "sqrt_area_full_1", "sqrt_area_full_2",
)  # fmt: skip


@dataclass(frozen=True)
class ViewPair:
    """The file of one pair of views."""

    name: str
    kind: str
    file: Path

    @property
    def inputs(self) -> tuple[Path, ...]:
        """The file."""
        return (self.file,)

    def load(self) -> OverlapPair:
        """Read both views, each divided by sqrt(area) of what it was taken of.

        Raises
        ------
        MeshFileError
            If the file is missing, damaged, or its maps do not fit its meshes.
        """
        content = _content(self.file)
        first, second = (
            TriangleMesh(
                content[f"vertices_{k}"] / float(content[f"sqrt_area_full_{k}"]),
                content[f"faces_{k}"],
                name=f"{self.name}_{k}",
            )
            for k in (1, 2)
        )
        there = _map(self.file, content["map_12"], first, second)
        back = _map(self.file, content["map_21"], second, first)
        anywhere = int(first.faces[0, 0])
        return OverlapPair(
            self.name,
            first,
            second,
            points_at_vertices(first, np.where(back >= 0, back, anywhere)),
            there >= 0,
            back >= 0,
            1.0,
        )


def single_view_set(directory: Path, settings: BenchmarkSettings | None = None) -> OverlapSet:
    """All pairs of a folder of ``<set>_<number>_<shape>_<shape>.npz``, of kind "michael", ...

    Raises
    ------
    MeshFileError
        If the folder holds no such file.
    """
    found = []
    for path in sorted(directory.glob("*.npz")):
        match = FILE_NAME.fullmatch(path.stem)
        if match:
            kind = " and ".join(sorted(set(match.groups())))
            found.append(ViewPair(path.stem, kind, path))
    if not found:
        raise MeshFileError(f"{directory}: holds no files like train_00411_horse5_wolf0.npz")
    return OverlapSet(
        title="single-camera views (after BeCoS)",
        data="single-camera views rebuilt after BeCoS; the method is not trained; errors of the "
        "truly shared vertices, in square roots of the whole's area",
        meshes="as stored",
        settings=settings or BenchmarkSettings(),
        pairs=tuple(sorted(found, key=lambda pair: seed_of(pair.name, 0))),
    )


def _content(path: Path) -> dict[str, Any]:
    try:
        with np.load(path, allow_pickle=False) as stored:
            content: dict[str, Any] = dict(stored)
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        raise MeshFileError(f"{path}: cannot be read as a pair of views ({error})") from error
    missing = [name for name in NAMES if name not in content]
    if missing:
        raise MeshFileError(f"{path}: has no array {missing[0]}")
    return content


def _map(path: Path, rows: Any, shape: TriangleMesh, other: TriangleMesh) -> Ints:
    vertices: Ints = np.asarray(rows, dtype=np.int64)
    if vertices.shape != (shape.vertex_count,):
        raise MeshFileError(f"{path}: a map has {len(vertices)} rows, not {shape.vertex_count}")
    if len(vertices) and not -1 <= vertices.min() <= vertices.max() < other.vertex_count:
        raise MeshFileError(f"{path}: a map names a vertex outside -1..{other.vertex_count - 1}")
    return vertices
