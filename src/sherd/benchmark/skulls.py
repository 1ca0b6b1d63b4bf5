"""How near to hands are carried landmarks? Skulls of several strains, whole and cut in half."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np

from sherd.arrays import Bools, Floats
from sherd.benchmark.datasets.pairs import seed_of
from sherd.benchmark.runner import measured_and_kept
from sherd.errors import MeshFileError
from sherd.landmarks.attached import attached
from sherd.landmarks.carried import CarriedLandmarks, carry_landmarks
from sherd.landmarks.landmark_list import Landmarks
from sherd.landmarks.several import median_landmarks
from sherd.library.fitted_scale import match_with_fitted_scale
from sherd.limits import require_whole
from sherd.mesh.surface_points import closest_points
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes.rotation import rotated
from sherd.surface.template import Template

__all__ = [
    "SkullRow",
    "half_of_skull",
    "median_rows",
    "motion_of",
    "on_skull",
    "read_skull",
    "skull_benchmark",
    "skull_summary",
    "skull_table",
]

KINDS = ("whole", "half")
# In the unit of the files, mm: a landmark set by hand lies up to 0.2 off the surface, so a half
# that is nearer than this has it.
THERE = 0.3


@dataclass(frozen=True)
class SkullCase:
    """One specimen asked for the landmarks of one template."""

    template: Path
    specimen: Path
    kind: str

    @property
    def name(self) -> str:
        """All three."""
        return f"{self.specimen.stem} {self.kind} by {self.template.stem}"


@dataclass(frozen=True)
class SkullRow:
    """What came of one case.

    Attributes
    ----------
    case, template, specimen, kind
        Its name, and of what.
    status, chance, scale
        Of the match, at the size that fits.
    errors
        Distance of each landmark to where a hand set it, in the unit of the files; None where the
        specimen has none or none was given.
    positions, confidence
        Where each landmark was placed; None where none was given.
    false
        Landmarks that were given although the specimen does not have them.
    lost
        Landmarks that were not given although it has them.
    """

    case: str
    template: str
    specimen: str
    kind: str
    status: str
    chance: float | None
    scale: float
    errors: list[float | None]
    positions: list[list[float] | None]
    confidence: list[float | None]
    false: int
    lost: int

    @property
    def median(self) -> float:
        """Of the errors; NaN if there are none."""
        known = [error for error in self.errors if error is not None]
        return float(np.median(known)) if known else float("nan")


def skull_benchmark(
    directory: Path,
    output: Path,
    *,
    kinds: Sequence[str] = KINDS,
    limit: int | None = None,
    jobs: int = 1,
) -> list[SkullRow]:
    """Carry the landmarks of every skull to every other one, whole and cut in half at random.

    Specimens are turned at random. Writes ``skulls.json`` after every case, and goes on where an
    interrupted run stopped.

    Raises
    ------
    MeshFileError
        If the folder holds fewer than two files ``.npz`` with vertices, faces and landmarks.
    OptionError
        If `limit` or `jobs` is below 1.
    OutputError
        If the result cannot be written.
    """
    if limit is not None:
        require_whole("limit", limit, 1, 10**6, "no data set has more cases")
    files = sorted(directory.glob("*.npz"))
    if len(files) < 2:
        raise MeshFileError(f"{directory}: holds fewer than two skulls (.npz)")
    cases = [SkullCase(*pair, kind) for pair in permutations(files, 2) for kind in kinds]
    cases = sorted(cases, key=lambda case: seed_of(case.name, 0))[:limit]
    cases.sort(key=lambda case: case.template)  # each template is prepared once
    return measured_and_kept(
        cases,
        _measured,
        kind=SkullRow,
        name=lambda row: row.case,
        path=output / "skulls.json",
        inputs=files,
        jobs=jobs,
    )


def median_rows(rows: Iterable[SkullRow], directory: Path) -> list[SkullRow]:
    """For each specimen the row of the median over all templates that were asked."""
    groups: dict[tuple[str, str], list[SkullRow]] = {}
    for row in rows:
        groups.setdefault((row.specimen, row.kind), []).append(row)
    found = []
    for (specimen, kind), group in groups.items():
        _, truth = read_skull(directory / f"{specimen}.npz")
        middle = median_landmarks([_carried(row, truth) for row in group])
        found.append(
            _row(SkullCase(Path("median"), Path(specimen), kind), middle, truth, _there(group))
        )
    return found


def skull_summary(rows: Sequence[SkullRow]) -> dict[str, Any]:
    """By kind: median of all landmarks, the median of the cases' medians, and what went wrong."""
    summary = {}
    for kind in KINDS:
        own = [row for row in rows if row.kind == kind]
        errors = [error for row in own for error in row.errors if error is not None]
        if own:
            summary[kind] = {
                "cases": len(own),
                "landmarks": len(errors),
                "median": float(np.median(errors)) if errors else None,
                "ninth_tenth": float(np.quantile(errors, 0.9)) if errors else None,
                "worst_case": float(np.nanmax([row.median for row in own])),
                "good": sum(row.status == "GOOD" for row in own),
                "false": sum(row.false for row in own),
                "lost": sum(row.lost for row in own),
            }
    return summary


