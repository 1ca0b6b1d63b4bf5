"""STL: the count against the file's size, or the words of its text form."""

from __future__ import annotations

import re
import struct

from sherd.errors import MeshFileError
from sherd.files.preflight.prepared import Prepared, decoded, refuse_foreign_characters

__all__ = ["prepare"]

_HEADER = 84  # 80 bytes of anything and the number of triangles
_FACET = 50  # normal, three corners, two bytes of anything


def prepare(data: bytes) -> Prepared:
    """Check a binary or text STL file; several solids become one, in the order of the file.

    Raises
    ------
    MeshFileError
        If the file holds fewer triangles than it promises or a facet is damaged.
    """
    count = struct.unpack_from("<I", data, 80)[0] if len(data) >= _HEADER else 0
    if len(data) == _HEADER + count * _FACET and len(data) >= _HEADER:
        return Prepared(data, 3 * count, count)
    if b"\0" not in data or data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return _prepared_text(decoded(data))
    if len(data) < _HEADER:
        raise MeshFileError(
            f"has {len(data)} bytes, but the header of an STL file alone has {_HEADER}; "
            "the file is truncated: export or copy it again"
        )
    held = (len(data) - _HEADER) // _FACET
    if held < count:
        raise MeshFileError(
            f"the header promises {count} triangles, but the file has room for {held}; "
            "it is truncated or no STL file: export or copy it again"
        )
    end = _HEADER + count * _FACET
    notice = f"{len(data) - end} bytes after the last triangle were left out"
    return Prepared(data[:end], 3 * count, count, (notice,))


def _prepared_text(text: str) -> Prepared:
    lower = text.lower().lstrip("\ufeff \t\r\n")
    if not lower.startswith("solid"):
        raise MeshFileError("starts with neither 'solid' nor a binary header; it is no STL file")
    lines = [line.strip() for line in lower.splitlines()]
    corners = [line[7:] for line in lines if line.startswith(("vertex ", "vertex\t"))]
    opened = sum(line.startswith("facet") for line in lines)
    closed = len(re.findall(r"^endfacet", "\n".join(lines), flags=re.MULTILINE))
    if opened != closed or len(corners) != 3 * opened or "endsolid" not in lower:
        raise MeshFileError(
            f"has {opened} facets begun, {closed} ended and {len(corners)} vertices, and a whole "
            "file has three vertices a facet and ends with 'endsolid'; "
            "it is truncated: export or copy it again"
        )
    refuse_foreign_characters(corners, "vertex")
    for index, corner in enumerate(corners):
        if corner.count(".") > 3 or len(corner.split()) != 3:
            raise MeshFileError(
                f"vertex {index} reads {corner[:40]!r}, but three coordinates are needed; "
                "export the mesh again"
            )
    body = "\n".join(f"vertex {corner}" for corner in corners)
    return Prepared(f"solid\n{body}\nendsolid\n".encode(), len(corners), opened)
