"""Parts of one person matched with the body of another: FAUST, bodies each meshed on its own."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sherd.arrays import Ints
from sherd.benchmark.datasets.landmark_truth import landmark_map
from sherd.benchmark.datasets.pairs import BenchmarkSettings, Pair, PairSet, seed_of
from sherd.benchmark.datasets.random_cuts import CUTS, random_cut
from sherd.errors import MeshFileError
from sherd.files.mesh_files import read_mesh
from sherd.mesh.surface_points import SurfacePoints, closest_points
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["PersonPair", "faust_pairs", "faust_set"]


BODY_NAME = re.compile(r"tr_reg_(\d+)(\d)")


@dataclass(frozen=True)
class PersonPair:
    """A body, and another person's body that a part is cut from.

    Row i of the landmark files, ``corres/<body>.vts``, is the same point of every body, as a vertex
    counted from 1; row i of ``<body>.sym.vts`` is its left/right mirror image.
    """

    name: str
    kind: str
    full: Path
    body: Path
    seed: int

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Both meshes and their landmarks."""
        tables = (_table(self.full), _table(self.body), _table(self.full, mirrored=True))
        return (self.full, self.body, *tables)

    def load(self) -> Pair:
        """Read both bodies, bring the second to the area of the first, and cut.

        Vertices of the part lie on known points of their own body; the map of that body from the
        landmarks (:func:`sherd.benchmark.datasets.landmark_truth.landmark_map`) takes them to the
        other one. The mirrored truth comes the same way from the full shape's mirrored landmarks.

        Raises
        ------
        MeshFileError
            If a file is missing or the landmarks do not fit the bodies.
        InputError
            If landmarks are too sparse.
        """
        full, body = read_mesh(self.full), read_mesh(self.body)
        body = body.with_vertices(body.vertices * (full.length / body.length))
        part = random_cut(body, self.kind, np.random.default_rng(seed_of(self.name, self.seed)))
        places = _landmarks(_table(self.body), body)
        targets = _landmarks(_table(self.full), full)
        truth = _carried(full, part.truth, body, (places, targets), mirrored=False)
        mirror = _table(self.full, mirrored=True)
        mirrored_truth = None
        if mirror.exists():
            targets = _landmarks(mirror, full)
            mirrored_truth = _carried(full, part.truth, body, (places, targets), mirrored=True)
        return Pair(self.name, full, part.mesh, truth, mirrored_truth)


def faust_pairs(directory: Path, *, seed: int = 0) -> tuple[PersonPair, ...]:
    """For every person a part of each kind, cut from other people in other poses.

    The full shape is the first body of the person. Among the bodies of other persons in
    other poses, in order of number, the k-th part of the i-th person comes from number 3 i + k,
    counted around.

    Parameters
    ----------
    directory
        Folder with ``tr_reg_<person><pose>.off``, the last digit being the pose, and ``corres/``.
    seed
        Of the cuts.

    Raises
    ------
    MeshFileError
        If the folder holds no two persons in different poses.
    """
    bodies = {
        match.groups(): path
        for path in sorted(directory.glob("*.off"))
        if (match := BODY_NAME.fullmatch(path.stem))
    }
    persons = sorted({person for person, _ in bodies})
    found = []
    for number, person in enumerate(persons):
        pose = min(pose for other, pose in bodies if other == person)
        full = bodies[person, pose]
        others = [path for key, path in bodies.items() if key[0] != person and key[1] != pose]
        for count, kind in enumerate(CUTS if others else ()):
            body = others[(len(CUTS) * number + count) % len(others)]
            name = f"{full.stem}_{kind.replace(' ', '-')}_of_{body.stem}"
            found.append(PersonPair(name, kind, full, body, seed))
    if not found:
        raise MeshFileError(
            f"{directory}: holds no bodies tr_reg_<number>.off of two persons in different poses"
        )
    return tuple(found)


def faust_set(directory: Path, settings: BenchmarkSettings | None = None) -> PairSet:
    """All pairs, cut and shown as `settings` (the defaults if None) say.

    Raises
    ------
    MeshFileError
        See :func:`faust_pairs`.
    """
    settings = settings or BenchmarkSettings()
    return PairSet(
        title="different people (FAUST)",
        data="FAUST, parts of one person on the body of another in another pose; the method is "
        "not trained; bodies brought to one area; truth from landmarks",
        meshes="as stored, each body meshed on its own",
        settings=settings,
        pairs=faust_pairs(directory, seed=settings.seed),
    )


def _carried(
    full: TriangleMesh,
    points: SurfacePoints,
    body: TriangleMesh,
    landmarks: tuple[Ints, Ints],
    *,
    mirrored: bool,
) -> SurfacePoints:
    """Points of the body taken to the full shape by the landmark map of its vertices."""
    places = landmark_map(body, full, landmarks, mirrored=mirrored).positions(full)
    return closest_points(full, points.interpolate(body, places))


def _table(body: Path, *, mirrored: bool = False) -> Path:
    return body.parent / "corres" / (f"{body.stem}.sym.vts" if mirrored else f"{body.stem}.vts")


def _landmarks(path: Path, mesh: TriangleMesh) -> Ints:
    try:
        rows = np.loadtxt(path, dtype=np.int64, ndmin=1) - 1  # counted from 1 in the files
    except (OSError, ValueError) as error:
        raise MeshFileError(f"{path}: cannot be read as landmarks ({error})") from error
    if rows.ndim != 1 or not len(rows) or not 0 <= rows.min() <= rows.max() < mesh.vertex_count:
        raise MeshFileError(f"{path}: vertices 1..{mesh.vertex_count} are needed, one on each line")
    return rows
