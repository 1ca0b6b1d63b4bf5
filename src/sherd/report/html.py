"""report.html: one file that shows an exhibit in three dimensions, offline, in any browser."""

from __future__ import annotations

import base64
import hashlib
import html
import importlib.metadata
import json
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from typing import Any

import numpy as np
from PIL import Image

from sherd.drawing.exhibit import Exhibit, Verdict
from sherd.drawing.picture import Staging, picture, png_bytes, stage
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import write_text
from sherd.report.payload import payload
from sherd.report.strain_curve import strain_curve_svg
from sherd.report.thinning import LARGEST_SHOWN, Thinned, thinned
from sherd.report.tradeoff import tradeoff_svg

__all__ = ["Packed", "packed", "page", "page_of", "write_page"]

# Tables of facts say more entries than this by their number: ignored vertices are thousands.
LONGEST_LIST = 20


def page(exhibit: Exhibit, *, largest: int = LARGEST_SHOWN, staging: Staging | None = None) -> str:
    """HTML of a report that needs nothing but itself.

    Parameters
    ----------
    exhibit
        What to show.
    largest
        Shapes with more vertices than this are decimated for the 3D view, and the page says so.
    staging
        A camera chosen before.

    Returns
    -------
    str
        A complete document. Names are escaped, only the page's own script may run (its hash is in
        the content security policy), and nothing is loaded from elsewhere.

    Notes
    -----
    About .75 MB plus 25 bytes per vertex and layer-pair; coordinates and scalars are shown to
    1/65,000 of their range.
    """
    shown = packed(exhibit, largest=largest, staging=staging)
    return page_of(
        exhibit, shown, picture(shown.light.exhibit, heading=False, staging=shown.staging)
    )


@dataclass(frozen=True)
class Packed:
    """What the page's script draws.

    Attributes
    ----------
    light
        The exhibit with as many vertices as are shown.
    staging
        The camera.
    meta, data
        See :func:`sherd.report.payload.payload`.
    """

    light: Thinned
    staging: Staging
    meta: dict[str, Any]
    data: str


def packed(
    exhibit: Exhibit, *, largest: int = LARGEST_SHOWN, staging: Staging | None = None
) -> Packed:
    """The first half of :func:`page`: no picture is needed yet."""
    light = thinned(exhibit, largest=largest)
    staging = staging or stage(light.exhibit)
    meta, data = payload(light, staging)
    return Packed(light, staging, meta, data)


def page_of(exhibit: Exhibit, shown: Packed, image: Image.Image) -> str:
    """The second half of :func:`page`; the picture serves print and browsers without WebGL."""
    script = _asset("viewer.js")
    digest = base64.b64encode(hashlib.sha256(script.encode("utf-8")).digest()).decode("ascii")
    parts = {
        "title": html.escape(exhibit.title),
        "verdict": _verdict(exhibit.verdict),
        "headline": html.escape(exhibit.summary[0] if exhibit.summary else ""),
        "full_name": html.escape(exhibit.names[0]),
        "part_name": html.escape(exhibit.names[1]),
        "full_caption": html.escape(_caption(exhibit.full)),
        "part_caption": html.escape(_caption(exhibit.part)),
        "picture": base64.b64encode(png_bytes(image)).decode("ascii"),
        "picture_words": html.escape(" ".join((exhibit.title, *exhibit.summary))),
        "tradeoff": _strain_curve(exhibit) + _tradeoff(exhibit),
        "summary": _summary(exhibit.summary),
        "notice": _card("Decimated view", shown.light.notice, kind="notice wide")
        if shown.light.notice
        else "",
        "command": _command(exhibit.command),
        "facts": _facts(exhibit.facts),
        "version": importlib.metadata.version("sherd"),
        "style": _asset("viewer.css"),
        "script": script,
        "script_hash": f"'sha256-{digest}'",
        "meta": _json(shown.meta),
        "data": shown.data,
    }
    # one pass, so that nothing inside a value is taken for a placeholder
    return re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match[1]], _asset("page.html"))


def write_page(
    exhibit: Exhibit, path: str | os.PathLike[str], *, largest: int = LARGEST_SHOWN
) -> None:
    """Write :func:`page` to `path`; the file appears complete or not at all.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    write_text(path, page(exhibit, largest=largest))


def _asset(name: str) -> str:
    return (resources.files("sherd.report") / "assets" / name).read_text(encoding="utf-8")


def _json(value: Any) -> str:
    """JSON that ends no script element whatever it holds."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _caption(mesh: TriangleMesh) -> str:
    return f"{mesh.name}, {mesh.vertex_count:,} vertices"


