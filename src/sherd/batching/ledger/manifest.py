"""The list of all parts of a batch, so that whoever collects the results knows what is missing."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sherd._version import __version__
from sherd.batching.ledger.journal import JOURNALS
from sherd.batching.ledger.place import PARTS
from sherd.batching.templates import TEMPLATES
from sherd.errors import InputError, OutputError
from sherd.output import require_writable, write_text

__all__ = ["GALLERY", "Listed", "check_batch_folder", "listed", "write_manifest"]

MANIFEST = "batch.json"
MANIFEST_FORMAT = "sherd batch-list 1"
GALLERY = "gallery.html"
OURS = frozenset(
    {
        MANIFEST, GALLERY, PARTS, JOURNALS, TEMPLATES, "summary.csv", "summary.json",
        "summary.parquet", "shared_area.csv", "likeness.csv", "matrix.png",
    }
)  # fmt: skip


def check_batch_folder(folder: Path, *, overwrite: bool) -> None:
    """Refuse a folder that holds something else, before the work begins.

    Raises
    ------
    OutputError
        If it cannot be written, or holds files but no batch and may not be used anyway.
    """
    require_writable(folder, folder=True)
    if overwrite or not folder.exists() or _document(folder) is not None:
        return
    present = {path.name for path in folder.iterdir() if not path.name.startswith(".")}
    foreign = sorted(present - OURS)
    if foreign:
        more = f" and {len(foreign) - 3} more" if len(foreign) > 3 else ""
        raise OutputError(
            f"{folder}: holds {', '.join(foreign[:3])}{more} and no batch; choose another folder "
            "or allow to use it (--overwrite, in Python BatchOptions(overwrite=True))"
        )


def write_manifest(folder: Path, names: Sequence[str], **facts: Any) -> None:
    """Write ``batch.json``, unless it says the same already.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    document = {
        "format": MANIFEST_FORMAT, "version": __version__, **facts, "parts": list(names),
    }  # fmt: skip
    if _document(folder) != document:
        write_text(folder / MANIFEST, json.dumps(document, indent=1) + "\n")


@dataclass(frozen=True)
class Listed:
    """What a batch is about.

    Attributes
    ----------
    names
        Of all its parts or pairs.
    shapes
        Names of the shapes of the pairs; None if it is about parts.
    exports
        Further files.
    settings
        Hash of what all have in common: rows of a batch with others do not count.
    """

    names: tuple[str, ...]
    shapes: tuple[str, ...] | None
    exports: tuple[str, ...]
    settings: str


def listed(folder: Path) -> Listed:
    """What the batch in a folder is about.

    Raises
    ------
    InputError
        If there is no batch.
    """
    document = _document(folder)
    if document is None:
        raise InputError(f"{folder}: holds no batch; name the folder that was given with -o")
    shapes = document.get("shapes")
    return Listed(
        tuple(str(name) for name in document["parts"]),
        None if shapes is None else tuple(str(name) for name in shapes),
        tuple(str(name) for name in document.get("exports", ())),
        str(document.get("settings", "")),
    )


def _document(folder: Path) -> dict[str, Any] | None:
    try:
        document = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
        ours = document["format"] == MANIFEST_FORMAT and isinstance(document["parts"], list)
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return dict(document) if ours else None
