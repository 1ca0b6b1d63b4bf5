"""Puzzles cut from animated shapes: every piece from another pose, meshed anew and turned."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.benchmark.datasets.pairs import seed_of
from sherd.errors import MeshFileError
from sherd.files.mesh_files import read_mesh
from sherd.limits import require_whole
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes.fragment import Fragment, moved, remeshed, with_clutter
from sherd.shapes.puzzle import puzzle_balls, puzzle_pieces
from sherd.spectral.sampling import decimate

__all__ = [
    "COUNTS",
    "CUTS",
    "KINDS",
    "OVERLAP",
    "OVERLAPPING_FOREIGN",
    "Puzzle",
    "PuzzleSource",
    "animated_shapes",
    "puzzle_sources",
]

# As many as the SHREC'16 shapes have; the animations have fewer and stay as they are.
VERTICES = 10_000
COUNTS = (4, 8, 2, 12)
# Edges of pieces over those of the whole.
EDGES = (0.85, 1.0, 1.2)
OVERLAP, CLUTTER = 0.1, 0.05
# A foreign piece is one of so many of its own whole.
FOREIGN_COUNT = 4
KINDS = ("disjoint", "overlapping", "missing", "foreign", "missing and foreign", "clutter")
# What is joined without a whole.
OVERLAPPING_FOREIGN = "overlapping and foreign"
# How wholes are cut: into the cells of points that lie far apart, or balls about these, all of one
# area.
CUTS = {"cells": puzzle_pieces, "balls": puzzle_balls}
SUFFIXES = (".obj", ".off", ".ply")


@dataclass(frozen=True, eq=False)
class Puzzle:
    """A whole, pieces of it, pieces of something else, and where all belong.

    Attributes
    ----------
    full
        The whole.
    own
        Pieces of the whole, with their truth.
    foreign
        Pieces of other things, the whole of which had the same area.
    labels
        (n,) the piece whose cell each vertex of the whole is in; -1 where the piece is missing.
    """

    full: TriangleMesh
    own: tuple[Fragment, ...]
    foreign: tuple[TriangleMesh, ...]
    labels: Ints

    @property
    def allowed(self) -> Bools:
        """(k + 1, n) bool, whether a vertex may be given to each piece of its own, or to the gap.

        Where pieces overlap either is right.
        """
        covered = np.array([piece.region for piece in self.own])
        cells = self.labels[None, :] == np.arange(len(self.own))[:, None]
        both: Bools = np.concatenate([covered | cells, (self.labels < 0)[None, :]])
        # a border vertex that no piece covers by half belongs to its cell alone
        return both


@dataclass(frozen=True)
class PuzzleSource:
    """One puzzle that is not cut yet.

    Attributes
    ----------
    path, others
        Of the animated shape, and of those that foreign pieces come from.
    kind
        One of KINDS.
    count
        Into how many pieces the whole is cut.
    individual
        Whether foreign pieces are of another individual of the same kind.
    overlap
        Share of its area that each piece reaches beyond its cell, if the kind overlaps; of balls
        see :func:`sherd.shapes.puzzle.puzzle_balls`.
    cut
        One of CUTS.
    """

    path: Path
    others: tuple[Path, ...]
    kind: str
    count: int
    individual: bool = False
    overlap: float = OVERLAP
    cut: str = "cells"

    @property
    def name(self) -> str:
        """Unique within a run."""
        return self._cut_as if self.overlap == OVERLAP else f"{self._cut_as} by {self.overlap:g}"

    @property
    def _cut_as(self) -> str:
        """What the choice of places and poses follows from: the same for all overlaps."""
        who = ", same kind" if self.individual else ""
        how = "" if self.cut == "cells" else f", {self.cut}"
        return f"{shape_name(self.path)} {self.count} {self.kind}{who}{how}"

    @property
    def group(self) -> str:
        """What it is averaged with."""
        return f"{self.kind}, another individual" if self.individual else self.kind

    def load(self) -> Puzzle:
        """Cut the puzzle.

        Raises
        ------
        MeshFileError
            If a file is missing or damaged.
        """
        rng = np.random.default_rng(seed_of(self._cut_as, 0))
        poses = animated_shapes(self.path)
        full = poses[0]
        order = 1 + rng.permutation(len(poses) - 1)
        posed = [poses[order[k % len(order)]] for k in range(self.count)]
        overlap = self.overlap if "overlapping" in self.kind else 0.0
        start = int(rng.integers(full.vertex_count))
        cut = CUTS[self.cut](full, posed, start=start, overlap=overlap)
        labels = _cells(cut, full)
        number = 1 if self.count < 8 else 2
        gone = rng.permutation(self.count)[: number if "missing" in self.kind else 0]
        kept = [k for k in range(self.count) if k not in gone]
        renamed = np.full(self.count + 1, -1, dtype=np.int64)
        renamed[kept] = np.arange(len(kept))
        own = [_shown(cut[k], f"{k}.ply", rng) for k in kept]
        if self.kind == "clutter":
            own[0] = with_clutter(own[0], CLUTTER, rng=rng)
        foreign = [_foreign(self.others[k % len(self.others)], full, rng) for k in range(number)]
        if "foreign" not in self.kind:
            foreign = []
        return Puzzle(full, tuple(own), tuple(foreign), renamed[labels])


def puzzle_sources(
    directory: Path, individuals: Path | None = None, *, counts: tuple[int, ...] = COUNTS
) -> tuple[PuzzleSource, ...]:
    """All puzzles of a folder with animated shapes, so ordered that the first few are of all kinds.

    Parameters
    ----------
    directory
        Holds for each shape an ``.npz`` file with `vertices` (poses, n, 3) and `faces`, or a folder
        of meshes with the same faces.
    individuals
        Another such folder: shapes of the same kind there, by the first word of their names, are
        other individuals.
    counts
        Into how many pieces wholes are cut, from 2 to 16.

    Raises
    ------
    MeshFileError
        If there are no animated shapes.
    OptionError
        If a count is out of range.
    """
    for count in counts:
        require_whole("pieces", count, 2, 16, "smaller pieces have too little to be told apart by")
    paths = _shapes(directory)
    found = []
    for count in counts:
        for path in paths:
            others = tuple(each for each in paths if each != path)
            for kind in KINDS:
                if ("missing" in kind and count < 3) or ("foreign" in kind and not others):
                    continue
                found.append(PuzzleSource(path, others, kind, count))
    if individuals is not None:
        for path in paths:
            alike = tuple(each for each in _shapes(individuals) if _species(each) == _species(path))
            found += [
                PuzzleSource(path, alike, "foreign", count, individual=True)
                for count in counts
                if alike
            ]
    return tuple(sorted(found, key=lambda source: (source.count > 8, seed_of(source.name, 1))))


@lru_cache(maxsize=3)
def animated_shapes(path: Path) -> tuple[TriangleMesh, ...]:
    """The poses of one animated shape, all with the same faces; the rest pose first if it is named.

    Raises
    ------
    MeshFileError
        If a file is missing or damaged, or the poses differ in their faces.
    """
    try:
        vertices, faces = _stored(path) if path.suffix == ".npz" else _read(path)
    except (OSError, ValueError, KeyError) as error:
        raise MeshFileError(f"{path}: cannot be read as an animated shape ({error})") from error
    first = TriangleMesh(vertices[0], faces)
    if first.vertex_count > VERTICES:
        light, points = decimate(first, VERTICES)
        corners = faces[points.faces]
        vertices = np.einsum("pk,tpkx->tpx", points.barycentric, vertices[:, corners])
        faces = light.faces
    name = shape_name(path)
    return tuple(
        TriangleMesh(pose, faces, name=f"{name}-{k}.ply") for k, pose in enumerate(vertices)
    )


def shape_name(path: Path) -> str:
    """What an animated shape is called."""
    return path.stem


def _shapes(directory: Path) -> list[Path]:
    found = [path for path in sorted(directory.glob("*")) if path.suffix == ".npz" or path.is_dir()]
    if not found:
        raise MeshFileError(
            f"{directory}: holds no animated shapes, neither .npz files nor folders"
        )
    return found


def _species(path: Path) -> str:
    return re.split(r"[^a-z]", path.stem.lower())[0]


def _stored(path: Path) -> tuple[Floats, Ints]:
    with np.load(path, allow_pickle=False) as stored:
        return stored["vertices"].astype(np.float64), stored["faces"].astype(np.int64)


def _read(path: Path) -> tuple[Floats, Ints]:
    files = sorted(file for file in path.iterdir() if file.suffix in SUFFIXES)
    files.sort(key=lambda file: "rest" not in file.name)
    meshes = [read_mesh(file) for file in files]
    for file, mesh in zip(files, meshes, strict=True):
        if not np.array_equal(mesh.faces, meshes[0].faces):
            raise MeshFileError(f"{file}: has other faces than {files[0]}")
    return np.array([mesh.vertices for mesh in meshes]), meshes[0].faces


def _cells(cut: tuple[Fragment, ...], full: TriangleMesh) -> Ints:
    """The piece (n,) that covers each vertex; the first of several."""
    covered = np.array([piece.region for piece in cut])
    labels: Ints = covered.argmax(axis=0)
    # vertices on a border, of which no piece covers half: as most of their neighbors
    open_rows = np.flatnonzero(~covered.any(axis=0))
    first, second = full.edges.T
    for row in open_rows:
        near = np.concatenate([second[first == row], first[second == row]])
        near = near[covered[:, near].any(axis=0)]
        labels[row] = np.bincount(labels[near]).argmax() if len(near) else -1
    return labels


def _shown(piece: Fragment, name: str, rng: np.random.Generator) -> Fragment:
    """Meshed anew and turned."""
    shown = moved(remeshed(piece, float(rng.choice(EDGES))), rng)
    mesh = TriangleMesh(shown.mesh.vertices, shown.mesh.faces, name=name)
    return replace(shown, mesh=mesh)


def _foreign(path: Path, full: TriangleMesh, rng: np.random.Generator) -> TriangleMesh:
    poses = animated_shapes(path)
    whole = poses[0]
    posed = [poses[int(k)] for k in rng.integers(len(poses), size=FOREIGN_COUNT)]
    start = int(rng.integers(whole.vertex_count))
    cut = puzzle_pieces(whole, posed, start=start)[int(rng.integers(FOREIGN_COUNT))]
    mesh = _shown(cut, f"{shape_name(path)}.ply", rng).mesh
    return mesh.with_vertices(mesh.vertices * full.length / whole.length)