def _card(title: str, text: str, *, kind: str) -> str:
    return f'<div class="card {kind}"><h2>{html.escape(title)}</h2><p>{html.escape(text)}</p></div>'


def _verdict(verdict: Verdict | None) -> str:
    if verdict is None:
        return ""
    kind = "trusted" if verdict.trusted else "doubted"
    advice = f"<span>{html.escape(verdict.advice)}</span>" if verdict.advice else ""
    return f'<p id="verdict" class="{kind}"><b>{html.escape(verdict.words)}</b>{advice}</p>'


def _tradeoff(exhibit: Exhibit) -> str:
    """The plot of confidence, and what its unit of error is in the numbers of the file."""
    partner = exhibit.partner
    plot = "" if partner is None else tradeoff_svg(np.asarray(partner.confidence), partner.known)
    if not plot:
        return ""
    of = exhibit.full if exhibit.unit_of is None else exhibit.unit_of
    whose = "the full shape" if of is exhibit.full else of.name
    unit = float(np.sqrt(of.area))
    words = (
        "How many vertices remain if only the surer answers are kept. Confidence is the chance "
        f"that an answer is within 0.05 sqrt(area), here {0.05 * unit:.4g}, of the truth: "
        f"1 sqrt(area) of {whose} is {unit:.4g} in the units of its file."
    )
    return (
        '<div class="card wide tradeoff"><div><h2>What the confidence is worth</h2>'
        f"<p>{html.escape(words)}</p></div>{plot}</div>"
    )


def _strain_curve(exhibit: Exhibit) -> str:
    """The plot of shared area against accepted strain."""
    if exhibit.curve is None:
        return ""
    words = (
        "How much of each shape is shared if more strain is accepted, or less. Where a curve is "
        "flat, the border does not depend on the choice; where it rises, what is added is less "
        "and less alike."
    )
    return (
        '<div class="card wide tradeoff"><div><h2>How alike is enough</h2>'
        f"<p>{html.escape(words)}</p></div>{strain_curve_svg(exhibit.curve)}</div>"
    )


def _summary(sentences: tuple[str, ...]) -> str:
    if len(sentences) < 2:  # the first one is the headline
        return ""
    items = "".join(f"<li>{html.escape(sentence)}</li>" for sentence in sentences[1:])
    return f'<div class="card wide" id="summary"><h2>In words</h2><ul>{items}</ul></div>'


def _command(command: str) -> str:
    if not command:
        return ""
    return (
        '<div class="card wide"><h2>The same result again</h2><div class="command">'
        f'<code id="command">{html.escape(command)}</code>'
        '<button id="copy" type="button" class="quiet">Copy</button></div></div>'
    )


def _facts(facts: Mapping[str, Any]) -> str:
    if not facts:
        return ""
    tables = "".join(_table(name, rows) for name, rows in facts.items())
    return f'<div class="facts wide">{tables}</div>'


def _table(name: str, rows: Any) -> str:
    pairs = list(_flat(rows)) if isinstance(rows, Mapping) else [("", rows)]
    cells = "".join(
        f"<tr><th scope='row'>{html.escape(key.replace('_', ' '))}</th>"
        f"<td{_kind(value)}>{html.escape(_text(value))}</td></tr>"
        for key, value in pairs
    )
    return f'<div class="card"><h2>{html.escape(str(name))}</h2><table>{cells}</table></div>'


def _flat(rows: Mapping[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    flat: list[tuple[str, Any]] = []
    for key, value in rows.items():
        name = f"{prefix}{key}"
        if isinstance(value, Mapping):
            flat.extend(_flat(value, f"{name}, "))
        else:
            flat.append((name, value))
    return flat


def _kind(value: Any) -> str:
    return ' class="number"' if isinstance(value, (int, float, np.number)) else ""


def _text(value: Any) -> str:
    if isinstance(value, list | tuple | np.ndarray):
        if len(value) > LONGEST_LIST:
            return f"{len(value):,} entries"
        words = (
            f"({_text(entry)})" if isinstance(entry, list | tuple | np.ndarray) else _text(entry)
            for entry in value
        )
        return ", ".join(words) or "none"
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, int | float | np.number):
        return _number(float(value), whole=isinstance(value, int | np.integer))
    return "unknown" if value is None else str(value)


def _number(value: float, *, whole: bool) -> str:
    if not np.isfinite(value):
        return "unknown"
    return f"{value:,.0f}" if whole or 1e4 <= abs(value) < 1e9 else f"{value:.4g}"
