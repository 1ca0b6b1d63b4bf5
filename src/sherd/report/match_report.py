"""The report of `sherd match`: tables, page and picture of a MatchResult."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.drawing.colors import correspondence_layer, full_layer, part_layer
from sherd.drawing.exhibit import Alternative, Exhibit, Layer, Partner, Verdict
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.files import corr_text, painted_ply, table_csv
from sherd.report.frame import (
    Content,
    Report,
    alternative_facts,
    alternative_sentences,
    common_facts,
    decimation_sentences,
    facts_of,
    notice_sentences,
    region_csv,
)
from sherd.report.known_layers import error_layer, file_layers, known_layer
from sherd.report.stored.folder import MATCH_FORMAT
from sherd.report.stored.stored_match import stored_alternatives
from sherd.results.distortion import Distortion, mean_at_vertices
from sherd.results.match_result import MatchResult
from sherd.results.placement import Placement
from sherd.results.status import Status

__all__ = ["correspondence_csv", "match_report"]

# So many pairs of the surest points are drawn as lines: enough to follow, few enough to see.
ANCHOR_COUNT = 60


def match_report(result: MatchResult, *, command: str = "", errors: Floats | None = None) -> Report:
    """All that is written of a match; `errors` (n_part,) where the truth is known."""
    document = _document(result, command, errors)
    exhibit = _exhibit(result, document, errors)
    colors = full_layer(exhibit, exhibit.full_layers[0].name) or exhibit.full_layers[0]
    carried = part_layer(exhibit, colors.name) or colors
    files: dict[str, Content] = {
        "correspondence.csv": partial(correspondence_csv, result),
        "correspondence.corr": partial(corr_text, _partner(result)),
        "region.csv": partial(region_csv, result.best),
        "full.ply": partial(painted_ply, result.full, exhibit.full_layers, painted=colors),
        "part.ply": partial(painted_ply, result.part, exhibit.part_layers, painted=carried),
    }
    if result.alternatives:
        files["alternatives.npz"] = partial(stored_alternatives, result.alternatives)
    return Report(document, exhibit, files, picture_name="match.png")


def correspondence_csv(result: MatchResult) -> str:
    """``part_vertex,full_face,b0,b1,b2,full_vertex,matched,confidence``, from 0, a row each."""
    points = result.points
    return table_csv(
        {
            "part_vertex": np.arange(len(points)),
            "full_face": points.faces,
            **{f"b{k}": points.barycentric[:, k] for k in range(3)},
            "full_vertex": result.nearest_vertices,
            "matched": result.matched,
            "confidence": result.confidence,
        }
    )


def _document(result: MatchResult, command: str, errors: Floats | None) -> dict[str, Any]:
    scores = {
        "best": result.best.score,
        "other": result.second_score,
        "mirrored twin": result.twin_score,
    }
    document = {
        **common_facts(result, file_format=MATCH_FORMAT, command=command),
        "status": result.status.name.lower(),
        "advice": result.advice,
        "chance": result.chance,
        "scale": result.scale,
        "area_fraction": result.part.area * result.scale**2 / result.full.area,
        "unmatched": int((~result.matched).sum()),
        "mean_confidence": float(result.confidence.mean()),
        "unfollowed_landmarks": [asdict(each) for each in result.unfollowed_landmarks],
        "min_confidence": result.min_confidence,
        "scores": {name: score for name, score in scores.items() if score is not None},
        "alternatives": alternative_facts(result),
    }
    if errors is not None:
        document["ground_truth"] = {
            "mean_error_x100": 100 * float(errors.mean()),
            "median_error_x100": 100 * float(np.median(errors)),
            "share_below_0.05": float((errors < 0.05).mean()),
        }
    return document


def _exhibit(result: MatchResult, document: Mapping[str, Any], errors: Floats | None) -> Exhibit:
    """The match as something to look at."""
    truth = {"Ground truth": document["ground_truth"]} if "ground_truth" in document else {}
    return Exhibit(
        title=f"{result.part.name} on {result.full.name}",
        full=result.full,
        part=result.part,
        full_layers=_full_layers(result),
        part_layers=_part_layers(result, errors),
        partner=_partner(result),
        anchors=_anchors(result),
        score=result.best.score,
        score_name="similarity of neighborhoods minus strain, 1 is best",
        alternatives=tuple(_alternative(result, other, errors) for other in result.alternatives),
        verdict=Verdict.from_advice(result.advice, trusted=result.status is Status.GOOD),
        summary=_sentences(result, document),
        facts=facts_of(
            document,
            ("status", "advice", "chance", "scale", "area_fraction", "unmatched"),
            **truth,
            Scores=document["scores"],
        ),
        command=str(document["command"]),
        landmarks=result.options.landmarks,
        takes_hints=True,
        ignored=tuple(result.options.ignore),
        region=result.best.mask,
    )


def _alternative(result: MatchResult, other: Placement, errors: Floats | None) -> Alternative:
    """An alternative; what was found for the best map only is unknown for this one."""
    unknown = np.full(result.part.vertex_count, np.nan)
    undecided = np.full(result.part.vertex_count, -1)
    if other.points is None:
        points, bent = result.points, result.distortion
    else:
        points, bent = other.points, result.distortion_by(other.points)
    return Alternative(
        name=other.name,
        score=other.score,
        description="What a mirror image of the part would match."
        if other.mirrored
        else "Another placement.",
        full_layers=(
            known_layer("region", other.mask),
            known_layer("membership", other.membership),
        ),
        partner=Partner(points),
        region=other.mask,
        part_layers=(
            known_layer("confidence", unknown),
            Layer("matched", undecided, "category", description="Not decided for this placement."),
            *_map_layers(result.part, bent),
            *(() if errors is None else (error_layer(unknown),)),
        ),
    )


def _partner(result: MatchResult) -> Partner:
    return Partner(result.points, result.matched, result.confidence)


def _full_layers(result: MatchResult) -> tuple[Layer, ...]:
    return (
        correspondence_layer(result.full),
        known_layer("region", result.best.mask),
        known_layer("membership", result.best.membership),
        *file_layers(result.full.fields, carried=True),
    )


def _part_layers(result: MatchResult, errors: Floats | None) -> tuple[Layer, ...]:
    return (
        known_layer("confidence", result.confidence),
        known_layer("matched", result.matched),
        *_map_layers(result.part, result.distortion),
        *(() if errors is None else (error_layer(errors),)),
        *file_layers(result.part.fields),
    )


def _map_layers(part: TriangleMesh, bent: Distortion) -> tuple[Layer, Layer]:
    """Mean log stretch of the edges and share of unturned faces at each part vertex."""
    count, preserved = part.vertex_count, bent.preserved.astype(np.float64)
    return (
        known_layer("distortion", mean_at_vertices(bent.stretch, part.edges, count)),
        known_layer("orientation", mean_at_vertices(preserved, part.faces, count)),
    )


def _anchors(result: MatchResult) -> Ints:
    """Pairs of the surest vertices, spread over the part: part vertex, full vertex."""
    sure = np.argsort(-result.confidence, kind="stable")
    sure = sure[result.matched[sure]]
    half = sure[: max(ANCHOR_COUNT, len(sure) // 2)]
    chosen = half[np.linspace(0, len(half) - 1, min(ANCHOR_COUNT, len(half))).astype(int)]
    nearest = result.nearest_vertices[chosen]
    return np.column_stack([chosen, nearest]) if len(chosen) else np.empty((0, 2), dtype=np.int64)


def _sentences(result: MatchResult, document: Mapping[str, Any]) -> tuple[str, ...]:
    count = result.part.vertex_count
    said = [
        f"The part is {100 * document['area_fraction']:.0f} % of the full shape; "
        f"{document['unmatched']:,} of {count:,} vertices are unmatched.",
        f"An answer is within 0.05 sqrt(area) of the truth with a chance of "
        f"{100 * document['mean_confidence']:.0f} % on average.",
    ]
    if result.min_confidence > 0:
        said.append(
            f"Vertices with a confidence below {result.min_confidence:g} count as unmatched."
        )
    if result.scale != 1.0 or result.options.scale == "unknown":
        said.append(f"Lengths of the part were multiplied by {result.scale:.4g} to fit.")
    said += [*decimation_sentences(result), *alternative_sentences(result)]
    if "ground_truth" in document:
        mean = document["ground_truth"]["mean_error_x100"]
        length = mean / 100 * np.sqrt(result.full.area)
        said.append(
            f"Mean error against the ground truth: {mean:.2f} % of sqrt(area), "
            f"{length:.3g} in the units of the full shape's file."
        )
    return (*said, *notice_sentences(result))