def skull_table(rows: Sequence[SkullRow], medians: Sequence[SkullRow]) -> str:
    """The rows and the summary as text, single templates and medians."""
    every = [*rows, *medians]
    width = max([len(row.case) for row in every], default=4) + 2
    lines = [f"{'case':<{width}}{'median':>8}{'lost':>6}{'false':>7}  status"]
    for row in every:
        chance = "" if row.chance is None else f", chance {row.chance:.2f}"
        lines.append(
            f"{row.case:<{width}}{row.median:>8.3f}{row.lost:>6}{row.false:>7}  "
            f"{row.status.lower()}{chance}"
        )
    for name, some in (("one template", rows), ("median of templates", medians)):
        for kind, found in skull_summary(some).items():
            numbers = ", ".join(f"{key.replace('_', ' ')} {_short(v)}" for key, v in found.items())
            lines.append(f"{name}, {kind}: {numbers}")
    return "\n".join(lines)


def _short(value: float | None) -> str:
    if value is None:
        return "-"
    return str(value) if isinstance(value, int) else f"{value:.3f}"


def _measured(case: SkullCase) -> SkullRow:
    template, landmarks = _template(case.template)
    mesh, truth = read_skull(case.specimen)
    rng = np.random.default_rng(seed_of(f"{case.specimen.stem} {case.kind}", 0))
    if case.kind == "half":
        mesh = half_of_skull(mesh, rng)
    result = match_with_fitted_scale(template, rotated(mesh, rng))
    turn, shift = motion_of(result.part.vertices, mesh.vertices)
    carried = carry_landmarks(result, attached(landmarks, template.full))
    moved = Landmarks(carried.landmarks.names, carried.landmarks.positions @ turn + shift)
    carried = CarriedLandmarks(
        carried.specimen, carried.templates, moved, carried.confidence, carried.status,
        carried.spread,
    )  # fmt: skip
    there = on_skull(mesh, truth.positions)
    return _row(
        case, carried, truth, there.tolist(), result.status.name, result.chance, result.scale
    )


def _row(
    case: SkullCase,
    carried: CarriedLandmarks,
    truth: Landmarks,
    there: Sequence[bool],
    status: str = "",
    chance: float | None = None,
    scale: float = 1.0,
) -> SkullRow:
    apart = np.linalg.norm(carried.landmarks.positions - truth.positions, axis=1)
    given = carried.landmarks.known
    has = np.array(there, dtype=bool)
    return SkullRow(
        case=case.name,
        template=case.template.stem,
        specimen=case.specimen.stem,
        kind=case.kind,
        status=status,
        chance=chance,
        scale=scale,
        errors=[float(a) if g and h else None for a, g, h in zip(apart, given, has, strict=True)],
        positions=[
            place if known else None
            for place, known in zip(carried.landmarks.positions.tolist(), given, strict=True)
        ],
        confidence=[None if np.isnan(c) else float(c) for c in carried.confidence],
        false=int((given & ~has).sum()),
        lost=int((has & ~given).sum()),
    )


def _there(group: Sequence[SkullRow]) -> list[bool]:
    """Which landmarks the specimen has, by what was measured of any template."""
    return [any(row.errors[k] is not None for row in group) for k in range(len(group[0].errors))]


def _carried(row: SkullRow, truth: Landmarks) -> CarriedLandmarks:
    nowhere = [float("nan")] * 3
    positions = np.array([nowhere if place is None else place for place in row.positions])
    return CarriedLandmarks(
        specimen=f"{row.specimen} {row.kind}",
        templates=(row.template,),
        landmarks=Landmarks(truth.names, positions),
        confidence=np.array([np.nan if c is None else c for c in row.confidence]),
        status=tuple("missing" if place is None else "good" for place in row.positions),
        spread=np.full(len(positions), np.nan),
    )


def on_skull(mesh: TriangleMesh, positions: Floats) -> Bools:
    """Which positions (p, 3) lie on a skull; a hand sets landmarks up to `THERE` off it."""
    feet = closest_points(mesh, positions).positions(mesh)
    near: Bools = np.linalg.norm(feet - positions, axis=1) < THERE
    return near


def half_of_skull(mesh: TriangleMesh, rng: np.random.Generator) -> TriangleMesh:
    """What lies on one side of a random plane through the middle of the surface."""
    height = mesh.vertices @ rng.normal(size=3)
    middle = float(np.average(height, weights=mesh.vertex_areas))
    half, _ = mesh.submesh(height[mesh.faces].mean(axis=1) > middle)
    return half


def motion_of(moved: Floats, original: Floats) -> tuple[Floats, Floats]:
    """Rotation and shift with `moved @ rotation + shift = original`, known to be a motion."""
    one, other = moved.mean(axis=0), original.mean(axis=0)
    left, _, right = np.linalg.svd((moved - one).T @ (original - other))
    return left @ right, other - one @ left @ right


@lru_cache(maxsize=1)
def _template(path: Path) -> tuple[Template, Landmarks]:
    mesh, landmarks = read_skull(path)
    template = Template(mesh)
    template.prepare()
    return template, landmarks


def read_skull(path: Path) -> tuple[TriangleMesh, Landmarks]:
    """A skull and its landmarks, in the unit of the file.

    Raises
    ------
    MeshFileError
        If the file cannot be read.
    """
    try:
        with np.load(path, allow_pickle=False) as stored:
            mesh = TriangleMesh(stored["vertices"], stored["faces"], name=path.stem)
            names = [f"L{k + 1}" for k in range(len(stored["landmarks"]))]
            return mesh, Landmarks(names, stored["landmarks"], source=path.stem)
    except (OSError, ValueError, KeyError) as error:
        raise MeshFileError(
            f"{path}: cannot be read as a skull with landmarks ({error})"
        ) from error
