"""Parts cut from people and animals in other poses: SHREC'16, as stored or meshed anew."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np

from sherd.arrays import Floats
from sherd.benchmark.datasets.pairs import BenchmarkSettings, Pair, PairSet
from sherd.errors import MeshFileError, OptionError
from sherd.files.mesh_files import read_mesh
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["KINDS", "PairFiles", "shrec16_pairs", "shrec16_set"]

KINDS = ("cuts", "holes")


@dataclass(frozen=True)
class PairFiles:
    """The files of one pair of SHREC'16, stored or meshed anew."""

    name: str
    kind: str
    full: Path
    part: Path

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Meshes and ground truth."""
        truths = [self.part.with_suffix(end) for end in (".baryc_gt", ".baryc_gt_sym")]
        return (self.full, self.part, *truths)

    def load(self) -> Pair:
        """Read meshes and ground truth.

        Raises
        ------
        MeshFileError
            If a file is missing or the ground truth does not fit the part.
        """
        full, part = read_mesh(self.full), read_mesh(self.part)
        mirrored = self.part.with_suffix(".baryc_gt_sym")
        return Pair(
            self.name,
            full,
            part,
            _truth(self.part.with_suffix(".baryc_gt"), full, part),
            _truth(mirrored, full, part) if mirrored.exists() else None,
        )


def shrec16_pairs(
    directory: Path, *, kind: str, remeshed: Path | None = None
) -> tuple[PairFiles, ...]:
    """All pairs of one kind, in order of shape number, then class.

    Parameters
    ----------
    directory
        Folder with ``null/<class>.off`` and ``<kind>/<kind>_<class>_shape_<number>.off``.
    kind
        ``"cuts"`` or ``"holes"``.
    remeshed
        Folder with the same parts meshed anew; the stored ones if None.

    Raises
    ------
    MeshFileError
        If the folders hold no such pair.
    """
    folder = (remeshed or directory) / kind
    pattern = re.compile(rf"{kind}_(\w+)_shape_(\d+)\.off")
    found = []
    for part in folder.glob("*.off"):
        match = pattern.fullmatch(part.name)
        if match:
            name, number = match.group(1), int(match.group(2))
            full = directory / "null" / f"{name}.off"
            found.append((number, name, PairFiles(part.stem, kind, full, part)))
    if not found:
        raise MeshFileError(
            f"{folder}: holds no files named {kind}_<class>_shape_<number>.off; give the folder "
            "of SHREC'16 that has null/, cuts/ and holes/ in it"
        )
    return tuple(pair for _, _, pair in sorted(found, key=lambda entry: entry[:2]))


def shrec16_set(
    directory: Path,
    settings: BenchmarkSettings | None = None,
    *,
    kinds: tuple[str, ...] = KINDS,
    remeshed: Path | None = None,
) -> PairSet:
    """All pairs of some kinds, shown as `settings` say.

    Parameters
    ----------
    directory, remeshed
        See :func:`shrec16_pairs`.
    settings
        The defaults if None.
    kinds
        ``"cuts"``, ``"holes"`` or both.

    Raises
    ------
    MeshFileError
        If the folders hold no pair of some kind.
    OptionError
        If a kind is unknown or none is given.
    """
    if not kinds or set(kinds) - set(KINDS):
        raise OptionError(f'kinds is {kinds}, but "cuts" and "holes" can be measured')
    pairs = [shrec16_pairs(directory, kind=kind, remeshed=remeshed) for kind in kinds]
    return PairSet(
        title="SHREC'16",
        data="SHREC'16 training set; the method is not trained",
        meshes="as stored" if remeshed is None else "remeshed",
        settings=settings or BenchmarkSettings(),
        pairs=tuple(chain.from_iterable(pairs)),
    )


def _truth(path: Path, full: TriangleMesh, part: TriangleMesh) -> SurfacePoints:
    try:
        table: Floats = np.loadtxt(path, ndmin=2)
    except (OSError, ValueError) as error:
        raise MeshFileError(f"{path}: cannot be read as ground truth ({error})") from error
    if table.shape != (part.vertex_count, 4):
        raise MeshFileError(
            f"{path}: has shape {table.shape}, but a face and three weights are needed for each of "
            f"the {part.vertex_count} vertices"
        )
    faces = table[:, 0].astype(np.int64) - 1  # counted from 1 in the files
    if len(faces) and not 0 <= faces.min() <= faces.max() < full.face_count:
        raise MeshFileError(f"{path}: names a face outside 1..{full.face_count}")
    weights = np.clip(table[:, 1:], 0.0, 1.0)
    return SurfacePoints(faces, weights / weights.sum(axis=1, keepdims=True))
