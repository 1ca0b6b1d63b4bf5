"""Puzzles without a whole: which pieces belong together, and where they lie on each other."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sherd.arrays import Floats
from sherd.benchmark.metrics import evenly_spread
from sherd.benchmark.puzzle.measurement import BAD
from sherd.benchmark.puzzle.sources import (
    CUTS,
    OVERLAP,
    OVERLAPPING_FOREIGN,
    Puzzle,
    PuzzleSource,
    puzzle_sources,
)
from sherd.benchmark.runner import measured_and_kept
from sherd.errors import OptionError
from sherd.join import join
from sherd.limits import require_finite, require_whole
from sherd.mesh.surface_points import SurfacePoints, closest_points
from sherd.puzzle.joint_choice import shared_areas
from sherd.results.puzzle.joined import Joined
from sherd.shapes.fragment import Fragment
from sherd.spectral.surface_distances import SurfaceDistances

__all__ = ["JoinRow", "join_benchmark", "join_table", "sources_of_joining"]

# How the puzzles of one shape are called, which are cut from elsewhere and in other poses.
TURNS = ("", "again", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth")
# Two pieces are neighbors if they share so much of the smaller one.
LEAST_SHARED = 0.01


@dataclass(frozen=True)
class JoinRow:
    """One puzzle without a whole.

    Attributes
    ----------
    puzzle
        Its name.
    own, together, foreign_alone
        How many pieces are of one thing, how many of these ended up in one group, and whether the
        group has no other piece.
    neighbors, joined, joined_right
        How many pairs truly share more than a hundredth of the smaller piece, how many pairs were
        joined, and how many of these are neighbors and laid on each other with an error below BAD.
    error
        Mean over all maps between own pieces, of vertices that are given a point: distance from
        the true one in sqrt(area) of the whole; None without maps.
    known
        Share of what two pieces share, by vertices, that is given a point; only of own pieces.
    cycle_before, cycle_after
        Of :class:`sherd.Joined`; None without loops.
    seconds
        Wall time.
    unplaced
        How many of those in the group belong to it without a place.
    """

    puzzle: str
    own: int
    together: int
    foreign_alone: bool
    neighbors: int
    joined: int
    joined_right: int
    error: float | None
    known: float
    cycle_before: float | None
    cycle_after: float | None
    seconds: float
    unplaced: int = 0

    @property
    def right(self) -> bool:
        """Whether the groups are as they should be."""
        return self.together == self.own and self.foreign_alone


def sources_of_joining(
    directory: Path, count: int, overlap: float = OVERLAP, cut: str = "cells", per_shape: int = 2
) -> list[PuzzleSource]:
    """Puzzles of each shape, each cut from elsewhere and in other poses; first one of each.

    For all overlaps cells and poses are the same.

    Raises
    ------
    MeshFileError
        See :func:`sherd.benchmark.puzzle.sources.puzzle_sources`.
    """
    shapes = {source.path: source for source in puzzle_sources(directory) if source.others}
    return [
        PuzzleSource(path, source.others, kind, count, overlap=overlap, cut=cut)
        for turn in TURNS[:per_shape]
        for kind in [f"{OVERLAPPING_FOREIGN}, {turn}" if turn else OVERLAPPING_FOREIGN]
        for path, source in sorted(shapes.items())
    ]


def join_benchmark(
    directory: Path,
    output: Path,
    *,
    count: int = 6,
    overlap: float = OVERLAP,
    cut: str = "cells",
    per_shape: int = 2,
    limit: int | None = None,
    jobs: int = 1,
) -> list[JoinRow]:
    """Join the pieces of animated shapes, which overlap, and one of another shape.

    Writes ``join.json`` after every puzzle, and goes on where an interrupted run stopped.

    Parameters
    ----------
    directory
        As in :func:`sherd.benchmark.puzzle.sources.puzzle_sources`; at least two shapes.
    output
        Folder.
    count
        Of pieces.
    overlap
        Share of its area that each piece reaches beyond its cell.
    cut
        Into "cells", or "balls" of one area.
    per_shape
        How many puzzles of each shape, ten at most.
    limit
        How many puzzles, of these the first; all if not given.
    jobs
        Processes.

    Raises
    ------
    MeshFileError
        If a file is missing or damaged.
    OptionError
        If a number is out of range.
    OutputError
        If the result cannot be written.
    """
    require_whole("pieces", count, 2, 12, "more pieces hardly overlap")
    require_finite("overlap", overlap, 0.01, 0.99, "pieces are joined where they overlap")
    require_whole("per shape", per_shape, 1, len(TURNS), "more cuts of a shape have no names")
    if limit is not None:
        require_whole("puzzles", limit, 1, 10**6, "no folder has more puzzles")
    if cut not in CUTS:
        raise OptionError(f"cut is {cut!r}, but {' or '.join(CUTS)} is needed")
    sources = sources_of_joining(directory, count, overlap, cut, per_shape)
    return measured_and_kept(
        sources[:limit],
        _measured,
        kind=JoinRow,
        name=lambda row: row.puzzle,
        path=output / "join.json",
        inputs=[path for each in sources for path in (each.path, *each.others)],
        jobs=jobs,
    )


def join_table(rows: Sequence[JoinRow]) -> str:
    """The rows and their means as text."""
    width = max([len(row.puzzle) for row in rows], default=6) + 2
    head = f"{'groups':>8}{'pairs':>14}{'error':>7}{'known':>7}{'loops':>14}{'s':>6}"
    lines = [f"{'puzzle':<{width}}{head}"]
    for row in rows:
        groups = "right" if row.right else f"{row.together} of {row.own}"
        unplaced = f"  {row.unplaced} without a place" if row.unplaced else ""
        loops = f"{_shown(row.cycle_before)} to {_shown(row.cycle_after)}"
        lines.append(
            f"{row.puzzle:<{width}}{groups:>8}{_pair_words([row]):>14}{_shown(row.error):>7}"
            f"{row.known:>7.2f}{loops:>14}{row.seconds:>6.0f}"
            + unplaced
            + ("" if row.foreign_alone else "  a foreign piece joined")
        )
    errors = [row.error for row in rows if row.error is not None]
    mean = _shown(float(np.mean(errors)) if errors else None)
    right = sum(row.right for row in rows)
    total = f"groups right in {right} of {len(rows)}, pairs joined {_pair_words(rows)}"
    lines.append(f"{total}, mean error {mean}")
    return "\n".join(lines)


def _pair_words(rows: Sequence[JoinRow]) -> str:
    """Of so many neighbors so many joined rightly, and how many pairs wrongly."""
    right, joined = sum(row.joined_right for row in rows), sum(row.joined for row in rows)
    return f"{right} of {sum(row.neighbors for row in rows)}, {joined - right} wrong"


def _shown(value: float | None) -> str:
    return "-" if value is None else f"{100 * value:.2f}"


def _measured(source: PuzzleSource) -> JoinRow:
    puzzle = source.load()
    start = time.perf_counter()
    answer = join([*(piece.mesh for piece in puzzle.own), *puzzle.foreign])
    seconds = time.perf_counter() - start
    own = set(range(len(puzzle.own)))
    most = max(answer.groups, key=lambda group: len(own & set(group)))
    errors, known = _errors(puzzle, answer)
    neighbors = _neighbors(puzzle)
    joined = [(pair.first, pair.second) for pair in answer.pairs if pair.joined]
    right = [
        (one, other)
        for one, other in joined
        if (one, other) in neighbors
        and all(errors[way].mean() < BAD for way in ((one, other), (other, one)) if way in errors)
    ]
    return JoinRow(
        puzzle=source.name,
        own=len(own),
        together=len(own & set(most)),
        foreign_alone=set(most) <= own,
        neighbors=len(neighbors),
        joined=len(joined),
        joined_right=len(right),
        error=float(np.concatenate([*errors.values()]).mean()) if errors else None,
        known=known,
        cycle_before=_number(answer.cycle_before),
        cycle_after=_number(answer.cycle_after),
        seconds=seconds,
        unplaced=len(set(most) & set(answer.unplaced)),
    )


def _neighbors(puzzle: Puzzle) -> set[tuple[int, int]]:
    """The pairs of own pieces that share something."""
    areas = puzzle.full.vertex_areas
    shared = shared_areas([piece.region for piece in puzzle.own], areas)
    own = np.diag(shared)
    first, second = np.nonzero(np.triu(shared > LEAST_SHARED * np.minimum.outer(own, own), 1))
    return set(zip(first.tolist(), second.tolist(), strict=True))


def _number(value: float) -> float | None:
    return None if np.isnan(value) else value


def _errors(puzzle: Puzzle, answer: Joined) -> tuple[dict[tuple[int, int], Floats], float]:
    """Errors of all vertices that are given a point by (here, there), where there are any.

    And the share of the shared vertices that are given one.
    """
    distances = SurfaceDistances(puzzle.full)
    found: dict[tuple[int, int], Floats] = {}
    given, shared = 0, 0
    for here, piece in enumerate(puzzle.own):
        for there, other in enumerate(puzzle.own):
            if here == there:
                continue
            both = other.region[piece.truth.nearest_vertices(puzzle.full)]
            shared += int(both.sum())
            place = answer.maps.get((here, there))
            if place is None:
                continue
            given += int((both & place.matched).sum())
            rows = np.flatnonzero(place.matched)
            rows = rows[evenly_spread(len(rows))]
            if len(rows):
                on_full = _on_full(puzzle, other, place.points[rows])
                found[here, there] = distances.between(piece.truth[rows], on_full)
    return found, given / max(shared, 1)


def _on_full(puzzle: Puzzle, piece: Fragment, points: SurfacePoints) -> SurfacePoints:
    """Where points of a piece lie on the whole."""
    places = piece.truth.positions(puzzle.full)
    corners = places[piece.mesh.faces[points.faces]]
    return closest_points(puzzle.full, np.einsum("pk,pkx->px", points.barycentric, corners))
