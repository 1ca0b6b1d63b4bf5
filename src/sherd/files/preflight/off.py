"""OFF: counts against lines, columns against counts."""

from __future__ import annotations

import re

import numpy as np

from sherd.arrays import Ints
from sherd.errors import MeshFileError
from sherd.files.preflight.prepared import (
    Prepared,
    decoded,
    numbers,
    polygon_notices,
    refuse_foreign_characters,
    refuse_out_of_range,
)

__all__ = ["prepare"]


# [ST][C][N][4][n]OFF of the Geomview manual: texture, color, normal, four and n dimensions
_KEYWORD = re.compile(r"^(ST)?(C)?(N)?(4)?(n)?OFF(?![A-Za-z])")


def prepare(data: bytes) -> Prepared:
    """Check an OFF file and drop its comments and empty lines.

    Raises
    ------
    MeshFileError
        If the header is damaged or promises other elements than the file holds.
    """
    lines = [line.partition("#")[0].strip() for line in decoded(data).splitlines()]
    lines = [line for line in lines if line]
    vertex_count, face_count, body = _counts(lines)
    promised = f"the header promises {vertex_count} vertices and {face_count} faces"
    if vertex_count + face_count > len(body):
        raise MeshFileError(
            f"{promised}, but only {len(body)} lines follow; "
            "the file is truncated or its header is wrong: export or copy it again"
        )
    if vertex_count + face_count < len(body):
        raise MeshFileError(
            f"{promised}, but {len(body)} lines follow; the counts in the header are wrong: "
            "correct them or export the mesh again"
        )
    vertex_lines, face_lines = body[:vertex_count], body[vertex_count:]
    refuse_foreign_characters(vertex_lines, "vertex")
    _check_columns(vertex_lines, promised)
    flat, corners = _polygons(face_lines)
    refuse_out_of_range(flat, corners, vertex_count)
    kept = [line for line, count in zip(face_lines, corners.tolist(), strict=True) if count >= 3]
    text = "\n".join(["OFF", f"{vertex_count} {len(kept)} 0", *vertex_lines, *kept])
    triangles = int(np.maximum(corners - 2, 0).sum())
    return Prepared(f"{text}\n".encode(), vertex_count, triangles, polygon_notices(corners))


def _counts(lines: list[str]) -> tuple[int, int, list[str]]:
    if not lines:
        raise MeshFileError("holds no data; export the mesh again")
    found = _KEYWORD.match(lines[0])
    rest = lines
    if found:
        if found[4] or found[5]:
            raise MeshFileError(
                f"is {found[0]}, points of another dimension; export it in three dimensions"
            )
        after = lines[0][found.end() :].strip()
        if after.upper().startswith("BINARY"):
            raise MeshFileError("is a binary OFF file, which few programs read; export it as PLY")
        rest = [after, *lines[1:]] if after else lines[1:]
    elif not re.fullmatch(r"\d+\s+\d+(\s+\d+)?", lines[0]):
        raise MeshFileError(
            f"does not start with OFF but with {lines[0][:20]!r}; "
            "it is no OFF file: give it the suffix of its true format"
        )
    if not rest:
        raise MeshFileError("ends before the line with the counts; export the mesh again")
    words = rest[0].split()
    if len(words) < 2 or not all(re.fullmatch(r"\d{1,18}", word) for word in words[:2]):
        raise MeshFileError(
            f"the line after OFF reads {rest[0][:40]!r}, but the counts of vertices and faces "
            "belong there; export the mesh again"
        )
    return int(words[0]), int(words[1]), rest[1:]


def _check_columns(vertex_lines: list[str], promised: str) -> None:
    columns = np.fromiter((len(line.split()) for line in vertex_lines), np.int64)
    if not len(columns):
        return
    if columns[0] < 3:
        raise MeshFileError(
            f"vertex 0 reads {vertex_lines[0][:40]!r}, but three coordinates are needed"
        )
    uneven = columns != columns[0]
    if uneven.any():
        row = int(np.argmax(uneven))
        raise MeshFileError(
            f"{promised}, but vertex {row} has {columns[row]} columns where vertex 0 has "
            f"{columns[0]}: {vertex_lines[row][:40]!r}; the counts in the header are wrong or the "
            "line is damaged: export the mesh again"
        )


def _polygons(face_lines: list[str]) -> tuple[Ints, Ints]:
    """Vertex indices of all faces, flat, and the number of corners of each."""
    table = numbers(face_lines, "face")
    if len(table) == 4 * len(face_lines):
        rows = table.reshape(-1, 4)
        if (rows[:, 0] == 3).all() and (rows == np.rint(rows)).all():
            return rows[:, 1:].astype(np.int64).ravel(), np.full(len(rows), 3)
    flat: list[int] = []
    counts = np.empty(len(face_lines), dtype=np.int64)
    for index, line in enumerate(face_lines):
        words = line.split()
        counted = re.fullmatch(r"\d{1,18}", words[0])
        corners = words[1 : int(words[0]) + 1] if counted else []
        whole = all(re.fullmatch(r"[+-]?\d{1,18}", word) for word in corners)
        if not counted or len(corners) < int(words[0]) or not whole:
            raise MeshFileError(
                f"face {index} reads {line[:40]!r}, but a count and as many vertex indices are "
                "needed; the file is truncated or its header is wrong: export it again"
            )
        counts[index] = len(corners)
        flat.extend(map(int, corners))
    return np.array(flat, dtype=np.int64), counts
