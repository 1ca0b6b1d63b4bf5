"""Prepared: bytes that trimesh reads without surprises, and the tools shared by the formats."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.errors import MeshFileError
from sherd.mesh.words import counted

__all__ = [
    "Prepared",
    "decoded",
    "numbers",
    "polygon_notices",
    "refuse_foreign_characters",
    "refuse_out_of_range",
]

_BYTE_ORDER_MARKS = (
    (b"\xef\xbb\xbf", "utf-8-sig"),
    (b"\xff\xfe", "utf-16"),
    (b"\xfe\xff", "utf-16"),
)
# Characters of numbers; the letters also spell "nan" and "inf", which are refused later by name.
_NUMBER_CHARACTERS = dict.fromkeys(map(ord, "0123456789+-.eE \t\r\nnaifNAIF"))
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?(nan|inf)", re.IGNORECASE)


@dataclass(frozen=True)
class Prepared:
    """Bytes for trimesh and what it must find in them.

    Parameters
    ----------
    data
        The file, made harmless.
    vertex_count, face_count
        Vertices and triangles (after polygons are cut) that must come out; None if unknown.
    notices
        What the user should know, in words.
    """

    data: bytes
    vertex_count: int | None
    face_count: int | None
    notices: tuple[str, ...] = ()


def decoded(data: bytes) -> str:
    """The text of a file in UTF-8, UTF-16 with a byte order mark, or Latin-1.

    Raises
    ------
    MeshFileError
        If the bytes are no text.
    """
    encoding = next((name for mark, name in _BYTE_ORDER_MARKS if data.startswith(mark)), "utf-8")
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError:
        text = data.decode("latin-1")  # names and comments of old programs
    if "\0" in text:
        raise MeshFileError(
            "holds binary data where text is expected; give it the suffix of its true format"
        )
    return text


def numbers(lines: list[str], what: str) -> Floats:
    """All numbers in `lines`, separated by white space, flat.

    Raises
    ------
    MeshFileError
        Naming the first line, as number so and so of `what`, that holds anything else.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # numpy only warns where the text ends early
        try:
            return np.fromstring("\n".join(lines), sep=" ", dtype=np.float64)
        except (DeprecationWarning, ValueError) as error:
            for index, line in enumerate(lines):
                if not all(re.fullmatch(_NUMBER, word) for word in line.split()):
                    raise MeshFileError(
                        f"{what} {index} reads {line[:40]!r}, which are no numbers; "
                        "export the mesh again"
                    ) from error
            raise MeshFileError(f"a {what} holds what is no number; export it again") from error


def refuse_foreign_characters(lines: list[str], what: str) -> None:
    """Raise MeshFileError naming the first of `lines` with a character no number has."""
    if not "".join(lines).translate(_NUMBER_CHARACTERS):
        return
    for index, line in enumerate(lines):
        if line.translate(_NUMBER_CHARACTERS):
            shown = line if len(line) <= 60 else line[:57] + "..."
            remedy = "export the mesh again"
            if re.search(r"\d,\d", line):
                remedy = "decimal commas were written; export with decimal points"
            raise MeshFileError(f"{what} {index} reads {shown!r}, which are no numbers; {remedy}")


def refuse_out_of_range(flat: Ints, corners: Ints, count: int) -> None:
    """Raise MeshFileError naming the first of `flat` indices that is no vertex of `count`."""
    bad = (flat < 0) | (flat >= count)
    if bad.any():
        first = int(np.argmax(bad))
        row = int(np.searchsorted(np.cumsum(corners), first, side="right"))
        raise MeshFileError(
            f"face {row} names vertex {flat[first]}, but there are {count} vertices "
            f"(0..{count - 1}); the file is damaged or counts vertices from 1: export it again"
        )


def polygon_notices(corners: Ints) -> tuple[str, ...]:
    """What became of faces with these numbers of corners, if they are no triangles."""
    notices = []
    if (corners > 3).any():
        count = int((corners > 3).sum())
        notices.append(f"cut {counted(count, 'face')} with more than three corners into triangles")
    if (corners < 3).any():
        count = int((corners < 3).sum())
        notices.append(f"left out {counted(count, 'face')} with fewer than three corners")
    return tuple(notices)
