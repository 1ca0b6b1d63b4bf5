"""An OBJ file with its vertices moved: textures, groups and materials stay as they are."""

from __future__ import annotations

import os
from pathlib import Path

from sherd.arrays import Floats
from sherd.errors import InputError, MeshFileError

__all__ = ["has_texture", "moved_obj"]


def has_texture(path: str | os.PathLike[str]) -> bool:
    """Whether a file is an OBJ file with texture coordinates.

    Raises
    ------
    MeshFileError
        If it is an OBJ file that cannot be read.
    """
    if Path(path).suffix.lower() != ".obj":
        return False
    return any(line.split(maxsplit=1)[:1] == ["vt"] for line in _lines(Path(path)))


def moved_obj(path: str | os.PathLike[str], vertices: Floats) -> bytes:
    """The file with other coordinates for its vertices, everything else word for word.

    Texture coordinates belong to corners of faces, of which several may share a vertex, so they
    cannot be values of vertices. Normals are left out: they would be those of the old shape.

    Parameters
    ----------
    path
        An OBJ file; faces may have more than three corners.
    vertices
        (n, 3) for its n lines `v`.

    Raises
    ------
    MeshFileError
        If the file cannot be read.
    InputError
        If it has another number of vertices.
    """
    moved, count = [], 0
    for line in _lines(Path(path)):
        word = line.split(maxsplit=1)[:1]
        if word == ["v"]:
            if count < len(vertices):
                place = " ".join(repr(float(value)) for value in vertices[count])
                colors = line.partition("#")[0].split()[4:]  # a fourth number, or red, green, blue
                moved.append(" ".join(["v", place, *colors]))
            count += 1
        elif word == ["f"]:
            moved.append(" ".join(["f", *map(_without_normal, line.partition("#")[0].split()[1:])]))
        elif word != ["vn"]:
            moved.append(line)
    if count != len(vertices):
        raise InputError(
            f"{path}: has {count} vertices, but the full shape has {len(vertices)}; give the file "
            "that the full shape was read from"
        )
    return ("\n".join(moved) + "\n").encode("utf-8", "surrogateescape")


def _without_normal(corner: str) -> str:
    """3/7/9 -> 3/7, and 3//9 -> 3."""
    return "/".join(corner.split("/")[:2]).rstrip("/")


def _lines(path: Path) -> list[str]:
    """Lines, those that a backslash continues joined."""
    try:
        text = path.read_bytes().decode("utf-8", "surrogateescape")
    except OSError as error:
        raise MeshFileError(f"{path}: cannot be read ({error.strerror})") from error
    return text.replace("\\\r\n", " ").replace("\\\n", " ").splitlines()
