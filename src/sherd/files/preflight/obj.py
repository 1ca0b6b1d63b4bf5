"""OBJ: only positions, colors and faces pass; every reference becomes a positive vertex index.

Texture coordinates, normals, groups and materials make trimesh renumber or repeat vertices,
and material files lie outside; none of them is needed here, so none is handed on.
"""

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
)

__all__ = ["prepare"]


_LARGEST_INDEX = 2.0**53  # beyond it float64 skips whole numbers


def prepare(data: bytes) -> Prepared:
    """Reduce an OBJ file to vertices (with colors if all have them) and faces.

    Raises
    ------
    MeshFileError
        If a vertex or a face cannot be read, or a face names a vertex that does not exist.
    """
    vertex_lines, face_lines, seen = _collected(decoded(data))
    refuse_foreign_characters(vertex_lines, "vertex")
    vertex_lines, notices = _even_columns(vertex_lines)
    corners = np.fromiter((len(line.split()) for line in face_lines), np.int64)
    notices += polygon_notices(corners)
    long_enough = corners >= 3
    face_lines = [line for line, keep in zip(face_lines, long_enough, strict=True) if keep]
    corners, seen = corners[long_enough], seen[long_enough]
    faces = _absolute(face_lines, corners, seen, len(vertex_lines))
    text = "\n".join([*(f"v {line}" for line in vertex_lines), *_face_lines(faces, corners)])
    return Prepared(
        f"{text}\n".encode(), len(vertex_lines), int((corners - 2).sum()), tuple(notices)
    )


def _collected(text: str) -> tuple[list[str], list[str], Ints]:
    """Vertex lines, face lines, and the number of vertices before each face."""
    vertices: list[str] = []
    faces: list[str] = []
    seen: list[int] = []
    for raw in text.replace("\\\r\n", " ").replace("\\\n", " ").splitlines():
        line = raw.strip()
        if line.startswith(("v ", "v\t")):
            vertices.append(line[2:].partition("#")[0].strip())
        elif line == "f" or line.startswith(("f ", "f\t")):
            # 7/3/9 -> 7: the vertex index alone
            faces.append(" ".join(re.sub(r"/\S*", "", line[2:].partition("#")[0]).split()))
            seen.append(len(vertices))
    return vertices, faces, np.array(seen, dtype=np.int64)


def _even_columns(lines: list[str]) -> tuple[list[str], list[str]]:
    columns = np.fromiter((len(line.split()) for line in lines), np.int64)
    if (columns < 3).any():
        row = int(np.argmax(columns < 3))
        raise MeshFileError(
            f"vertex {row} reads {lines[row][:40]!r}, but three coordinates are needed; "
            "the file is truncated or damaged: export it again"
        )
    if (columns == 6).all() or (columns == 3).all():
        return lines, []
    notices = []
    if (columns >= 6).any() and not (columns >= 6).all():
        notices.append("only some vertices have a color; the colors were left out")
    kept = 6 if (columns >= 6).all() else 3
    return [" ".join(line.split()[:kept]) for line in lines], notices


def _absolute(lines: list[str], corners: Ints, seen: Ints, vertex_count: int) -> Ints:
    """All references, flat and counted from 1."""
    exact = numbers(lines, "face")
    odd = ~((np.abs(exact) < _LARGEST_INDEX) & (exact == np.rint(exact)))
    if odd.any():
        row = int(np.searchsorted(np.cumsum(corners), int(np.argmax(odd)), side="right"))
        raise MeshFileError(
            f"face {row} reads {lines[row][:40]!r}, which are no vertex indices; "
            "export the mesh again"
        )
    flat = exact.astype(np.int64)
    rows = np.repeat(np.arange(len(lines)), corners)
    # OBJ counts from 1; a negative reference counts back from the last vertex before its line
    absolute = np.where(flat < 0, seen[rows] + 1 + flat, flat)
    bad = (absolute < 1) | (absolute > vertex_count)
    if bad.any():
        first = int(np.argmax(bad))
        raise MeshFileError(
            f"face {rows[first]} names vertex {flat[first]}, but there are {vertex_count} vertices "
            f"(1..{vertex_count}); the file is truncated or damaged: export it again"
        )
    return absolute


def _face_lines(faces: Ints, corners: Ints) -> list[str]:
    words = faces.astype(str).tolist()
    ends = np.cumsum(corners).tolist()
    starts = [0, *ends[:-1]]
    return ["f " + " ".join(words[a:b]) for a, b in zip(starts, ends, strict=False)]
