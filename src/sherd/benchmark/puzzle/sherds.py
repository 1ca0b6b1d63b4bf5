"""Rigid puzzles: sherds of generated vases, some missing, beside those of another vase."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from sherd.arrays import Floats
from sherd.assemble import assemble
from sherd.benchmark.runner import measured_and_kept
from sherd.errors import OptionError
from sherd.limits import require_whole
from sherd.shapes.vase import Sherd, vase, vase_sherds

__all__ = ["KINDS", "SherdRow", "sherd_benchmark", "sherd_table"]

# A vase breaks into so many sherds if its kind says nothing else, of which some are given, and some
# of another vase, which has the same profile and another relief: places of the missing ones are
# free for these.
BROKEN, GIVEN, FOREIGN = 7, 4, 3
# How a kind differs from the defaults of `vase` and `vase_sherds`. Lengths in sqrt(area): the noise
# is a millimeter on a vase of half a meter and more than a scanner's; edges worn round at 0.015 are
# half as round as the wall is thick. Small sherds have a twentieth of the area each, and no
# neighborhood without a face of fracture.
KINDS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "clean": {},
        "shallow": {"relief": 0.003},
        "noisy": {"noise": 0.0005},
        "worn": {"worn": 0.015},
        "coarse": {"vertex_count": 8000},
        "small": {"count": 24},
    }
)
# A sherd that is farther off on average lies elsewhere, in sqrt(area).
BAD = 0.02
# Seeds of vases that lend foreign sherds.
OTHERS = 1000


@dataclass(frozen=True)
class SherdRow:
    """One vase.

    Attributes
    ----------
    puzzle
        Its name.
    own, placed, wrong
        How many of its sherds are given, how many are placed where they belong, and how many
        elsewhere.
    foreign, foreign_placed
        How many of another vase are given, and how many are placed.
    errors
        Of those that are placed rightly how far their vertices are off on average, in sqrt(area).
    angles
        By how many degrees they are turned from their true pose.
    seconds
        Wall time.
    """

    puzzle: str
    own: int
    placed: int
    wrong: int
    foreign: int
    foreign_placed: int
    errors: list[float]
    angles: list[float]
    seconds: float


@dataclass(frozen=True)
class _Broken:
    kind: str
    seed: int

    @property
    def name(self) -> str:
        return f"{self.kind} {self.seed}"


def sherd_benchmark(
    output: Path, *, kinds: Sequence[str] = (), vases: int = 3, jobs: int = 1
) -> list[SherdRow]:
    """Put sherds of generated vases on the whole ones, with those of other vases.

    Writes ``sherds.json`` after every vase, and goes on where an interrupted run stopped.

    Parameters
    ----------
    output
        Folder.
    kinds
        Names in :data:`KINDS`; all if none.
    vases
        Of each kind, each with a relief of its own.
    jobs
        Processes.

    Raises
    ------
    OptionError
        If a number is out of range, or a kind is unknown.
    OutputError
        If the result cannot be written.
    """
    require_whole("vases", vases, 1, OTHERS, "the others lend foreign sherds")
    unknown = sorted(set(kinds) - set(KINDS))
    if unknown:
        raise OptionError(f"kind is {unknown[0]!r}, but one of {', '.join(KINDS)} is needed")
    return measured_and_kept(
        [_Broken(kind, seed) for kind in kinds or KINDS for seed in range(vases)],
        _measured,
        kind=SherdRow,
        name=lambda row: row.puzzle,
        path=output / "sherds.json",
        inputs=[],
        jobs=jobs,
    )


def sherd_table(rows: Sequence[SherdRow]) -> str:
    """The rows and the totals of each kind as text."""
    lines = [
        f"{'vase':<12}{'placed':>8}{'wrong':>7}{'foreign placed':>16}{'error x100':>12}{'s':>6}"
    ]
    lines += [_line(row.puzzle, [row]) for row in rows]
    kinds = list(dict.fromkeys(row.puzzle.split()[0] for row in rows))
    lines += [_line(kind, [row for row in rows if row.puzzle.split()[0] == kind]) for kind in kinds]
    angles = [angle for row in rows for angle in row.angles]
    if angles:
        lines.append(
            f"degrees off: median {np.median(angles):.3f}, ninth tenth "
            f"{np.quantile(angles, 0.9):.3f}, most {max(angles):.3f}"
        )
    return "\n".join(lines)


def _line(name: str, rows: Sequence[SherdRow]) -> str:
    def total(field: str) -> int:
        return sum(getattr(row, field) for row in rows)

    errors = [error for row in rows for error in row.errors]
    error = f"{100 * np.mean(errors):.3f}" if errors else "-"
    placed = f"{total('placed')}/{total('own')}"
    foreign = f"{total('foreign_placed')}/{total('foreign')}"
    seconds = sum(row.seconds for row in rows)
    return f"{name:<12}{placed:>8}{total('wrong'):>7}{foreign:>16}{error:>12}{seconds:>6.0f}"


def _measured(broken: _Broken) -> SherdRow:
    settings: dict[str, Any] = {"count": BROKEN, **KINDS[broken.kind]}
    shape = {key: settings[key] for key in ("vertex_count", "relief") if key in settings}
    full = vase(seed=broken.seed, **shape)
    own = vase_sherds(seed=broken.seed, **settings)[:GIVEN]
    foreign = vase_sherds(seed=OTHERS + broken.seed, **settings)[:FOREIGN]
    start = time.perf_counter()
    answer = assemble(full, [each.mesh for each in (*own, *foreign)], rigid=True)
    seconds = time.perf_counter() - start
    found = [piece.transform if piece.placed else None for piece in answer.pieces]
    off = [
        _off(each, transform, full.length)
        for each, transform in zip(own, found, strict=False)
        if transform is not None
    ]
    right = [each for each in off if each[0] < BAD]
    return SherdRow(
        puzzle=broken.name,
        own=len(own),
        placed=len(right),
        wrong=len(off) - len(right),
        foreign=len(foreign),
        foreign_placed=sum(transform is not None for transform in found[len(own) :]),
        errors=[error for error, _ in right],
        angles=[angle for _, angle in right],
        seconds=seconds,
    )


def _off(sherd: Sherd, transform: Floats, unit: float) -> tuple[float, float]:
    """How far vertices are off on average, in the unit, and by how many degrees all are turned."""
    points = np.column_stack([sherd.mesh.vertices, np.ones(sherd.mesh.vertex_count)])
    apart = points @ (transform - sherd.transform)[:3].T
    turn = transform[:3, :3] @ sherd.transform[:3, :3].T
    angle = np.arccos(np.clip(0.5 * (np.trace(turn) - 1.0), -1.0, 1.0))
    return float(np.linalg.norm(apart, axis=1).mean()) / unit, float(np.degrees(angle))
