"""The report of `sherd overlap`: tables, page and picture of an Overlap."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.drawing.colors import correspondence_layer, full_layer, part_layer
from sherd.drawing.exhibit import Exhibit, Layer, Partner, SharedCurve, Verdict
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.files import painted_ply, table_csv
from sherd.report.frame import Content, Report, mesh_facts
from sherd.report.known_layers import file_layers, known_layer
from sherd.report.stored.folder import OVERLAP_FORMAT
from sherd.results.overlap_result import Overlap, SharedMap
from sherd.results.status import Status

__all__ = ["overlap_report"]

# So many pairs of the surest points are drawn as lines: enough to follow, few enough to see.
ANCHOR_COUNT = 60


def overlap_report(result: Overlap, *, command: str = "") -> Report:
    """All that is written of what two shapes share."""
    document = _document(result, command)
    exhibit = _exhibit(result, document)
    colors = full_layer(exhibit, exhibit.full_layers[0].name) or exhibit.full_layers[0]
    carried = part_layer(exhibit, colors.name) or colors
    one, other = result.first_to_second, result.second_to_first
    files: dict[str, Content] = {
        "correspondence.csv": partial(_map_csv, other, "second", "first", result.first),
        "inverse.csv": partial(_map_csv, one, "first", "second", result.second),
        "first_region.csv": partial(_region_csv, "first", one.matched, one.membership),
        "second_region.csv": partial(_region_csv, "second", other.matched, other.membership),
        "first.ply": partial(painted_ply, result.first, exhibit.full_layers, painted=colors),
        "second.ply": partial(painted_ply, result.second, exhibit.part_layers, painted=carried),
    }
    return Report(document, exhibit, files, picture_name="overlap.png")


def _map_csv(found: SharedMap, here: str, there: str, mesh: TriangleMesh) -> str:
    """A row for each vertex of `here`, from 0, with the best guess also where unmatched."""
    points = found.points
    return table_csv(
        {
            f"{here}_vertex": np.arange(len(points)),
            f"{there}_face": points.faces,
            **{f"b{k}": points.barycentric[:, k] for k in range(3)},
            f"{there}_vertex": points.nearest_vertices(mesh),
            "matched": found.matched,
            "confidence": found.confidence,
        }
    )


def _region_csv(shape: str, inside: Bools, membership: Floats) -> str:
    return table_csv(
        {
            f"{shape}_vertex": np.arange(len(inside)),
            "in_region": inside,
            "membership": membership,
        }
    )


def _document(result: Overlap, command: str) -> dict[str, Any]:
    return {
        "format": OVERLAP_FORMAT,
        "version": result.version,
        "command": command,
        "first": mesh_facts(result.first, result.notices.get("first", ())),
        "second": mesh_facts(result.second, result.notices.get("second", ())),
        "status": result.status.name.lower(),
        "advice": result.advice,
        "chance": result.chance,
        "scale": result.scale,
        "shared_of_first": result.shared_of_first,
        "shared_of_second": result.shared_of_second,
        "mean_confidence": {
            "first": _mean(result.first_to_second),
            "second": _mean(result.second_to_first),
        },
        "check": asdict(result.check()),
        "unfollowed_landmarks": [asdict(each) for each in result.unfollowed_landmarks],
        "strain_curve": asdict(result.curve),
        "options": asdict(result.options),
        "seed": result.options.seed,
        "working_vertices": dict(result.working_vertices),
        "timings": dict(result.timings),
    }


def _mean(found: SharedMap) -> float | None:
    """Mean confidence of the matched vertices; None if there are none."""
    return float(found.confidence[found.matched].mean()) if found.matched.any() else None


def _exhibit(result: Overlap, document: Mapping[str, Any]) -> Exhibit:
    one, other = result.first_to_second, result.second_to_first
    answer = ("status", "advice", "chance", "scale", "shared_of_first", "shared_of_second")
    return Exhibit(
        title=f"{result.first.name} and {result.second.name}",
        full=result.first,
        part=result.second,
        full_layers=(
            correspondence_layer(result.first),
            *_layers(one),
            *file_layers(result.first.fields, carried=True),
        ),
        part_layers=(*_layers(other), *file_layers(result.second.fields)),
        partner=Partner(other.points, other.matched, other.confidence),
        anchors=_anchors(other, result.first),
        score=result.chance,
        score_name="chance that the answer is right",
        verdict=Verdict.from_advice(result.advice, trusted=result.status is Status.GOOD),
        summary=_sentences(result),
        facts={
            "Result": {key: document[key] for key in (*answer, "version")},
            "First shape": document["first"],
            "Second shape": document["second"],
            "Check": document["check"],
            "Options": document["options"],
            "Seconds": document["timings"],
        },
        command=str(document["command"]),
        landmarks=tuple((second, first) for first, second in result.options.landmarks),
        ignored=tuple(result.options.ignore_second),
        region=one.matched if one.matched.any() else np.ones(len(one.matched), dtype=bool),
        names=("First shape", "Second shape"),
        curve=SharedCurve(
            result.curve.strains, result.curve.first, result.curve.second, result.options.strain
        ),
    )


def _layers(found: SharedMap) -> tuple[Layer, ...]:
    return (
        known_layer("confidence", found.confidence),
        known_layer("shared", found.matched),
        known_layer("membership", found.membership),
    )


def _anchors(found: SharedMap, first: TriangleMesh) -> Ints:
    """Pairs of the surest shared vertices, spread over the second shape: second, first."""
    sure = np.argsort(-found.confidence, kind="stable")
    sure = sure[found.matched[sure]]
    if not len(sure):
        return np.empty((0, 2), dtype=np.int64)
    half = sure[: max(ANCHOR_COUNT, len(sure) // 2)]
    chosen = half[np.linspace(0, len(half) - 1, min(ANCHOR_COUNT, len(half))).astype(int)]
    points: SurfacePoints = found.points[chosen]
    return np.column_stack([chosen, points.nearest_vertices(first)])


def _sentences(result: Overlap) -> tuple[str, ...]:
    if not (result.first_to_second.matched.any() and result.second_to_first.matched.any()):
        said = ["Nothing was found that both shapes share."]
    else:
        check = result.check()
        said = [
            f"{100 * result.shared_of_first:.0f} % of the first shape and "
            f"{100 * result.shared_of_second:.0f} % of the second are shared.",
            "A shared point that goes to the other shape and back ends up "
            f"{check.there_and_back:.2f} edges from where it began, on average.",
        ]
    said.append(f"The chance that the answer as a whole is right is {100 * result.chance:.0f} %.")
    if result.scale != 1.0 or result.options.scale == "unknown":
        said.append(f"The second shape was enlarged {result.scale:.4g} times to fit.")
    for name in ("first", "second"):
        said += [f"{name.capitalize()} shape: {text}" for text in result.notices.get(name, ())]
    return tuple(said)
