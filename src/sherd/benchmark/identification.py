"""Which of several full shapes? Every part among all of them, and among all but its own."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from sherd.benchmark.datasets.pairs import seed_of
from sherd.benchmark.datasets.shrec16 import PairFiles, shrec16_pairs
from sherd.benchmark.runner import measured_and_kept
from sherd.errors import InputError
from sherd.files.mesh_files import read_mesh
from sherd.library.candidate import Candidate
from sherd.library.folder import Library
from sherd.library.identify import candidates, identify_among
from sherd.limits import require_whole
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import Stages
from sherd.results.many.identify_options import IdentifyOptions
from sherd.scan.intake import mesh_intake
from sherd.shapes.rotation import rotated
from sherd.surface.template import Template

__all__ = [
    "IdentificationRow",
    "identification_benchmark",
    "identification_summary",
    "identification_table",
]

# In area, of parts that must be identified.
LEAST_SHARE = 0.1


@dataclass(frozen=True)
class IdentificationCase:
    """One part among all shapes of a library, or among all but its own."""

    files: PairFiles
    library: Path
    present: bool

    @property
    def name(self) -> str:
        """Of the part, and whether its own shape is among those asked."""
        return f"{self.files.name}{'' if self.present else ' without its own'}"


@dataclass(frozen=True)
class IdentificationRow:
    """What was said of one part.

    Attributes
    ----------
    case, own, present, share
        Its name, its full shape, whether that is among those asked, and its share of the area.
    rank
        Of its own shape by evidence, from 1; 0 where it is not among those asked.
    best, status
        What was answered; best is empty if it belongs to none.
    also
        Other shapes that it fits as well.
    evidence_seconds, seconds
        For all shapes, and in all; the library is open already.
    match_seconds
        Of one match, the mean of those that were made.
    """

    case: str
    own: str
    present: bool
    share: float
    rank: int
    best: str
    status: str
    also: list[str]
    evidence_seconds: float
    seconds: float
    match_seconds: float

    @property
    def right(self) -> bool:
        """Whether its own shape is the answer, or none where it is not among those asked."""
        return self.best == self.own if self.present else self.status != "GOOD"


def identification_benchmark(
    directory: Path,
    output: Path,
    *,
    also: Sequence[Path] = (),
    remeshed: Path | None = None,
    limit: int | None = None,
    jobs: int = 1,
) -> list[IdentificationRow]:
    """Identify every cut of a SHREC'16 folder, twice: with its own shape and without.

    All full shapes are brought to one area, and parts turned at random. Writes the library and
    ``identification.json``, and goes on where an interrupted run stopped.

    Parameters
    ----------
    directory, remeshed
        As of :func:`sherd.benchmark.datasets.shrec16.shrec16_pairs`.
    output
        Folder.
    also
        Files of further full shapes, which no part is of.
    limit, jobs
        So many parts only, drawn by their names; processes.

    Raises
    ------
    InputError
        If two full shapes have one name, or a file is missing or damaged.
    """
    if limit is not None:
        require_whole("limit", limit, 1, 10**6, "no data set has more parts")
    parts = shrec16_pairs(directory, kind="cuts", remeshed=remeshed)
    fulls = [*sorted({part.full for part in parts}), *also]
    if len({full.name for full in fulls}) < len(fulls):
        raise InputError("two full shapes have one name; rename a file")
    library = Library.open_or_new(output / "library")
    stages = Stages(len(fulls))
    for full in fulls:
        with stages(full.name):
            mesh = read_mesh(full)
            unit = TriangleMesh(mesh.vertices / mesh.length, mesh.faces, name=full.name)
            library = library.with_shape(Template(mesh_intake(unit)), overwrite=True)
    stages.close()
    chosen = sorted(parts, key=lambda part: seed_of(part.name, 0))[:limit]
    cases = [
        IdentificationCase(part, library.folder, present)
        for part in chosen
        for present in (True, False)
    ]
    return measured_and_kept(
        cases,
        _measured,
        kind=IdentificationRow,
        name=lambda row: row.case,
        path=output / "identification.json",
        inputs=[*fulls, *(path for part in parts for path in part.inputs)],
        settings={"remeshed": remeshed is not None},
        jobs=jobs,
    )


def identification_summary(rows: Sequence[IdentificationRow]) -> dict[str, Any]:
    """Shares of right answers, of own shapes first by evidence, and time in matches."""
    own = [row for row in rows if row.present and row.share >= LEAST_SHARE]
    without = [row for row in rows if not row.present]
    asked = [row for row in rows if row.match_seconds > 0]
    evidence = [row.evidence_seconds / row.match_seconds for row in asked]
    return {
        "parts": len(own),
        "right": _share([row.right for row in own]),
        "good": _share([row.status == "GOOD" for row in own]),
        "wrong_called_good": _share([row.status == "GOOD" and not row.right for row in own]),
        "first_by_evidence": _share([row.rank == 1 for row in own]),
        "second_or_first_by_evidence": _share([0 < row.rank <= 2 for row in own]),
        "without_own": len(without),
        "without_own_called_good": _share([row.status == "GOOD" for row in without]),
        "time_in_matches": _mean_time([row for row in asked if row.present]),
        "time_in_matches_without_own": _mean_time([row for row in asked if not row.present]),
        "evidence_in_matches": float(np.mean(evidence)) if evidence else None,
    }


def identification_table(rows: Sequence[IdentificationRow]) -> str:
    """The rows and the summary as text."""
    width = max([len(row.case) for row in rows], default=4) + 2
    lines = [f"{'case':<{width}}{'share':>6}{'rank':>6}{'seconds':>9}  answer"]
    for row in rows:
        mark = "" if row.right else "  WRONG"
        also = f", also {', '.join(row.also)}" if row.also else ""
        lines.append(
            f"{row.case:<{width}}{row.share:>6.2f}{row.rank:>6}{row.seconds:>9.1f}  "
            f"{row.best or 'none'}, {row.status.lower()}{also}{mark}"
        )
    for key, value in identification_summary(rows).items():
        shown = "-" if value is None else value if isinstance(value, int) else f"{value:.3f}"
        lines.append(f"{key.replace('_', ' ')}: {shown}")
    return "\n".join(lines)


def _mean_time(rows: Sequence[IdentificationRow]) -> float | None:
    return float(np.mean([row.seconds / row.match_seconds for row in rows])) if rows else None


def _share(said: Sequence[bool]) -> float | None:
    return float(np.mean(said)) if said else None


def _measured(case: IdentificationCase) -> IdentificationRow:
    known = [each for each in _known(case.library) if case.present or each.name != _own(case)]
    full = read_mesh(case.files.full)
    part = rotated(read_mesh(case.files.part), np.random.default_rng(seed_of(case.name, 0)))
    part = part.with_vertices(part.vertices / full.length)
    stages = Stages(visible=False)
    start = time.perf_counter()
    answer = identify_among(known, mesh_intake(part), IdentifyOptions(), stages)
    seconds = time.perf_counter() - start
    asked = sum(each.match is not None for each in answer.candidates)
    ratios = {each.name: each.ratio for each in answer.candidates}
    own = ratios.get(_own(case))
    return IdentificationRow(
        case=case.name,
        own=_own(case),
        present=case.present,
        share=part.area,
        rank=0 if own is None else 1 + sum(ratio < own for ratio in ratios.values()),
        best="" if answer.best is None else answer.best.name,
        status=answer.status.name,
        also=[each.name for each in answer.also],
        evidence_seconds=stages.seconds["evidence"],
        seconds=seconds,
        match_seconds=stages.seconds["matches"] / asked if asked else 0.0,
    )


def _own(case: IdentificationCase) -> str:
    return case.files.full.name


@lru_cache(maxsize=1)
def _known(library: Path) -> tuple[Candidate, ...]:
    return candidates(Library.open(library))
