"""PLY: what the header promises against what the body holds, and polygons of mixed size.

trimesh reads binary faces only if all have the same number of corners, and finds faces under
two names only; both are set right here. Texture coordinates stay vertex fields.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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


_TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
    "int64": "i8",
    "uint64": "u8",
}
_FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_INDEX_NAMES = ("vertex_indices", "vertex_index")
_LONGEST_HEADER = 1 << 20


@dataclass(frozen=True)
class _Element:
    """One element of the header; a list property has the type of its count as third entry."""

    name: str
    count: int
    properties: tuple[tuple[str, str, str | None], ...]

    @property
    def lists(self) -> list[str]:
        return [name for name, _, count_type in self.properties if count_type]

    @property
    def least_bytes(self) -> int:
        """Size of a row whose lists are empty."""
        return sum(int((count or kind)[1]) for _, kind, count in self.properties)

    def header(self, *, count: int | None = None) -> str:
        """The lines that declare this element."""
        lines = [f"element {self.name} {self.count if count is None else count}"]
        names = {kind: name for name, kind in reversed(_TYPES.items())}
        for name, kind, count_type in self.properties:
            prefix = f"list {names[count_type]} " if count_type else ""
            lines.append(f"property {prefix}{names[kind]} {name}")
        return "\n".join(lines)


def prepare(data: bytes) -> Prepared:
    """Check a PLY file and hand over its vertices and faces alone, faces as triangles if mixed.

    Raises
    ------
    MeshFileError
        If the header is damaged or promises other elements than the file holds.
    """
    encoding, elements, body = _parsed_header(data)
    vertex = _only(elements, "vertex")
    if vertex.count == 0:
        raise MeshFileError("holds no vertices; export the mesh again")
    missing = [axis for axis in "xyz" if axis not in [entry[0] for entry in vertex.properties]]
    if missing or vertex.lists:
        raise MeshFileError(
            f"its vertices have no coordinate {missing[0]!r}; export the mesh again"
            if missing
            else f"its vertices hold the list {vertex.lists[0]!r}; export the mesh without it"
        )
    if not any(element.name == "face" and element.count for element in elements):
        strips = any(element.name == "tristrips" for element in elements)
        if strips:
            raise MeshFileError("holds triangle strips; export it with single triangles")
        _check_length(encoding, elements, body)
        return Prepared(b"", vertex.count, 0)
    face = _only(elements, "face")
    names = [name for name in _INDEX_NAMES if name in face.lists] or face.lists[:1]
    if not names:
        raise MeshFileError("its faces hold no list 'vertex_indices'; export the mesh again")
    if encoding == "ascii":
        return _prepared_text(body, elements, names[0])
    return _prepared_binary(body, elements, names[0], encoding)


def _parsed_header(data: bytes) -> tuple[str, list[_Element], bytes]:
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        data = decoded(data).encode()
    end = re.search(rb"(?:^|[\r\n])end_header[ \t]*(\r\n|\n|\r)?", data[:_LONGEST_HEADER])
    if not data.lstrip(b"\xef\xbb\xbf").startswith(b"ply") or end is None:
        raise MeshFileError(
            "has no PLY header from 'ply' to 'end_header'; it is truncated or no PLY file"
        )
    lines = [line.strip() for line in data[: end.start()].decode("latin-1").splitlines()]
    encoding = ""
    elements: list[_Element] = []
    for line in lines[1:]:
        words = line.split()
        if not words:
            continue
        if words[0] == "format" and len(words) >= 2:
            encoding = words[1]
        elif words[0] == "element" and len(words) == 3 and re.fullmatch(r"\d{1,18}", words[2]):
            elements.append(_Element(words[1], int(words[2]), ()))
        elif words[0] == "property" and elements:
            last = elements.pop()
            entry = _property(words, line)
            elements.append(_Element(last.name, last.count, (*last.properties, entry)))
        elif words[0] in ("format", "element", "property"):
            raise MeshFileError(f"its header holds {line[:60]!r}; export the mesh again")
    if encoding not in _FORMATS:
        raise MeshFileError(
            f"its header names the format {encoding!r}, but PLY knows {', '.join(_FORMATS)}"
        )
    return encoding, elements, data[end.end() :]


def _property(words: list[str], line: str) -> tuple[str, str, str | None]:
    is_list = len(words) == 5 and words[1] == "list"
    kinds = words[2:4] if is_list else words[1:2]
    if (len(words) != 3 and not is_list) or any(kind not in _TYPES for kind in kinds):
        raise MeshFileError(f"its header holds {line[:60]!r}; export the mesh again")
    if is_list and _TYPES[kinds[0]][0] == "f":
        raise MeshFileError(f"its header counts a list in fractions: {line[:60]!r}")
    return words[-1], _TYPES[kinds[-1]], _TYPES[kinds[0]] if is_list else None


def _only(elements: list[_Element], name: str) -> _Element:
    found = [element for element in elements if element.name == name]
    if len(found) != 1:
        raise MeshFileError(f"its header declares {len(found)} elements {name!r}; one is needed")
    names = [entry[0] for entry in found[0].properties]
    twice = next((entry for entry in names if names.count(entry) > 1), None)
    if twice is not None:
        raise MeshFileError(f"its header declares the property {twice!r} of {name!r} twice")
    return found[0]


def _truncated(elements: list[_Element], held: str) -> MeshFileError:
    promised = ", ".join(f"{element.count} {element.name}" for element in elements)
    return MeshFileError(
        f"its header promises {promised} rows, but the file holds {held}; "
        "it is truncated or its header is wrong: export or copy it again"
    )


def _text_lines(body: bytes, elements: list[_Element]) -> list[str]:
    lines = [line.strip() for line in decoded(body).splitlines() if line.strip()]
    if sum(element.count for element in elements) > len(lines):
        raise _truncated(elements, f"{len(lines)} lines")
    return lines


def _check_length(encoding: str, elements: list[_Element], body: bytes) -> None:
    """Refuse a file without room for what its header promises, lists taken as empty."""
    if encoding == "ascii":
        _text_lines(body, elements)
    elif sum(element.count * element.least_bytes for element in elements) > len(body):
        raise _truncated(elements, f"{len(body)} bytes")


def _prepared_text(body: bytes, elements: list[_Element], index_name: str) -> Prepared:
    lines = _text_lines(body, elements)
    start = 0
    for element in elements:
        rows = lines[start : start + element.count]
        start += element.count
        if element.name == "vertex":
            vertex, vertices = element, _packed_rows(rows, element)
        elif element.name == "face":
            polygons = _polygons(rows, element, index_name)
    return _assembled(vertex, vertices, polygons, "<")


def _packed_rows(rows: list[str], element: _Element) -> bytes:
    """Vertex rows of text as little-endian bytes."""
    refuse_foreign_characters(rows, element.name)
    width = len(element.properties)
    for index, row in enumerate(rows):
        if len(row.split()) != width:
            raise MeshFileError(
                f"{element.name} {index} has {len(row.split())} values, but the header declares "
                f"{width}; the file is truncated or its header is wrong: export it again"
            )
    table = numbers(rows, element.name).reshape(len(rows), width)
    packed = np.empty(len(rows), dtype=[(name, f"<{kind}") for name, kind, _ in element.properties])
    with np.errstate(all="ignore"):
        for column, (name, _, _) in enumerate(element.properties):
            packed[name] = table[:, column]
    return packed.tobytes()


def _polygons(rows: list[str], element: _Element, index_name: str) -> tuple[Ints, Ints]:
    """Vertex indices of all faces, flat, and the number of corners of each."""
    refuse_foreign_characters(rows, "face")
    widths = {len(row.split()) for row in rows}
    if len(element.properties) == 1 and len(widths) == 1:
        table = numbers(rows, "face").reshape(len(rows), -1).astype(np.int64)
        if (table[:, 0] == table.shape[1] - 1).all():
            return table[:, 1:].ravel(), table[:, 0]
    shapes = [_indices(row, index, element, index_name) for index, row in enumerate(rows)]
    corners = np.fromiter((len(shape) for shape in shapes), np.int64)
    return np.array([index for shape in shapes for index in shape], dtype=np.int64), corners


def _indices(row: str, index: int, element: _Element, index_name: str) -> list[int]:
    words = row.split()
    position = 0
    try:
        for name, _, count_type in element.properties:
            length = int(words[position]) if count_type else 1
            position += bool(count_type)
            if length < 0 or position + length > len(words):
                break
            if name == index_name:
                return [int(word) for word in words[position : position + length]]
            position += length
    except (ValueError, IndexError):
        pass
    raise MeshFileError(
        f"face {index} reads {row.strip()[:40]!r}, but a count and as many vertex indices are "
        "needed; the file is truncated or its header is wrong: export it again"
    )


def _prepared_binary(
    body: bytes, elements: list[_Element], index_name: str, encoding: str
) -> Prepared:
    _check_length(encoding, elements, body)
    order = _FORMATS[encoding]
    start = 0
    vertices = b""
    polygons = (np.empty(0, np.int64), np.empty(0, np.int64))
    for element in elements:
        if element.name == "face":
            polygons, start = _walked(body, start, element, index_name, order)
        elif element.lists:
            _, start = _walked(body, start, element, element.lists[0], order)
        else:
            size = element.count * element.least_bytes
            if element.name == "vertex":
                vertices, vertex = body[start : start + size], element
            start += size
        if start > len(body) or start < 0:
            raise _truncated(elements, f"{len(body)} bytes")
    extra = len(body) - start
    # a line end after binary data is harmless; more is a header that promises too little
    if extra > 2:
        raise MeshFileError(
            f"holds {extra} bytes more than its header promises; the counts in the header are "
            "wrong or the line ends were changed in copying: export or copy it again (as binary)"
        )
    return _assembled(vertex, vertices, polygons, order)


def _walked(
    body: bytes, start: int, element: _Element, index_name: str, order: str
) -> tuple[tuple[Ints, Ints], int]:
    """The list `index_name` of all rows (flat values, lengths), and where the element ends.

    The end is -1 if the body is too short.
    """
    uniform = _uniform(body, start, element, order)
    if uniform is not None:
        values = uniform[index_name].astype(np.int64).reshape(element.count, -1)
        lengths = np.full(element.count, values.shape[1])
        return (values.ravel(), lengths), start + uniform.nbytes
    pieces, lengths_found = [], []
    for _ in range(element.count):
        for name, kind, count_type in element.properties:
            length = 1
            if count_type:
                size = int(count_type[1])
                if start + size > len(body):
                    return (np.empty(0, np.int64), np.empty(0, np.int64)), -1
                length = int(np.frombuffer(body, order + count_type, 1, start)[0])
                start += size
            stop = start + length * int(kind[1])
            if length < 0 or stop > len(body):
                return (np.empty(0, np.int64), np.empty(0, np.int64)), -1
            if name == index_name:
                pieces.append(body[start:stop])
                lengths_found.append(length)
                index_kind = kind
            start = stop
    flat = np.frombuffer(b"".join(pieces), order + index_kind) if pieces else np.empty(0)
    return (flat.astype(np.int64), np.array(lengths_found, dtype=np.int64)), start


def _uniform(body: bytes, start: int, element: _Element, order: str) -> NDArray[np.void] | None:
    """The rows as one array if all lists are as long as in the first row, else None."""
    fields: list[tuple[str, str] | tuple[str, str, tuple[int]]] = []
    offset = start
    for name, kind, count_type in element.properties:
        length = 1
        if count_type:
            if offset + int(count_type[1]) > len(body):
                return None
            length = int(np.frombuffer(body, order + count_type, 1, offset)[0])
            offset += int(count_type[1])
            fields.append((f"count of {name}", order + count_type))
        if length < 0 or offset + length * int(kind[1]) > len(body):
            return None
        fields.append((name, order + kind, (length,)))
        offset += length * int(kind[1])
    dtype = np.dtype(fields)
    if element.count == 0 or start + element.count * dtype.itemsize > len(body):
        return None
    rows = np.frombuffer(body, dtype, element.count, start)
    for name in element.lists:
        if (rows[f"count of {name}"] != rows[f"count of {name}"][0]).any():
            return None
    return rows


def _assembled(
    vertex: _Element,
    vertices: bytes,
    polygons: tuple[Ints, Ints],
    order: str,
) -> Prepared:
    flat, corners = polygons
    refuse_out_of_range(flat, corners, vertex.count)
    triangles = _fans(flat, corners)
    notices = polygon_notices(corners)
    packed = np.empty(len(triangles), dtype=[("count", "u1"), ("index", f"{order}i4", (3,))])
    packed["count"], packed["index"] = 3, triangles
    name = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    header = (
        f"ply\nformat {name} 1.0\n{vertex.header()}\nelement face {len(triangles)}\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    data = header.encode("latin-1") + vertices + packed.tobytes()
    return Prepared(data, vertex.count, len(triangles), notices)


def _fans(flat: Ints, corners: Ints) -> Ints:
    """Polygons (flat indices, lengths) as triangles (m, 3) around their first corner, in order."""
    starts = np.cumsum(corners) - corners
    pieces = np.maximum(corners - 2, 0)
    owner = np.repeat(np.arange(len(corners)), pieces)
    step = np.arange(len(owner)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    first = starts[owner]
    return np.stack([flat[first], flat[first + step + 1], flat[first + step + 2]], axis=1)
