"""bench.html: the totals, curves and rows of the SHREC'16 benchmark as one page."""

from __future__ import annotations

import base64
import html
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sherd.benchmark.paper_drawing import check_plotting, draw_curves
from sherd.output import write_text

__all__ = ["write_benchmark_page"]

COLUMNS = (
    ("pair", "pair", "{}"),
    ("area_fraction", "area", "{:.2f}"),
    ("mean", "mean error x100", "{:.2f}"),
    ("median", "median", "{:.2f}"),
    ("flips", "flips", "{:.3f}"),
    ("coverage", "coverage", "{:.3f}"),
    ("iou", "region IoU", "{:.3f}"),
    ("iou_vertices", "IoU (vertices hit)", "{:.3f}"),
)
ERRORS = ("mean", "median")

STYLE = """
body{font:15px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;
color:#1a1d24;background:#fff}
table{border-collapse:collapse;width:100%;margin:1rem 0}
td,th{padding:.2rem .5rem;border-bottom:1px solid #dde1e7;text-align:right}
td:first-child,th:first-child{text-align:left}
img{max-width:100%}
@media(prefers-color-scheme:dark){body{color:#e6e9ef;background:#14161a}
td,th{border-color:#333944}img{background:#fff}}
"""


def write_benchmark_page(summary: Mapping[str, Any], folder: Path) -> None:
    """Write ``curve.png``, ``calibration.png`` and ``bench.html`` for the content of bench.json.

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
        {kind: (summary["thresholds"], total["curve"]) for kind, total in totals.items()},
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
    said = f"{summary['data']}. Meshes {summary['meshes']}, {turned}, scale {scale}."
    pictures = "".join(
        f'<img alt="{name}" src="data:image/png;base64,'
        f'{base64.b64encode((folder / name).read_bytes()).decode()}">'
        for name in ("curve.png", "calibration.png")
    )
    return (
        "<!doctype html><html lang='en'><meta charset='utf-8'>"
        f"<title>sherd on SHREC'16</title><style>{STYLE}</style>"
        f"<h1>sherd {html.escape(str(summary['version']))} on SHREC'16</h1>"
        f"<p>{html.escape(said)} Every vertex is answered and counted.</p>"
        f"{_totals(summary['totals'])}{pictures}{_rows(summary['rows'])}</html>\n"
    )


def _totals(totals: Mapping[str, Mapping[str, Any]]) -> str:
    head = ("", "pairs", "mean error x100", "median x100", "region IoU", "bad pairs", "flips",
            "coverage", "calibration error", "seconds a pair")  # fmt: skip
    body = [
        (
            kind, total["pairs"], f"{100 * total['mean']:.2f}", f"{100 * total['median']:.2f}",
            f"{total['iou']:.3f}", total["bad_pairs"], f"{total['flips']:.3f}",
            f"{total['coverage']:.3f}", f"{total['calibration_error']:.3f}",
            f"{total['seconds']:.1f}",
        )
        for kind, total in totals.items()
    ]  # fmt: skip
    return _table(head, body)


def _rows(rows: list[Mapping[str, Any]]) -> str:
    body = [
        tuple(
            pattern.format(100 * row[name] if name in ERRORS else row[name])
            for name, _, pattern in COLUMNS
        )
        for row in rows
    ]
    return _table(tuple(title for _, title, _ in COLUMNS), body)


def _table(head: tuple[str, ...], body: list[tuple[Any, ...]]) -> str:
    top = "".join(f"<th>{html.escape(cell)}</th>" for cell in head)
    lines = "".join(
        "<tr>" + "".join(f"<td>{html.escape(str(cell))}</td>" for cell in row) + "</tr>"
        for row in body
    )
    return f"<table><tr>{top}</tr>{lines}</table>"
