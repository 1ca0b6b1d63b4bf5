"""The robustness benchmark: every file of a folder through commands, each in a process of its own.

What counts as a failure is fixed here: a traceback or an internal error, a hang, a crash, an exit
code that the command line does not document, an error of more than one line, and, in the output
folder, a half-written file, a number that is none, or anything at all after a refusal.
"""

from __future__ import annotations

import csv
import hashlib
import io
import json
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from sherd._version import __version__
from sherd.benchmark.row_file import stored_rows, write_rows
from sherd.errors import SherdError
from sherd.files.mesh_files import read_mesh
from sherd.limits import require_finite
from sherd.output import write_text
from sherd.report.stored.folder import folder_problems

__all__ = ["RobustnessRow", "check_command", "robustness", "robustness_commands"]

Command = Callable[[Path, Path], list[str]]
Verdict = Literal["done", "refused", "failed"]

# Exit codes of the command line: done, usable after repair, and ran without converging, ...
_DONE = (0, 1, 4)
# ... and refused, with one line that says why.
_REFUSED = 3
# "nan" as a whole word in a table or a JSON file; unknown is an empty cell or null there.
_NO_NUMBER = re.compile(r"(?<![\w.])-?(nan|inf|infinity)(?![\w.])", re.IGNORECASE)


@dataclass(frozen=True)
class RobustnessRow:
    """One command on one file.

    Parameters
    ----------
    file, command
        File relative to the folder, and the name of the command.
    verdict
        "done", "refused" (wrong input, said in one line), or "failed".
    failure
        What went wrong with sherd; empty unless failed.
    exit_code
        None after a hang.
    seconds
        Wall time.
    wrong
        What is wrong with the mesh, as the command printed it.
    said
        The last line of its error output.
    sha256
        Of the file's content.
    """

    file: str
    command: str
    verdict: Verdict
    failure: str
    exit_code: int | None
    seconds: float
    wrong: str
    said: str
    sha256: str


def check_command(mesh: Path, output: Path) -> list[str]:
    """Arguments of a process that checks `mesh` and writes it repaired into `output`."""
    repaired = str(output / "repaired.ply")
    return [sys.executable, "-m", "sherd", "check", str(mesh), "--repair", repaired]


def robustness_commands(full: Path, part: Path) -> dict[str, Command]:
    """Commands by name: check; locate and match with the file as the part, and as the full shape.

    Parameters
    ----------
    full, part
        Files of a good pair, the other half of each question.
    """
    commands: dict[str, Command] = {"check": check_command}
    sherd = [sys.executable, "-m", "sherd"]
    for name in ("locate", "match"):
        start = [*sherd, name, "-q"]

        def as_part(mesh: Path, out: Path, start: list[str] = start) -> list[str]:
            return [*start, str(full), str(mesh), "-o", str(out)]

        def as_full(mesh: Path, out: Path, start: list[str] = start) -> list[str]:
            return [*start, str(mesh), str(part), "-o", str(out)]

        commands[f"{name} as part"] = as_part
        commands[f"{name} as full shape"] = as_full
    return commands


def robustness(
    folder: Path,
    output: Path,
    *,
    commands: Mapping[str, Command] | None = None,
    seconds: float = 60.0,
    progress: Callable[[RobustnessRow], None] | None = None,
) -> list[RobustnessRow]:
    """Run every file of a folder through every command and write the table.

    Parameters
    ----------
    folder
        Searched with its subfolders, in order of names; tables (.csv, .json, .md) are skipped.
    output
        Where robustness.csv and robustness.json are written, anew after each file. An interrupted
        run goes on: what robustness.json holds for the same content, version and limit is taken
        over, unless it failed.
    commands
        By name, what to run for a mesh and an output folder; `check_command` if None.
    seconds
        Limit for one process.
    progress
        Told each row as it is found, not those that are taken over.

    Raises
    ------
    OptionError
        If the limit is not within a hundredth of a second and a day.
    OutputError
        If the table cannot be written.
    """
    require_finite("seconds", seconds, 0.01, 86_400, "a run that takes longer than a day hangs")
    jobs = {"check": check_command} if commands is None else dict(commands)
    settings = {"sherd": __version__, "seconds": seconds}
    known = _stored(output / "robustness.json", settings)
    rows: list[RobustnessRow] = []
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    for path in files:
        if path.suffix.lower() in (".csv", ".json", ".md"):
            continue
        shown, sha256 = str(path.relative_to(folder)), hashlib.sha256(path.read_bytes()).hexdigest()
        for name, command in jobs.items():
            row = known.get((shown, name, sha256))
            if row is None:
                row = _run(path, (shown, name, sha256), command, seconds=seconds)
                if progress is not None:
                    progress(row)
            rows.append(row)
        _write(rows, output, settings)
    return rows


