"""Write the tables of docs/benchmark.md from what benchmarks write.

python docs/tables.py shrec16 stored=out/stored/bench.json remeshed=out/remeshed/bench.json
python docs/tables.py region remeshed=out/region/bench.json
python docs/tables.py individuals "other people=out/faust/bench.json"
python docs/tables.py puzzles "wolf, cat=out/puzzle/puzzle.json"
python docs/tables.py joins "tosca_poses=out/join/join.json"
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from statistics import mean, median
from typing import Any

TABLES = Path(__file__).parent / "tables"

SHREC16 = (
    "| Setting | Kind | Pairs | Error x100 | Median | Bad pairs | Flips | Coverage | IoU | "
    "IoU (vertices hit) | Calibration error | Seconds a pair |"
)
REGION = "| Setting | Pairs | IoU | Mirror forgiven | Best of alternatives | Seconds (median) |"
INDIVIDUALS = (
    "| Setting | Kind | Pairs (refused) | Error x100 | Median | Up to 0.05 | Up to 0.1 | Flips | "
    "Mirror forgiven | Coverage | IoU | With a place | Without: found | Without: ranked | "
    "Seconds (median) |"
)
PUZZLES = (
    "| Puzzles | Way | Number | Labels | Error x100 | Bad | Own refused | Foreign refused | "
    "F1 of refusal | IoU of the gap | Seconds |"
)
JOINS = "| Puzzle | Together | Joins right | Foreign alone | Error x100 | Known | Seconds |"


def shrec16_rows(setting: str, document: dict[str, Any]) -> list[str]:
    """A row for each kind of pair from the document of `sherd bench shrec16`."""
    return [
        f"| {setting} | {kind} | {total['pairs']} | {100 * total['mean']:.2f} | "
        f"{100 * total['median']:.2f} | {total['bad_pairs']} | {total['flips']:.1%} | "
        f"{total['coverage']:.1%} | {total['iou']:.3f} | {total['iou_vertices']:.3f} | "
        f"{total['calibration_error']:.3f} | {total['seconds']:.1f} |"
        for kind, total in document["totals"].items()
    ]


def region_rows(setting: str, document: dict[str, Any]) -> list[str]:
    """One row from the document of `sherd bench region`."""
    rows = document["rows"]
    means = [
        mean(row[name] for row in rows)
        for name in ("iou", "iou_mirror_forgiven", "iou_with_alternatives")
    ]
    seconds = median(row["seconds"] for row in rows)
    cells = " | ".join(f"{value:.3f}" for value in means)
    return [f"| {setting} | {len(rows)} | {cells} | {seconds:.1f} |"]


def individuals_rows(setting: str, document: dict[str, Any]) -> list[str]:
    """A row for each kind and for all from `sherd bench faust` or `sherd bench smal-match`."""
    rows = []
    for kind, total in [*document["totals"].items(), ("together", document["together"])]:
        large = total["large"]
        cells = [
            setting,
            kind,
            f"{total['pairs']} ({total['refused']})",
            shown(total["mean"], "{:.2f}", 100),
            shown(total["median"], "{:.2f}", 100),
            shown(total["near"], "{:.1%}"),
            shown(None if large is None else 1 - large, "{:.1%}"),
            shown(total["flips"], "{:.1%}"),
            shown(total["mirror_forgiven"], "{:.2f}", 100),
            shown(total["coverage"], "{:.1%}"),
            shown(total["iou"], "{:.3f}"),
            shown(total["present"], "{:.0%}"),
            shown(total["recognized"], "{:.0%}"),
            shown(total["ranking"], "{:.2f}"),
            shown(total["seconds_median"], "{:.1f}"),
        ]
        rows.append(f"| {' | '.join(cells)} |")
    return rows


def puzzles_rows(setting: str, document: dict[str, Any]) -> list[str]:
    """Two rows from the document of `sherd bench puzzle`: together, and single matches."""
    rows = []
    for way, total in document["totals"].items():
        cells = [
            setting,
            way,
            f"{total['puzzles']}",
            shown(total["labels"], "{:.3f}"),
            shown(total["error"], "{:.2f}", 100),
            f"{total['bad']} of {total['own']}",
            f"{total['own_refused']} of {total['own']}",
            f"{total['foreign_refused']} of {total['foreign']}",
            shown(total["refusal_f1"], "{:.2f}"),
            shown(total["gap_iou"], "{:.2f}"),
            f"{total['seconds']:.0f}",
        ]
        rows.append(f"| {' | '.join(cells)} |")
    return rows


def joins_rows(setting: str, document: dict[str, Any]) -> list[str]:
    """A row for each puzzle from the document of `sherd bench join`."""
    rows = []
    for row in document["rows"]:
        cells = [
            f"{row['puzzle']} ({setting})",
            f"{row['together']} of {row['own']}",
            f"{row['joined_right']} of {row['joined']}",
            "yes" if row["foreign_alone"] else "no",
            shown(row["error"], "{:.2f}", 100),
            shown(row["known"], "{:.2f}"),
            f"{row['seconds']:.0f}",
        ]
        rows.append(f"| {' | '.join(cells)} |")
    return rows


def shown(value: float | None, pattern: str, factor: int = 1) -> str:
    """A number as text, or a dash where it is not known."""
    return "-" if value is None else pattern.format(factor * value)


KINDS: dict[str, tuple[str, Callable[[str, dict[str, Any]], list[str]]]] = {
    "shrec16": (SHREC16, shrec16_rows),
    "region": (REGION, region_rows),
    "individuals": (INDIVIDUALS, individuals_rows),
    "puzzles": (PUZZLES, puzzles_rows),
    "joins": (JOINS, joins_rows),
}


def table(kind: str, documents: dict[str, dict[str, Any]]) -> str:
    """The table of one kind for documents by setting."""
    head, rows_of = KINDS[kind]
    rule = "|" + "---|" * (head.count("|") - 1)
    rows = [row for setting, document in documents.items() for row in rows_of(setting, document)]
    return "\n".join([head, rule, *rows]) + "\n"


def main() -> None:
    """Read the named files and write docs/tables/KIND.md."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kind", choices=KINDS)
    parser.add_argument("files", nargs="+", metavar="SETTING=FILE")
    given = parser.parse_args()
    documents = {}
    for entry in given.files:
        setting, _, path = entry.partition("=")
        documents[setting] = json.loads(Path(path).read_text(encoding="utf-8"))
    TABLES.mkdir(exist_ok=True)
    (TABLES / f"{given.kind}.md").write_text(table(given.kind, documents), encoding="utf-8")


if __name__ == "__main__":
    main()
