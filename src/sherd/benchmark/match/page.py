"""bench.html: totals, curves, times and rows of a benchmark of `match` as one page."""

from __future__ import annotations

import base64
import html
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sherd.benchmark.paper.drawing import check_plotting, draw_curves
from sherd.output import write_text

__all__ = ["write_benchmark_page"]

# What is shown of a pair and of a total: name in bench.json, title, format, factor.
MEASURES = (
    ("area_fraction", "area", "{:.2f}", 1),
    ("present", "vertices with a place", "{:.2f}", 1),
    ("mean", "mean error x100", "{:.2f}", 100),
    ("median", "median x100", "{:.2f}", 100),
    ("near", "errors up to 0.05", "{:.1%}", 1),
    ("large", "errors above 0.1", "{:.1%}", 1),
    ("flips", "flips", "{:.1%}", 1),
    ("mirror_forgiven", "mean x100, mirror forgiven", "{:.2f}", 100),
    ("coverage", "coverage", "{:.1%}", 1),
    ("mean_matched", "mean x100 of the matched", "{:.2f}", 100),
    ("recognized", "vertices without a place, unmatched", "{:.1%}", 1),
    ("ranking", "chance that confidence ranks them lower", "{:.2f}", 1),
    ("iou", "region IoU (dense)", "{:.3f}", 1),
    ("iou_vertices", "region IoU (vertices hit)", "{:.3f}", 1),
)
COUNTS = (
    ("pairs", "pairs"),
    ("refused", "refused"),
    ("bad_pairs", "bad pairs"),
)

STYLE = """
body{font:15px/1.5 system-ui,sans-serif;max-width:80rem;margin:2rem auto;padding:0 1rem;
color:#1a1d24;background:#fff}
table{border-collapse:collapse;width:100%;margin:1rem 0}
td,th{padding:.2rem .5rem;border-bottom:1px solid #dde1e7;text-align:right}
td:first-child,th:first-child{text-align:left}
th{vertical-align:bottom;font-weight:600}section{overflow-x:auto}
img{width:49%;min-width:20rem}
@media(prefers-color-scheme:dark){body{color:#e6e9ef;background:#14161a}
td,th{border-color:#333944}img{background:#fff}}
"""


def write_benchmark_page(summary: Mapping[str, Any], folder: Path) -> None:
    """Write ``curve.png``, ``calibration.png`` and ``bench.html`` for what bench.json holds.

    Raises
    ------
    OptionError
        If matplotlib is not installed.
    OutputError
        If a file cannot be written.
    """
    check_plotting()
    totals = summary["totals"]
    draw_curves(
        folder / "curve.png",
        {
            kind: (summary["thresholds"], total["curve"])
            for kind, total in totals.items()
            if total["curve"]
        },
        labels=("error, in sqrt(area of the full shape)", "share of vertices"),
        heading="How many answers are how near",
    )
    calibration: dict[str, tuple[list[float], list[float]]] = {
        kind: (
            [row[1] for row in total["calibration"] if row[0] > 0],
            [row[2] for row in total["calibration"] if row[0] > 0],
        )
        for kind, total in totals.items()
    }
    draw_curves(
        folder / "calibration.png",
        {**calibration, "perfect": ([0.0, 1.0], [0.0, 1.0])},
        labels=("confidence", "share of errors below 0.05"),
        heading="Is confidence the chance that it says?",
    )
    write_text(folder / "bench.html", _page(summary, folder))


def _page(summary: Mapping[str, Any], folder: Path) -> str:
    settings = summary["settings"]
    scale = "unknown" if settings["unknown_scale"] else "known"
    turned = "randomly rotated" if settings["rotate"] else "not rotated"
    shown = ", parts as their points alone" if settings["points"] else ""
    title = f"sherd {summary['version']} on {summary['title']}"
    said = (
        f"{summary['data']}. Meshes {summary['meshes']}{shown}, {turned}, scale {scale}, seed "
        f"{settings['seed']}. The error of a vertex is the geodesic distance on the full shape "
        "between answer and truth over the square root of the full shape's area; every vertex "
        "that has a true place is answered and counted. A bad pair has a mean error x100 above 10."
    )
    pictures = "".join(
        f'<img alt="{name}" src="data:image/png;base64,'
        f'{base64.b64encode((folder / name).read_bytes()).decode()}">'
        for name in ("curve.png", "calibration.png")
    )
    totals = dict(summary["totals"])
    if len(totals) > 1:
        totals["together"] = summary["together"]
    return (
        "<!doctype html><html lang='en'><meta charset='utf-8'>"
        f"<title>{html.escape(title)}</title><style>{STYLE}</style>"
        f"<h1>{html.escape(title)}</h1><p>{html.escape(said)}</p>"
        f"<h2>Means over pairs</h2>{_totals(totals)}{pictures}"
        f"<h2>Seconds by stage</h2>{_stages(totals)}<h2>Pairs</h2>{_rows(summary['rows'])}</html>\n"
    )


def _totals(totals: Mapping[str, Mapping[str, Any]]) -> str:
    """A table with a line for each measure and a column for each kind."""
    body = [
        (title, *(str(total[name]) for total in totals.values()))
        for name, title in COUNTS
        if name != "refused" or any(total[name] for total in totals.values())
    ]
    body += [
        (title, *(_shown(total[name], pattern, factor) for total in totals.values()))
        for name, title, pattern, factor in _known_measures(list(totals.values()))
    ]
    errors = (_shown(total["calibration_error"], "{:.3f}", 1) for total in totals.values())
    body.append(("calibration error of confidence", *errors))
    return _table(("", *totals), body)


def _stages(totals: Mapping[str, Mapping[str, Any]]) -> str:
    names = dict.fromkeys(name for total in totals.values() for name in total["stages"])
    body = [
        (name, *(_shown(total["stages"].get(name), "{:.2f}", 1) for total in totals.values()))
        for name in names
    ]
    for name, title in (
        ("seconds", "a pair"),
        ("seconds_median", "a pair, median"),
        ("template_seconds", "preparing a full shape"),
    ):
        shown = (_shown(total[name], "{:.2f}", 1) for total in totals.values())
        body.append((title, *shown))
    return _table(("", *totals), body)


def _rows(rows: list[Mapping[str, Any]]) -> str:
    measures = _known_measures(rows)
    body = [
        (
            row["pair"],
            *(_shown(row[name], pattern, factor) for name, _, pattern, factor in measures),
            row["status"].lower(),
            _shown(sum(row["seconds"].values()) or None, "{:.1f}", 1),
        )
        for row in rows
    ]
    return _table(("pair", *(title for _, title, _, _ in measures), "status", "seconds"), body)


def _known_measures(rows: list[Mapping[str, Any]]) -> list[tuple[str, str, str, int]]:
    """The measures that are known of some row; a share of 1 everywhere is not shown."""
    return [
        measure
        for measure in MEASURES
        if any(row[measure[0]] is not None for row in rows)
        and (measure[0] != "present" or any(row["present"] != 1 for row in rows))
    ]


def _shown(value: float | None, pattern: str, factor: int) -> str:
    return "" if value is None else pattern.format(factor * value)


def _table(head: tuple[str, ...], body: list[tuple[Any, ...]]) -> str:
    top = "".join(f"<th>{html.escape(cell)}</th>" for cell in head)
    lines = "".join(
        "<tr>" + "".join(f"<td>{html.escape(str(cell))}</td>" for cell in row) + "</tr>"
        for row in body
    )
    return f"<section><table><tr>{top}</tr>{lines}</table></section>"
