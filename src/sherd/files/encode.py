"""A mesh as the bytes of a file: OFF, OBJ, PLY, STL and GLB."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sherd.arrays import Bytes, Floats
from sherd.errors import InvalidMeshError, OptionError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.mesh.validate import checked_field

__all__ = ["encoded"]


_SUFFIXES = (".off", ".obj", ".ply", ".stl", ".glb")
_COLORED = (".ply", ".obj", ".glb")
# Names with a meaning of their own in PLY; a field so named would be read as something else.
_RESERVED = ("x", "y", "z", "nx", "ny", "nz", "red", "green", "blue", "alpha")
_LARGEST_SINGLE = float(np.finfo(np.float32).max)


def encoded(
    mesh: TriangleMesh,
    suffix: str,
    *,
    fields: Mapping[str, ArrayLike] | None = None,
    colors: ArrayLike | None = None,
) -> bytes:
    """The content of a file with this suffix; see :func:`sherd.files.mesh_files.write_mesh`."""
    if suffix not in _SUFFIXES:
        raise OptionError(f"suffix {suffix!r} is unknown; sherd writes {', '.join(_SUFFIXES)}")
    if fields is not None and suffix != ".ply":
        raise OptionError(f"{suffix} files have no room for vertex fields; write a .ply file")
    if colors is not None and suffix not in _COLORED:
        raise OptionError(f"{suffix} files have no room for colors; write a .ply file")
    stored = mesh.fields if fields is None else fields
    rest = {name: values for name, values in stored.items() if name != "color"}
    chosen = _as_bytes(stored.get("color") if colors is None else colors, mesh.vertex_count)
    if suffix == ".ply":
        return _ply(mesh, _columns(rest, mesh.vertex_count), chosen)
    if suffix == ".off":
        head = [f"OFF\n{mesh.vertex_count} {mesh.face_count} 0"]
        return _text([*head, *_rows("{} {} {}", mesh.vertices), *_rows("3 {} {} {}", mesh.faces)])
    if suffix == ".obj":
        table: NDArray[Any] = mesh.vertices
        pattern = "v {} {} {}"
        if chosen is not None:
            table, pattern = np.hstack([table, chosen / 255.0]), "v {} {} {} {} {} {}"
        return _text([*_rows(pattern, table), *_rows("f {} {} {}", mesh.faces + 1)])
    return _through_trimesh(mesh, suffix, chosen)


def _as_bytes(colors: ArrayLike | None, vertex_count: int) -> Bytes | None:
    if colors is None:
        return None
    array = np.asarray(colors)
    if array.shape != (vertex_count, 3):
        raise InvalidMeshError(f"colors has shape {array.shape}, but {(vertex_count, 3)} is needed")
    if array.dtype == np.uint8:
        return array
    # unknown (NaN) is shown in the middle gray that no color map has at its ends
    scaled = np.nan_to_num(array.astype(np.float64), nan=0.5, posinf=1.0, neginf=0.0)
    return np.rint(np.clip(scaled, 0.0, 1.0) * 255).astype(np.uint8)


def _columns(fields: Mapping[str, ArrayLike], vertex_count: int) -> dict[str, Floats]:
    """Fields with one column each, checked for names that PLY cannot hold."""
    columns: dict[str, Floats] = {}
    for name, given in fields.items():
        values = checked_field(name, given, vertex_count)
        if values.ndim == 1:
            columns[name] = values
        else:
            columns |= {f"{name}_{j}": values[:, j] for j in range(values.shape[1])}
    for name in columns:
        if name in _RESERVED or not re.fullmatch(r"[!-~]+", name):
            raise OptionError(
                f"field name {name!r} cannot stand in a PLY file; rename it (letters, digits "
                f"and signs without spaces, none of {', '.join(_RESERVED)})"
            )
    return columns


def _ply(mesh: TriangleMesh, columns: Mapping[str, Floats], colors: Bytes | None) -> bytes:
    layout = [(axis, "<f8") for axis in "xyz"]
    layout += [(channel, "u1") for channel in ("red", "green", "blue") if colors is not None]
    layout += [(name, "<f8") for name in columns]
    vertices = np.empty(mesh.vertex_count, dtype=layout)
    for axis, name in enumerate("xyz"):
        vertices[name] = mesh.vertices[:, axis]
    if colors is not None:
        for axis, name in enumerate(("red", "green", "blue")):
            vertices[name] = colors[:, axis]
    for name, values in columns.items():
        vertices[name] = values
    faces = np.empty(mesh.face_count, dtype=[("count", "u1"), ("index", "<i4", (3,))])
    faces["count"], faces["index"] = 3, mesh.faces
    kinds = {"<f8": "double", "u1": "uchar"}
    lines = ["ply", "format binary_little_endian 1.0", "comment written by sherd"]
    lines += [f"element vertex {mesh.vertex_count}"]
    lines += [f"property {kinds[kind]} {name}" for name, kind in layout]
    lines += [f"element face {mesh.face_count}", "property list uchar int vertex_indices"]
    return _text([*lines, "end_header"]) + vertices.tobytes() + faces.tobytes()


def _rows(pattern: str, table: NDArray[Any]) -> list[str]:
    """Rows as text; Python writes the shortest digits that read back to the same number."""
    return [pattern.format(*row) for row in table.tolist()]


def _text(lines: list[str]) -> bytes:
    return ("\n".join(lines) + "\n").encode("ascii")


def _through_trimesh(mesh: TriangleMesh, suffix: str, colors: Bytes | None) -> bytes:
    import trimesh  # noqa: PLC0415 - takes .2 s, and `import sherd` must stay light

    if np.abs(mesh.vertices).max() > _LARGEST_SINGLE:
        raise OptionError(f"coordinates are too large for {suffix} files; write a .ply file")
    with np.errstate(all="ignore"):
        shape = trimesh.Trimesh(
            mesh.vertices, mesh.faces, vertex_colors=colors, process=False, validate=False
        )
        content: Any = shape.export(file_type=suffix[1:])
    return bytes(content)
