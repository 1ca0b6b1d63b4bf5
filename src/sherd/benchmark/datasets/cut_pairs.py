"""Pairs of cuts of one shape in different poses: SHREC'16 cuts, two and two (CP2P)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np

from sherd.arrays import Bools
from sherd.benchmark.datasets.overlaps import OverlapPair, OverlapSet
from sherd.benchmark.datasets.pairs import BenchmarkSettings, Pair, seed_of
from sherd.benchmark.datasets.shrec16 import PairFiles, shrec16_pairs
from sherd.errors import MeshFileError
from sherd.mesh.geometry import vertex_normals
from sherd.mesh.surface_finder import SurfaceFinder
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes.truth import true_region

__all__ = ["CutPair", "cut_pair_set", "points_on_other_part"]

# Share of the larger cut: with less there is nothing to find, with more nothing to decide.
LEAST_SHARE, MOST_SHARE = 0.1, 0.9
# 20 of the about 70 pairs of each class that share so much.
PAIRS_OF_CLASS = 20
# Two parts meshed anew lie on one surface up to the height of a chord's arc, far below an edge;
# beyond the border of a part its closest point is farther away the farther a point lies outside.
NEAR_IN_EDGES = 0.25


@dataclass(frozen=True)
class CutPair:
    """The files of two cuts of one class, each with its ground truth on the whole."""

    first: PairFiles
    second: PairFiles

    @property
    def name(self) -> str:
        """Both names, without what they have in common."""
        kind, number = self.kind, self.second.name.rpartition("_")[2]
        return f"{kind} {self.first.name.rpartition('_')[2]} {number}"

    @property
    def kind(self) -> str:
        """The class."""
        return self.first.full.stem

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Meshes and ground truths."""
        return self.first.inputs + self.second.inputs

    def load(self) -> OverlapPair:
        """Read both cuts; what they share follows from where both lie on the whole.

        Raises
        ------
        MeshFileError
            If a file is missing or a ground truth does not fit its part.
        """
        first, second = self.first.load(), self.second.load()
        truth, second_shared = points_on_other_part(first, second)
        _, first_shared = points_on_other_part(second, first)
        return OverlapPair(
            self.name, first.part, second.part, truth, first_shared, second_shared,
            first.full.length,
        )  # fmt: skip


def points_on_other_part(first: Pair, second: Pair) -> tuple[SurfacePoints, Bools]:
    """Where the vertices of `second` lie on `first`, parts of one whole, and which do.

    The faces of `first` are laid on the whole; a vertex of `second` is shared if its own place
    there is on them, up to a quarter of an edge, on a side that looks the same way.
    """
    whole = first.full
    laid = first.truth.positions(whole) / whole.length
    image = TriangleMesh(laid, first.part.faces, name=first.part.name)
    places = second.truth.positions(whole) / whole.length
    normals = vertex_normals(places, second.part.faces)
    points = SurfaceFinder(image).closest(places, normals)
    off = np.linalg.norm(points.positions(image) - places, axis=1)
    agree = np.einsum("px,px->p", image.face_normals[points.faces], normals) > 0
    return points, (off <= NEAR_IN_EDGES * image.mean_edge_length) & agree


def cut_pair_set(
    directory: Path, settings: BenchmarkSettings | None = None, *, remeshed: Path | None = None
) -> OverlapSet:
    """Pairs of cuts of one class that share 0.1 to 0.9 of the larger, 20 of each class.

    Which pairs is decided by a hash of their names; they come class by class in turn.

    Parameters
    ----------
    directory, remeshed
        See :func:`sherd.benchmark.datasets.shrec16.shrec16_pairs`.
    settings
        The defaults if None.

    Raises
    ------
    MeshFileError
        If no two cuts share so much, or a file is missing or damaged.
    """
    by_class: dict[str, list[PairFiles]] = {}
    for files in shrec16_pairs(directory, kind="cuts"):
        by_class.setdefault(files.full.stem, []).append(files)
    anew = {} if remeshed is None else _by_name(directory, remeshed)
    chosen: list[tuple[int, str, CutPair]] = []
    for name, cuts in by_class.items():
        # what is shared is read off the stored cuts, so that the pairs are the same meshed anew
        shared = [CutPair(*two) for two in _sharing(cuts)]
        shared = sorted(shared, key=lambda pair: seed_of(pair.name, 0))[:PAIRS_OF_CLASS]
        for turn, pair in enumerate(shared):
            both = (anew.get(cut.name, cut) for cut in (pair.first, pair.second))
            chosen.append((turn, name, CutPair(*both)))
    if not chosen:
        raise MeshFileError(f"{directory}: no two cuts of one class share {LEAST_SHARE} or more")
    return OverlapSet(
        title="Pairs of SHREC'16 cuts (CP2P)",
        data="SHREC'16 training set, cuts two and two; the method is not trained; errors of the "
        "truly shared vertices, in square roots of the whole's area",
        meshes="as stored" if remeshed is None else "remeshed",
        settings=settings or BenchmarkSettings(),
        pairs=tuple(pair for _, _, pair in sorted(chosen, key=lambda entry: entry[:2])),
    )


def _by_name(directory: Path, remeshed: Path) -> dict[str, PairFiles]:
    found = shrec16_pairs(directory, kind="cuts", remeshed=remeshed)
    return {files.name: files for files in found}


def _sharing(cuts: list[PairFiles]) -> list[tuple[PairFiles, PairFiles]]:
    """The pairs of cuts of one class whose regions on the whole overlap neither little nor much."""
    regions: dict[str, Bools] = {}
    for files in cuts:
        pair = files.load()
        regions[files.name] = true_region(pair.full, pair.part, pair.truth)
        areas = pair.full.vertex_areas
    found = []
    for first, second in combinations(cuts, 2):
        one, other = regions[first.name], regions[second.name]
        larger = max(areas[one].sum(), areas[other].sum())
        if LEAST_SHARE <= areas[one & other].sum() / larger <= MOST_SHARE:
            found.append((first, second))
    return found