def _run(
    path: Path, labels: tuple[str, str, str], command: Command, *, seconds: float
) -> RobustnessRow:
    shown, name, sha256 = labels
    with tempfile.TemporaryDirectory() as scratch:
        results = Path(scratch) / "out"
        start = time.perf_counter()
        try:
            done = subprocess.run(  # noqa: S603 - the caller's own commands, no shell
                command(path, results),
                capture_output=True,
                check=False,
                timeout=seconds,
                text=True,
                errors="replace",
                stdin=subprocess.DEVNULL,
            )
        except subprocess.TimeoutExpired:
            failure = f"no answer within {seconds:g} s"
            return RobustnessRow(shown, name, "failed", failure, None, seconds, "", "", sha256)
        elapsed = time.perf_counter() - start
        failure = _failure(done, results)
    refused = done.returncode == _REFUSED
    verdict: Verdict = "failed" if failure else "refused" if refused else "done"
    wrong = [
        line.strip()[len("wrong: ") :]
        for line in done.stdout.splitlines()
        if line.strip().startswith("wrong: ")
    ]
    lines = done.stderr.strip().splitlines()
    said = (lines[-1] if lines else "").replace(str(path), shown)
    code = done.returncode
    return RobustnessRow(
        shown, name, verdict, failure, code, elapsed, "; ".join(wrong), said, sha256
    )


def _failure(done: subprocess.CompletedProcess[str], results: Path) -> str:
    """What went wrong with the program itself; empty if nothing did."""
    if "Traceback (most recent call last)" in done.stderr + done.stdout:
        return "traceback"
    if done.returncode < 0:
        return f"killed by signal {-done.returncode}"
    if done.returncode not in (*_DONE, _REFUSED):
        return f"exit code {done.returncode}"
    left = sorted(path for path in results.rglob("*") if path.is_file())
    if done.returncode == _REFUSED:
        return _bad_refusal(done, left)
    damage = next((problem for path in left if (problem := _damage(path))), "")
    if damage or len(left) <= 1:  # a single file needs no result.json that vouches for it
        return damage
    return next(iter(folder_problems(results)), "")


def _bad_refusal(done: subprocess.CompletedProcess[str], left: list[Path]) -> str:
    """What is wrong with the way in which input was refused."""
    if left:
        return f"refused, but left {left[0].name}"
    if not (done.stderr.strip() or done.stdout.strip()):
        return "refused without a word"
    if len(done.stderr.strip().splitlines()) > 1:
        return "refused in more than one line"
    return ""


def _damage(path: Path) -> str:
    if ".partial" in path.name:
        return f"left the half-written {path.name}"
    if path.suffix in (".csv", ".json"):
        text = path.read_text(encoding="utf-8", errors="replace")
        found = _NO_NUMBER.search(text)
        if found:
            return f"{path.name} holds {found[0]!r}"
        if path.suffix == ".json":
            try:
                json.loads(text)
            except ValueError as error:
                return f"{path.name} is no JSON: {error}"
    if path.suffix == ".ply":
        try:
            read_mesh(path)  # which refuses coordinates that are not finite
        except SherdError as error:
            return f"{path.name} cannot be read back: {error}"
    return ""


def _stored(path: Path, settings: dict[str, Any]) -> dict[tuple[str, str, str], RobustnessRow]:
    """Rows without failure of an earlier run with the same settings, by what they are about."""
    rows = stored_rows(path, settings, RobustnessRow)
    return {(row.file, row.command, row.sha256): row for row in rows if row.verdict != "failed"}


def _write(rows: list[RobustnessRow], output: Path, settings: dict[str, Any]) -> None:
    table = [asdict(row) for row in rows]
    stream = io.StringIO()
    writer = csv.DictWriter(stream, list(table[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows({**row, "seconds": f"{row['seconds']:.2f}"} for row in table)
    write_text(output / "robustness.csv", stream.getvalue())
    total = {
        verdict: sum(row.verdict == verdict for row in rows)
        for verdict in ("done", "refused", "failed")
    }
    write_rows(output / "robustness.json", {**settings, "total": total}, rows)
