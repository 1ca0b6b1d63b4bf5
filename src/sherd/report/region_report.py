"""The output folder of `sherd locate`: result.json, CSV, PLY, PNG and HTML of a Region."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from sherd.files.encode import encoded
from sherd.output import ResultFolder
from sherd.region.region import Placement as RegionPlacement
from sherd.region.region import Region
from sherd.report.exhibit import Exhibit, Layer, Placement
from sherd.report.exports import exported
from sherd.report.files import painted_ply, table_csv
from sherd.report.folder import plain
from sherd.report.html import page
from sherd.report.known_layers import file_layers, known_layer, located_part_layers
from sherd.report.mesh_facts import mesh_facts
from sherd.report.picture import picture, png_bytes

__all__ = ["region_csv", "region_exhibit", "region_result", "write_region_report"]

# A twin whose score comes this near to the best deserves the reader's attention: repeated runs
# on remeshed copies of one pair differ by about as much.
CLOSE_SCORE = 0.02


def write_region_report(
    region: Region,
    folder: str | os.PathLike[str],
    *,
    command: str = "",
    notices: Mapping[str, tuple[str, ...]] | None = None,
    exports: tuple[str, ...] = (),
) -> dict[str, Any]:
    """Write all files of a located region; docs/files.md describes them.

    Parameters
    ----------
    region
        Numbered as the user's files are.
    folder
        Made when missing; files of the same names are replaced.
    command
        What to type to get the same again, shown in the report.
    notices
        What was adapted while reading, by "full" and "part".
    exports
        Further files, of :data:`sherd.report.exports.SHAPE_EXPORTS`.

    Returns
    -------
    dict
        The content of ``result.json``.

    Raises
    ------
    OptionError
        If an export is unknown.
    OutputError
        If something cannot be written; see :class:`sherd.output.ResultFolder`.
    """
    exhibit = region_exhibit(region, command=command, notices=notices)
    with ResultFolder(folder) as output:
        output.add("region.csv", region_csv(region))
        output.add("region.ply", painted_ply(region.full, exhibit.full_layers))
        output.add("part.ply", encoded(region.part, ".ply"))
        output.add("region.png", png_bytes(picture(exhibit)))
        output.add("report.html", page(exhibit))
        for name, content in exported(exhibit, exports).items():
            output.add(name, content)
        return output.finish(plain(region_result(region, command=command, notices=notices)))


def region_csv(region: Region) -> str:
    """``full_vertex,membership,in_region``, one row per vertex of the full shape, from 0."""
    return table_csv(
        {
            "full_vertex": np.arange(region.full.vertex_count),
            "membership": region.membership,
            "in_region": region.mask,
        }
    )


def region_result(
    region: Region,
    *,
    command: str = "",
    notices: Mapping[str, tuple[str, ...]] | None = None,
) -> dict[str, Any]:
    """The content of ``result.json`` but for the hashes: plain numbers, strings and lists."""
    said = notices or {}
    return {
        "format": "sherd region 1",
        "version": region.version,
        "command": command,
        "full": mesh_facts(region.full, said.get("full", ())),
        "part": mesh_facts(region.part, said.get("part", ())),
        "status": region.status.name.lower().replace("_", "-"),
        "advice": region.status.advice,
        "area_fraction": region.area_fraction,
        "score": region.score,
        "alternatives": [
            {
                "name": other.name,
                "score": other.score,
                "mirrored": other.mirrored,
                "overlap": _overlap(region, other),
            }
            for other in region.alternatives
        ],
        "energy": {**asdict(region.energy), "total": region.energy.total},
        "check": asdict(region.check()),
        "working_vertices": dict(region.working_vertices),
        "options": asdict(region.options),
        "seed": region.options.seed,
        "timings": dict(region.timings),
    }


def region_exhibit(
    region: Region,
    *,
    command: str = "",
    notices: Mapping[str, tuple[str, ...]] | None = None,
) -> Exhibit:
    """The region as something to look at."""
    result = region_result(region, command=command, notices=notices)
    facts = {
        "Result": {
            key: result[key] for key in ("status", "area_fraction", "score", "advice", "version")
        },
        "Full shape": result["full"],
        "Part": result["part"],
        "Check": result["check"],
        "Energy": result["energy"],
        "Options": result["options"],
        "Seconds": result["timings"],
    }
    return Exhibit(
        title=f"{region.part.name} on {region.full.name}",
        full=region.full,
        part=region.part,
        full_layers=_layers(region),
        part_layers=(*located_part_layers(region.part), *file_layers(region.part.fields)),
        score=region.score,
        score_name="mean similarity of neighborhoods, 1 is best",
        alternatives=tuple(_placement(other) for other in region.alternatives),
        summary=_sentences(region, notices or {}),
        facts=facts,
        command=command,
        region=region.mask,
    )


def _layers(region: Region) -> tuple[Layer, ...]:
    return (
        known_layer("membership", region.membership),
        known_layer("region", region.mask),
        known_layer("phase field", region.phase_field),
        *file_layers(region.full.fields),
    )


def _placement(other: RegionPlacement) -> Placement:
    described = {
        "mirrored twin": "The place that a mirror image of the part would fit.",
        "elsewhere": "The best place outside the region shown first.",
    }
    return Placement(
        name=other.name,
        score=other.score,
        description=described.get(other.name, ""),
        full_layers=(
            known_layer("membership", other.membership),
            known_layer("region", other.mask),
        ),
    )


def _sentences(region: Region, notices: Mapping[str, tuple[str, ...]]) -> tuple[str, ...]:
    percent = 100 * region.area_fraction
    pieces = region.check().piece_count
    place = "one piece" if pieces == 1 else f"{pieces} pieces"
    said = [
        f"The part is {percent:.0f} % of the full shape and lies in {place} of it.",
        f"Its neighborhoods resemble those of its place by {region.score:.2f} of 1.",
    ]
    for other in region.alternatives:
        gap = region.score - other.score
        close = "equally well" if gap < CLOSE_SCORE else f"with a score lower by {gap:.2f}"
        who = (
            "A mirror image of the part would fit"
            if other.mirrored
            else "The best place outside the region fits"
        )
        said.append(f"{who} {close} ({other.name}, in the list of alternatives).")
    if not region.status.succeeded:
        said.append(f"The solver {region.status.advice}.")
    said += [f"{which} shape: {text}" for which, texts in notices.items() for text in texts]
    return tuple(said)


def _overlap(region: Region, other: RegionPlacement) -> float:
    areas = region.full.vertex_areas
    union = float(areas[region.mask | other.mask].sum())
    shared = float(areas[region.mask & other.mask].sum())
    return shared / union if union > 0 else math.nan
