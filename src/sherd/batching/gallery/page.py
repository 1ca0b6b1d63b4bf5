"""gallery.html: one page with a picture of each part, sorted and filtered in the browser."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any
from urllib.parse import quote

from sherd._version import __version__
from sherd.batching.ledger.manifest import GALLERY
from sherd.batching.ledger.place import THUMBNAIL
from sherd.batching.ledger.rows import STATUSES, BatchRow
from sherd.output import write_text

__all__ = ["gallery_page", "write_gallery"]

# Up to so many pictures are inside the page, 19 MB at the very most; of more, it names their files.
MOST_INSIDE = 1200


def write_gallery(folder: Path, rows: Sequence[BatchRow]) -> None:
    """Write the page of a batch; it appears complete or not at all.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    inside = len(rows) <= MOST_INSIDE
    pictures = {row.name: _picture(folder, row, inside=inside) for row in rows}
    write_text(folder / GALLERY, gallery_page(folder.resolve().name, rows, pictures))


def gallery_page(title: str, rows: Sequence[BatchRow], pictures: Mapping[str, str]) -> str:
    """HTML that needs nothing but itself and, where pictures are files, these.

    Parameters
    ----------
    title
        Of the page.
    rows
        In the order that the page begins with.
    pictures
        Address of the picture of each part by name; empty if there is none.
    """
    script = _asset("gallery.js")
    digest = base64.b64encode(hashlib.sha256(script.encode("utf-8")).digest()).decode("ascii")
    values = {
        "title": html.escape(title),
        "version": __version__,
        "style": _asset("gallery.css"),
        "script": script,
        "script_hash": f"'sha256-{digest}'",
        "statuses": "".join(f'<option value="{each}">{each}</option>' for each in STATUSES),
        "rows": _json([_card(row, pictures.get(row.name, "")) for row in rows]),
    }
    # one pass, so that nothing inside a value is taken for a placeholder
    return re.sub(r"\{\{(\w+)\}\}", lambda match: values[match[1]], _asset("gallery.html"))


def _card(row: BatchRow, picture: str) -> dict[str, Any]:
    return {
        "name": row.name,
        "full": row.full or "",
        "status": row.status,
        "reason": row.reason,
        "chance": row.chance,
        "error": row.error_estimate,
        "area": row.area_fraction,
        "link": f"{_address(row)}/report.html" if row.folder else "",
        "picture": picture,
    }


def _picture(folder: Path, row: BatchRow, *, inside: bool) -> str:
    if row.folder is None:
        return ""
    if not inside:
        return f"{_address(row)}/{THUMBNAIL}"
    try:
        content = (folder / row.folder / THUMBNAIL).read_bytes()
    except OSError:
        return ""
    if not content:
        return ""
    return f"data:image/webp;base64,{base64.b64encode(content).decode('ascii')}"


def _address(row: BatchRow) -> str:
    return quote(row.folder or "")


def _asset(name: str) -> str:
    return (resources.files("sherd.batching.gallery") / "assets" / name).read_text(encoding="utf-8")


def _json(value: Any) -> str:
    """JSON that ends no script element whatever it holds."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")
