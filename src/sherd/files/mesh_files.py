"""Read and write OFF, OBJ, PLY, STL and GLB files; vertices keep the file's numbering.

The numbers are read by trimesh; :mod:`sherd.files.preflight` first compares what a file promises
with what it holds. No other file is opened, nothing is unpickled, the network is not asked.
"""

from __future__ import annotations

import io
import logging
import os
import stat
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from sherd.arrays import Floats
from sherd.errors import InputError, InvalidMeshError, MeshFileError
from sherd.files import encode
from sherd.files.preflight import glb, obj, off, ply, stl
from sherd.files.preflight.prepared import Prepared
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import write_bytes

__all__ = [
    "FORMATS",
    "file_content",
    "read_content",
    "read_mesh",
    "read_mesh_with_notices",
    "write_mesh",
]

logger = logging.getLogger(__name__)
logging.getLogger("trimesh").addHandler(logging.NullHandler())  # its warnings become our errors

FORMATS: dict[str, Callable[[bytes], Prepared]] = {
    ".off": off.prepare,
    ".obj": obj.prepare,
    ".ply": ply.prepare,
    ".stl": stl.prepare,
    ".glb": glb.prepare,
}
_PACKED = (".gz", ".zip", ".bz2", ".xz", ".7z", ".zst")
_COLORS = ("red", "green", "blue")
_DERIVED = {"x", "y", "z", "nx", "ny", "nz", *_COLORS}


def read_mesh(path: str | os.PathLike[str]) -> TriangleMesh:
    """Read a triangle mesh whose vertices are numbered as in the file.

    Polygons are cut into triangles. STL stores three vertices per triangle and they stay three;
    :func:`sherd.repair.repair.repair` welds them. Vertex properties of PLY become `fields`, and
    vertex colors the field ``color``, (n, 3) in [0, 1]. What was adapted is logged at INFO;
    :func:`read_mesh_with_notices` returns it.

    Parameters
    ----------
    path
        An .off, .obj, .ply, .stl or .glb file.

    Raises
    ------
    MeshFileError
        If the file is missing, unreadable, empty, truncated, of an unknown format, or promises
        more than it holds.
    InvalidMeshError
        If it holds no faces, only faces without area, or coordinates that are not finite.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     triangle = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    ...     write_mesh(triangle, f"{folder}/triangle.ply")
    ...     read_mesh(f"{folder}/triangle.ply")
    TriangleMesh('triangle.ply', 3 vertices, 1 faces)
    """
    mesh, notices = read_mesh_with_notices(path)
    for notice in notices:
        logger.info("%s: %s", path, notice)
    return mesh


def read_mesh_with_notices(
    path: str | os.PathLike[str],
) -> tuple[TriangleMesh, tuple[str, ...]]:
    """Read as :func:`read_mesh` does, and return beside the mesh what was adapted, in words."""
    source = Path(path)
    try:
        _, prepared = read_content(source)
        if prepared.face_count == 0:
            raise InvalidMeshError(_without_faces(prepared.vertex_count))
        loaded = _loaded(prepared, source.suffix.lower())
        mesh = TriangleMesh(loaded.vertices, loaded.faces, fields=_fields(loaded), name=source.name)
        if not mesh.area > 0:
            raise InvalidMeshError(
                f"all {mesh.face_count} faces have no area; their corners coincide or lie on "
                "lines: export the mesh again"
            )
    except InputError as error:
        raise type(error)(f"{source}: {error}") from error.__cause__
    return mesh, prepared.notices


def read_content(path: Path) -> tuple[bytes, Prepared]:
    """The bytes of a mesh file, and the same made harmless, with what must be found in them.

    Raises
    ------
    MeshFileError, InvalidMeshError
        As :func:`read_mesh` does; the message does not name the file.
    """
    prepare = _format_of(path)
    data = file_content(path)
    with np.errstate(all="ignore"):  # odd numbers are refused by name, not warned about
        return data, prepare(data)


def write_mesh(
    mesh: TriangleMesh,
    path: str | os.PathLike[str],
    *,
    fields: Mapping[str, ArrayLike] | None = None,
    colors: ArrayLike | None = None,
) -> None:
    """Write a mesh atomically in the format of the suffix; the order of vertices is kept.

    PLY (binary, double precision) and text formats keep coordinates exactly; STL and GLB store
    single precision, and STL three vertices per triangle.

    Parameters
    ----------
    mesh
        What to write.
    path
        An .off, .obj, .ply, .stl or .glb file.
    fields
        Values per vertex by name, (n,) or (n, c), for PLY only; None takes `mesh.fields` where the
        format has room for them. Column j of a field with c columns is named ``name_j``.
    colors
        (n, 3) per vertex, float in [0, 1] or uint8, for PLY, OBJ and GLB; None takes the field
        ``color`` if there is one.

    Raises
    ------
    OptionError
        If the suffix is unknown, the format has no room for what was given, or a field has a
        name that PLY cannot hold.
    InvalidMeshError
        If `fields` or `colors` do not fit the mesh.
    OutputError
        If the file cannot be written; what stood there before is untouched.

    Examples
    --------
    >>> triangle = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> write_mesh(triangle, "triangle.doc")
    Traceback (most recent call last):
        ...
    sherd.errors.OptionError: suffix '.doc' is unknown; sherd writes .off, .obj, .ply, .stl, .glb
    """
    suffix = Path(path).suffix.lower()
    write_bytes(path, encode.encoded(mesh, suffix, fields=fields, colors=colors))


