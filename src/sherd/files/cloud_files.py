"""Read a part that may be a mesh or a scan without faces."""

from __future__ import annotations

import io
import os
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from sherd.arrays import Floats
from sherd.errors import InputError, MeshFileError
from sherd.files.mesh_files import file_content, read_content, read_mesh
from sherd.files.preflight.prepared import decoded
from sherd.mesh.point_cloud import PointCloud
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["read_points", "read_scan"]


def read_scan(path: str | os.PathLike[str]) -> TriangleMesh | PointCloud:
    r"""Read a triangle mesh, or the points of an XYZ file or of PLY, OBJ or OFF without faces.

    Raises
    ------
    MeshFileError
        If the file is missing, damaged, or promises more than it holds.
    InvalidMeshError
        If it describes neither a mesh nor a point cloud.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(f"{folder}/scan.xyz").write_text("0 0 0\n1 0 0\n0 1 0\n1 1 0\n")
    ...     read_scan(f"{folder}/scan.xyz")
    PointCloud('scan.xyz', 4 points)
    """
    cloud = read_points(path)
    return read_mesh(path) if cloud is None else cloud


def read_points(path: str | os.PathLike[str]) -> PointCloud | None:
    """Read the points of an XYZ file, or of PLY, OBJ or OFF without faces; None for a mesh.

    XYZ is a line of three coordinates for each point; three more numbers are its normal if all
    normals have length 1, and are passed over otherwise, as further ones are.

    Raises
    ------
    MeshFileError
        If the file is missing, damaged, or promises more than it holds.
    InvalidMeshError
        If the points are none, such as not finite.
    """
    source = Path(path)
    suffix = source.suffix.lower()
    if suffix == ".xyz":
        return _read_xyz(source)
    try:
        data, prepared = read_content(source)
    except InputError as error:
        raise type(error)(f"{source}: {error}") from error.__cause__
    if prepared.face_count != 0 or not prepared.vertex_count or suffix not in _READERS:
        return None
    try:
        points, normals = _READERS[suffix](data, prepared.vertex_count)
        _check_count(len(points), prepared.vertex_count)
        return PointCloud(points, normals, name=source.name)
    except InputError as error:
        raise type(error)(f"{source}: {error}") from error.__cause__
    except Exception as error:  # whatever a parser throws at odd bytes is a damaged file
        reason = " ".join(str(error).split())[:100] or type(error).__name__
        raise MeshFileError(f"{source}: cannot be read as points ({reason})") from error


def _check_count(count: int, promised: int) -> None:
    if count != promised:
        raise MeshFileError(
            f"{promised} points are promised, but {count} could be read; the file is damaged: "
            "export it again"
        )


def _read_xyz(source: Path) -> PointCloud:
    try:
        lines = decoded(file_content(source)).splitlines()
        rows = [line.split("#")[0].replace(",", " ").split() for line in lines]
        rows = [row for row in rows if row]
        try:
            if rows and len(rows[0]) == 1:  # some programs write the number of points first
                rows = rows[1:]
            table = np.array([row[:6] for row in rows], dtype=np.float64)
            points, others = table[:, :3], table[:, 3:]
        except (ValueError, IndexError) as error:
            raise MeshFileError(
                "is no table of coordinates x y z, a line for each point; export it again"
            ) from error
        unit = others.shape[1] == 3 and np.allclose(np.linalg.norm(others, axis=1), 1.0, atol=0.01)
        return PointCloud(points, others if unit else None, name=source.name)
    except InputError as error:
        raise type(error)(f"{source}: {error}") from error.__cause__


def _ply(data: bytes, count: int) -> tuple[Floats, Floats | None]:
    import trimesh  # noqa: PLC0415 - takes .2 s

    del count  # compared by the caller
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        loaded: Any = trimesh.load(
            io.BytesIO(data), file_type="ply", process=False, skip_materials=True, fix_texture=False
        )
    raw = loaded.metadata.get("_ply_raw", {}).get("vertex", {}).get("data")
    # trimesh keeps a dictionary of columns for text and a structured array for binary files
    names = () if raw is None else tuple(raw) if isinstance(raw, dict) else raw.dtype.names
    if not all(name in names for name in ("nx", "ny", "nz")):
        return np.asarray(loaded.vertices, dtype=np.float64), None
    columns = [np.asarray(raw[name], dtype=np.float64).ravel() for name in ("nx", "ny", "nz")]
    normals = np.stack(columns, axis=1)
    length = np.linalg.norm(normals, axis=1)
    # programs that know no normals write zeros
    known = bool((np.isfinite(length) & (length > 0)).all())
    return np.asarray(loaded.vertices, dtype=np.float64), normals if known else None


def _obj(data: bytes, count: int) -> tuple[Floats, Floats | None]:
    rows: dict[str, list[list[float]]] = {"v": [], "vn": []}
    for line in decoded(data).splitlines():
        words = line.split("#")[0].split()
        if words and words[0] in rows:
            rows[words[0]].append([float(word) for word in words[1:4]])
    normals = np.array(rows["vn"]) if len(rows["vn"]) == count else None
    return np.array(rows["v"], dtype=np.float64), normals


def _off(data: bytes, count: int) -> tuple[Floats, Floats | None]:
    lines = [line.split("#")[0].split() for line in decoded(data).splitlines()]
    words = [line for line in lines if line]
    if words and words[0][0].upper().endswith("OFF"):
        words = [words[0][1:], *words[1:]] if len(words[0]) > 1 else words[1:]
    rows = [[float(word) for word in line[:3]] for line in words[1 : count + 1]]
    return np.array(rows, dtype=np.float64), None


_READERS = {".ply": _ply, ".obj": _obj, ".off": _off}
