"""What goes to the `sherd` command and comes back: PLY and CSV files, without Blender.

Only the standard library is used, so this file can be tested, and runs, with any Python.
"""

from __future__ import annotations

import csv
import json
import struct
from array import array
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

__all__ = [
    "SCALES",
    "Answer",
    "color_by_vertex",
    "failure",
    "match_command",
    "read_answer",
    "write_ply",
]

Point = tuple[float, float, float]
Triangle = tuple[int, int, int]
Color = tuple[float, float, float, float]

SCALES = ("same", "unknown")
# Exit codes of sherd with which the answer is written: sure, and doubtful.
GOOD, DOUBTFUL = 0, 4
# Names of the numbers in a PLY header, and what struct calls them.
KINDS = {"double": "d", "float": "f", "uchar": "B", "int": "i"}


@dataclass(frozen=True)
class Answer:
    """What a match says, vertex by vertex.

    `confidence` and `matched` belong to the vertices of the part, `region` to those of the full
    shape; colors are RGBA in [0, 1] as a screen takes them (sRGB).
    """

    confidence: list[float]
    matched: list[bool]
    region: list[bool]
    full_colors: list[Color]
    part_colors: list[Color]
    advice: str
    doubtful: bool


def match_command(program: str, folder: Path, *, scale: str = "same") -> list[str]:
    """The words that start the match of `full.ply` and `part.ply` in a folder.

    Raises
    ------
    ValueError
        If no program is given or the scale is unknown.
    """
    if not program.strip():
        raise ValueError("say where the sherd command is, for example /home/me/venv/bin/sherd")
    if scale not in SCALES:
        raise ValueError(f"scale is {scale!r}, but must be one of {SCALES}")
    words = ["match", str(folder / "full.ply"), str(folder / "part.ply")]
    return [program.strip(), *words, "-o", str(folder / "out"), "--scale", scale, "--quiet"]


def failure(code: int, errors: str) -> str | None:
    """Why there is no answer, in one sentence; None if there is one."""
    if code in (GOOD, DOUBTFUL):
        return None
    lines = [line.strip() for line in errors.splitlines() if line.strip()]
    return lines[-1] if lines else f"sherd ended with exit code {code} and said nothing"


def write_ply(path: Path, vertices: Sequence[Point], triangles: Iterable[Triangle]) -> None:
    """A binary PLY file with double coordinates; vertices keep their numbers."""
    faces = list(triangles)
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(vertices)}\n"
        "property double x\nproperty double y\nproperty double z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    places = b"".join(struct.pack("<3d", *vertex) for vertex in vertices)
    corners = b"".join(struct.pack("<B3i", 3, *face) for face in faces)
    path.write_bytes(header.encode("ascii") + places + corners)


def read_answer(folder: Path) -> Answer:
    """What sherd wrote into a folder.

    Raises
    ------
    ValueError
        If a file is not what sherd writes.
    OSError
        If a file is missing.
    """
    document = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    rows = _table(folder / "correspondence.csv", ("part_vertex", "matched", "confidence"))
    places = _table(folder / "region.csv", ("full_vertex", "in_region"))
    confidence = _by_vertex(rows, "part_vertex", "confidence")
    matched = _by_vertex(rows, "part_vertex", "matched")
    region = _by_vertex(places, "full_vertex", "in_region")
    return Answer(
        confidence=confidence,
        matched=[value == 1 for value in matched],
        region=[value == 1 for value in region],
        full_colors=color_by_vertex(folder / "full.ply"),
        part_colors=color_by_vertex(folder / "part.ply"),
        advice=str(document.get("advice", "")),
        doubtful=document.get("status") != "good",
    )


def color_by_vertex(path: Path) -> list[Color]:
    """The colors of a binary PLY file whose vertices come first, as sherd writes it.

    Raises
    ------
    ValueError
        If the file is another one.
    """
    data = path.read_bytes()
    header, end, content = data.partition(b"end_header\n")
    lines = [line.split() for line in header.decode("ascii", "replace").splitlines()]
    if not end or ["format", "binary_little_endian", "1.0"] not in lines:
        raise ValueError(f"{path.name} is no binary PLY file of sherd")
    elements = [k for k, words in enumerate(lines) if words[:1] == ["element"]]
    first = lines[elements[0]]
    names = [words for words in lines[elements[0] : elements[1]] if words[0] == "property"]
    if first[1] != "vertex" or any(words[1] not in KINDS for words in names):
        raise ValueError(f"{path.name} has vertices of another kind than sherd writes")
    columns = [words[2] for words in names]
    if not {"red", "green", "blue"} <= set(columns):
        raise ValueError(f"{path.name} has no colors")
    row = struct.Struct("<" + "".join(KINDS[words[1]] for words in names))
    channels = [columns.index(name) for name in ("red", "green", "blue")]
    stored = memoryview(content)[: int(first[2]) * row.size]
    return [
        (*(values[channel] / 255 for channel in channels), 1.0)
        for values in row.iter_unpack(stored)
    ]


def flattened(rows: Iterable[Sequence[float]]) -> array[float]:
    """All numbers in one row, as Blender takes them."""
    return array("f", (value for row in rows for value in row))


def _table(path: Path, columns: Sequence[str]) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        reader = csv.DictReader(file)
        missing = set(columns) - set(reader.fieldnames or ())
        if missing:
            raise ValueError(f"{path.name} has no column {', '.join(sorted(missing))}")
        return list(reader)


def _by_vertex(rows: Sequence[dict[str, str]], key: str, column: str) -> list[float]:
    values = [float("nan")] * len(rows)
    for row in rows:
        values[int(row[key])] = float(row[column])
    return values
