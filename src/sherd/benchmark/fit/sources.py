"""Wholes and parts of them in another pose, of another person, or of another skull, with truth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.benchmark.datasets.pairs import seed_of
from sherd.benchmark.puzzle.sources import EDGES, animated_shapes
from sherd.errors import MeshFileError
from sherd.mesh.geometry import closest_rotation
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes.camera_view import seen_by_camera
from sherd.shapes.fragment import Fragment, cut_by_level, largest_piece, moved, remeshed, whole
from sherd.spectral.geodesics import Geodesics

__all__ = ["CUTS", "FitPair", "FitSource", "fit_sources"]

# Share of the area within a geodesic ball, or what one camera sees.
CUTS = ("0.35", "0.5", "0.7", "camera")
FACES_FILE = "faces.npz"


@dataclass(frozen=True, eq=False)
class FitPair:
    """A full shape, a part of the same in another shape, and where all of the full one is.

    Attributes
    ----------
    full, part
        What is given.
    truth
        (n, 3) where each vertex of the full shape is, in the frame of the part.
    seen
        (n,) which of them the part covers.
    """

    full: TriangleMesh
    part: TriangleMesh
    truth: Floats
    seen: Bools


@dataclass(frozen=True)
class FitSource:
    """One pair that is not cut yet: which file, which of its shapes, and how it is cut."""

    path: Path
    number: int
    cut: str

    @property
    def name(self) -> str:
        """Unique within a run."""
        return f"{self.path.stem} {self.number} {self.cut}"

    @property
    def group(self) -> str:
        """What it is averaged with."""
        return f"faces {self.cut}" if self.path.name == FACES_FILE else self.cut

    def load(self) -> FitPair:
        """Cut the part, mesh it anew and turn it.

        Raises
        ------
        MeshFileError
            If a file is missing or damaged.
        """
        rng = np.random.default_rng(seed_of(self.name, 0))
        full, other = _shapes(self.path, self.number)
        cut = _cut(whole(other, full), self.cut, rng)
        seen = cut.region
        here = remeshed(cut, float(rng.choice(EDGES)))
        there = moved(here, rng)
        weights = np.ones(here.mesh.vertex_count)
        turn = closest_rotation(here.mesh.vertices, there.mesh.vertices, weights)
        shift = there.mesh.vertices.mean(axis=0) - here.mesh.vertices.mean(axis=0) @ turn.T
        part = TriangleMesh(there.mesh.vertices, there.mesh.faces, name="part.ply")
        return FitPair(full, part, other.vertices @ turn.T + shift, seen)


def fit_sources(directory: Path, poses: int) -> tuple[FitSource, ...]:
    """All pairs of a folder, so ordered that the first few are of all kinds.

    Parameters
    ----------
    directory
        Holds for each animated shape an ``.npz`` file with `vertices` (poses, n, 3) and `faces`,
        or a folder of meshes with the same faces; or ``faces.npz`` with a template and people.
    poses
        So many poses, or people, of each.

    Raises
    ------
    MeshFileError
        If there is nothing of the kind.
    """
    paths = [path for path in sorted(directory.glob("*")) if path.suffix == ".npz" or path.is_dir()]
    if not paths:
        raise MeshFileError(f"{directory}: holds neither .npz files nor folders of meshes")
    found = [
        FitSource(path, 1 + number, cut)
        for path in paths
        for number in range(min(poses, _count(path) - 1))
        for cut in CUTS
    ]
    return tuple(sorted(found, key=lambda source: seed_of(source.name, 1)))


def _count(path: Path) -> int:
    return len(_faces(path)[1]) if path.name == FACES_FILE else len(animated_shapes(path))


def _shapes(path: Path, number: int) -> tuple[TriangleMesh, TriangleMesh]:
    """The full shape, and the same in another pose or of another person."""
    if path.name == FACES_FILE:
        template, people, faces = _faces(path)
        full = TriangleMesh(template, faces, name="template.ply")
        return full, TriangleMesh(people[number], faces, name="person.ply")
    poses = animated_shapes(path)
    return poses[0], poses[number]


def _faces(path: Path) -> tuple[Floats, Floats, Ints]:
    try:
        with np.load(path, allow_pickle=False) as stored:
            people = stored["vertices"].astype(np.float64)
            template = stored["template_vertices"].astype(np.float64)
            return template, people, stored["template_faces"].astype(np.int64)
    except (OSError, ValueError, KeyError) as error:
        raise MeshFileError(f"{path}: cannot be read as faces ({error})") from error


def _cut(body: Fragment, cut: str, rng: np.random.Generator) -> Fragment:
    cutter: Callable[[Fragment, np.random.Generator], Fragment] = (
        _view if cut == "camera" else lambda b, r: _ball(b, float(cut), r)
    )
    return cutter(body, rng)


def _ball(body: Fragment, share: float, rng: np.random.Generator) -> Fragment:
    """What lies nearest to a random point, by `share` of the area."""
    areas = body.mesh.vertex_areas
    center = int(rng.choice(len(areas), p=areas / areas.sum()))
    distance = Geodesics(body.mesh).distances_from(center)[0]
    order = np.argsort(distance)
    reached = np.cumsum(areas[order]) / areas.sum()
    last = min(int(np.searchsorted(reached, share)), len(order) - 1)
    level = distance[order[last]]
    return largest_piece(cut_by_level(body, level - distance))


def _view(body: Fragment, rng: np.random.Generator) -> Fragment:
    """What a far camera sees from a random direction."""
    return seen_by_camera(body, np.linalg.qr(rng.normal(size=(3, 3)))[0])