def _without_faces(vertex_count: int | None) -> str:
    if not vertex_count:
        return "holds no faces; export the mesh again"
    return (
        f"holds {vertex_count} points and no faces; export it with faces, or give it as the part, "
        "which may be points only (.xyz, .ply, .obj or .off; in Python: "
        "sherd.surface_from_points(sherd.read_scan(path)))"
    )


def _format_of(path: Path) -> Callable[[bytes], Prepared]:
    suffix = path.suffix.lower()
    if suffix in FORMATS:
        return FORMATS[suffix]
    known = ", ".join(FORMATS)
    if suffix in _PACKED:
        raise MeshFileError(f"is packed; unpack it first (sherd reads {known})")
    if not path.exists():
        raise MeshFileError("no such file; check the path")
    if path.is_dir():
        raise MeshFileError(f"is a folder; name a mesh file in it ({known})")
    raise MeshFileError(f"has the unknown suffix {suffix!r}; sherd reads {known}: convert it")


def file_content(path: Path) -> bytes:
    """The bytes of an ordinary file that is not empty; MeshFileError says why not."""
    try:
        mode = path.stat().st_mode
        if stat.S_ISDIR(mode):
            raise MeshFileError(f"is a folder; name a mesh file in it ({', '.join(FORMATS)})")
        if not stat.S_ISREG(mode):
            raise MeshFileError("is no ordinary file; save the mesh to a file first")
        data = path.read_bytes()
    except FileNotFoundError as error:
        raise MeshFileError("no such file; check the path") from error
    except PermissionError as error:
        raise MeshFileError("may not be read; change its permissions") from error
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise MeshFileError(f"cannot be read ({reason}); check the path and the disk") from error
    if not data.strip(b" \t\r\n\0"):
        raise MeshFileError("is empty; export or copy it again")
    return data


def _loaded(prepared: Prepared, suffix: str) -> Any:
    """The trimesh object for checked bytes, with as many vertices and faces as it must have."""
    import trimesh  # noqa: PLC0415 - takes .2 s, and `import sherd` must stay light

    options: dict[str, Any] = {}
    if suffix in (".obj", ".ply"):  # no other file is opened, no vertex is split at a seam
        options["skip_materials"] = True
    if suffix == ".ply":
        options["fix_texture"] = False
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            loaded = trimesh.load_scene(
                io.BytesIO(prepared.data),
                file_type=suffix[1:],
                resolver=None,
                process=False,
                maintain_order=True,
                **options,
            ).to_mesh()
    except Exception as error:  # whatever a parser throws at odd bytes is a damaged file
        reason = " ".join(str(error).split())[:100] or type(error).__name__
        raise MeshFileError(
            f"cannot be read as {suffix[1:].upper()} ({reason}); export it again"
        ) from error
    counts = (len(loaded.vertices), len(loaded.faces))
    wanted = (prepared.vertex_count, prepared.face_count)
    if any(want is not None and have != want for have, want in zip(counts, wanted, strict=True)):
        raise MeshFileError(
            f"{wanted[0]} vertices and {wanted[1]} triangles are promised, but {counts[0]} and "
            f"{counts[1]} could be read; the file is damaged: export it again"
        )
    return loaded


def _fields(loaded: Any) -> dict[str, Floats]:
    """Vertex fields of a trimesh object: PLY properties by name, and colors."""
    raw = loaded.metadata.get("_ply_raw", {}).get("vertex", {}).get("data")
    if raw is None:
        if loaded.visual.kind != "vertex":
            return {}
        return {"color": np.asarray(loaded.visual.vertex_colors)[:, :3] / 255.0}
    names = raw.dtype.names
    fields = {name: raw[name].astype(np.float64) for name in names if name not in _DERIVED}
    if all(name in names for name in _COLORS):
        channels = np.stack([raw[name] for name in _COLORS], axis=1)
        whole = channels.dtype.kind in "iu"
        fields["color"] = channels / (float(np.iinfo(channels.dtype).max) if whole else 1.0)
        fields.pop("alpha", None)
    return fields
