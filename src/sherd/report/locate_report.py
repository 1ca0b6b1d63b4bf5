"""The report of `sherd locate`: tables, page and picture of a LocateResult."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from typing import Any

from sherd.drawing.exhibit import Alternative, Exhibit, Layer, Verdict
from sherd.files.encode import encoded
from sherd.report.files import painted_ply
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
from sherd.report.known_layers import file_layers, known_layer, located_part_layers
from sherd.report.stored.folder import REGION_FORMAT
from sherd.results.locate_result import LocateResult
from sherd.results.placement import Placement
from sherd.results.status import Status

__all__ = ["locate_report"]


def locate_report(result: LocateResult, *, command: str = "") -> Report:
    """All that is written of a located region."""
    document = _document(result, command)
    exhibit = _exhibit(result, document)
    files: dict[str, Content] = {
        "region.csv": partial(region_csv, result.best),
        "region.ply": partial(painted_ply, result.full, exhibit.full_layers),
        "part.ply": partial(encoded, result.part, ".ply"),
    }
    return Report(document, exhibit, files, picture_name="region.png")


def _document(result: LocateResult, command: str) -> dict[str, Any]:
    return {
        **common_facts(result, file_format=REGION_FORMAT, command=command),
        "status": status_of(result),
        "advice": result.advice,
        "chance": result.chance,
        "area_fraction": result.area_fraction,
        "score": result.score,
        "alternatives": alternative_facts(result),
        "energy": {**asdict(result.energy), "total": result.energy.total},
    }


def status_of(result: LocateResult) -> str:
    """Why the solver stopped, or that the part may not belong here."""
    belongs = result.doubts.status
    name = result.convergence.name if belongs is Status.GOOD else belongs.name
    return name.lower().replace("_", "-")


def _exhibit(result: LocateResult, document: Mapping[str, Any]) -> Exhibit:
    """The region as something to look at."""
    return Exhibit(
        title=f"{result.part.name} on {result.full.name}",
        full=result.full,
        part=result.part,
        full_layers=_layers(result),
        part_layers=(*located_part_layers(result.part), *file_layers(result.part.fields)),
        score=result.score,
        score_name="mean similarity of neighborhoods, 1 is best",
        alternatives=tuple(_alternative(other) for other in result.alternatives),
        verdict=Verdict.from_advice(result.advice, trusted=result.trusted),
        summary=_sentences(result),
        facts=facts_of(
            document,
            ("status", "chance", "area_fraction", "score", "advice"),
            Energy=document["energy"],
        ),
        command=str(document["command"]),
        region=result.mask,
    )


def _layers(result: LocateResult) -> tuple[Layer, ...]:
    return (
        known_layer("membership", result.membership),
        known_layer("region", result.mask),
        known_layer("phase field", result.phase_field),
        *file_layers(result.full.fields),
    )


def _alternative(other: Placement) -> Alternative:
    return Alternative(
        name=other.name,
        score=other.score,
        description="The place that a mirror image of the part would fit."
        if other.mirrored
        else "The best place outside the region shown first.",
        full_layers=(
            known_layer("membership", other.membership),
            known_layer("region", other.mask),
        ),
    )


def _sentences(result: LocateResult) -> tuple[str, ...]:
    pieces = result.check().piece_count
    place = "one piece" if pieces == 1 else f"{pieces} pieces"
    said = [
        f"The part is {100 * result.area_fraction:.0f} % of the full shape and lies in {place} "
        "of it.",
        f"Its neighborhoods resemble those of its place by {result.score:.2f} of 1.",
        *decimation_sentences(result),
        *alternative_sentences(result),
    ]
    return (*said, *notice_sentences(result))
