"""`sherd landmarks`, and landmarks of files of 3D Slicer in `sherd transfer`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click
import numpy as np

from sherd.batching.specimens import ANY_TEMPLATE, carried_to_specimens
from sherd.cli.exits import NOT_CONVERGED
from sherd.cli.options import quiet_option
from sherd.cli.vertex_tables import text_table
from sherd.landmarks.attached import attached
from sherd.landmarks.carried import CarriedLandmarks, carry_landmarks, landmarks_of_part
from sherd.landmarks.landmark_files import landmark_text, read_landmarks
from sherd.landmarks.landmark_list import SPACES, Landmarks, Space
from sherd.landmarks.landmark_table import landmark_table
from sherd.output import require_writable, write_text
from sherd.results.fitted.fit_result import Fit
from sherd.results.match_result import MatchResult

__all__ = [
    "fitted_landmarks",
    "landmarks_by_template",
    "landmarks_command",
    "mesh_space_option",
    "transferred_landmarks",
]

FILE = click.Path(path_type=Path)

mesh_space_option = click.option(
    "--mesh-space",
    type=click.Choice(SPACES),
    help="Of landmarks: how the axes of the meshes' files run, if not as those of the landmarks.",
)


@click.command("landmarks")
@click.argument("folders", metavar="FOLDER...", type=FILE, nargs=-1, required=True)
@click.option(
    "--landmarks",
    "named",
    metavar="[FULL=]FILE",
    multiple=True,
    required=True,
    help="Landmarks of the template: .mrk.json, .fcsv or .csv. Of several templates once for each, "
    "with the name of its mesh.",
)
@click.option("-o", "--output", type=FILE, required=True, help="CSV file to write.")
@mesh_space_option
@quiet_option()
def landmarks_command(
    folders: tuple[Path, ...],
    named: tuple[str, ...],
    output: Path,
    *,
    mesh_space: Space | None,
    quiet: bool,
) -> int:
    """Carry a template's landmarks to all specimens that were matched with it, into one table.

    Each FOLDER is one of sherd match, the template as FULL and the specimen as PART. Where a
    specimen was matched with several templates, their median is taken, and the spread is given.
    The columns are specimen,landmark,x,y,z,confidence,status,spread,templates. The exit code is 4
    if a specimen is foreign or lacks all landmarks.

    \b
    Examples:
      sherd landmarks matches/* --landmarks template.mrk.json -o all.csv
      sherd landmarks */ --landmarks a.ply=a.csv --landmarks b.ply=b.csv -o x.csv
    """  # noqa: D301
    require_writable(output)
    lists = landmarks_by_template(named)
    answers = carried_to_specimens(folders, lists, mesh_space=mesh_space)
    write_text(output, landmark_table(answers))
    if not quiet:
        for each in answers:
            click.echo(_summary(each))
        click.echo(f"written: {output}")
    lost = [each for each in answers if not each.landmarks.known.any()]
    return NOT_CONVERGED if lost else 0


def transferred_landmarks(
    stored: MatchResult, values: Path, output: Path, *, to: str, mesh_space: Space | None
) -> str:
    """What `sherd transfer` writes for a file of landmarks."""
    landmarks = read_landmarks(values)
    if to == "part":
        carried = carry_landmarks(stored, landmarks, mesh_space=mesh_space)
        if output.suffix.lower() == ".csv":
            return landmark_table([carried])
        return landmark_text(carried.landmarks, output, notes=carried.notes)
    on_part = attached(landmarks, stored.part, mesh_space=mesh_space)
    return landmark_text(landmarks_of_part(stored, on_part), output)


def fitted_landmarks(fitted: Fit, values: Path, output: Path, *, mesh_space: Space | None) -> str:
    """What `sherd transfer` writes for a file of landmarks along a fit: none is missing."""
    placed = attached(read_landmarks(values), fitted.full, mesh_space=mesh_space)
    names, known = placed.landmarks.names, placed.landmarks.known
    positions = np.where(known[:, None], placed.points.positions(fitted.mesh), np.nan)
    _, extrapolated, chance = fitted.landmarks(placed.points.nearest_vertices(fitted.full))
    if output.suffix.lower() == ".csv":
        axes = {axis: positions[:, k] for k, axis in enumerate("xyz")}
        hidden = extrapolated.astype(np.int64)
        return text_table(
            {"name": np.array(names), **axes, "extrapolated": hidden, "chance": chance}
        )
    notes = [
        f"extrapolated, chance {sure:.2f}" if hidden else f"chance {sure:.2f}"
        for hidden, sure in zip(extrapolated.tolist(), chance.tolist(), strict=True)
    ]
    carried = Landmarks(names, positions, space=placed.landmarks.space)
    return landmark_text(carried, output, notes=notes)


def landmarks_by_template(named: Sequence[str]) -> dict[str, Landmarks]:
    """Landmarks by the name of the template, or of any one; each is FILE or FULL=FILE."""
    lists: dict[str, Landmarks] = {}
    for text in named:
        name, equals, path = text.partition("=")
        key, file = (name, path) if equals else (ANY_TEMPLATE, text)
        if key in lists:
            raise click.UsageError(
                f"--landmarks {text}: name each template once (--landmarks FULL=FILE)"
            )
        lists[key] = read_landmarks(file)
    if ANY_TEMPLATE in lists and len(lists) > 1:
        raise click.UsageError("of several templates, name each: --landmarks FULL=FILE")
    return lists


def _summary(carried: CarriedLandmarks) -> str:
    counts = {word: carried.status.count(word) for word in ("doubtful", "missing", "foreign")}
    said = "".join(f", {count} {word}" for word, count in counts.items() if count)
    return f"{carried.specimen}: {carried.status.count('good')} good{said}"
