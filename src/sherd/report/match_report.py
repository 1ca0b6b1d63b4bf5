"""The output folder of `sherd match`: result.json, CSV, PLY, PNG and HTML of a MatchResult."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.match import Alternative, MatchCheck, MatchResult
from sherd.mesh.surface_points import SurfacePoints
from sherd.output import ResultFolder
from sherd.report.colors import correspondence_layer, part_layer
from sherd.report.exhibit import Exhibit, Layer, Partner, Placement
from sherd.report.exports import exported
from sherd.report.files import corr_text, painted_ply, table_csv
from sherd.report.folder import plain
from sherd.report.html import page
from sherd.report.known_layers import error_layer, file_layers, known_layer
from sherd.report.mesh_facts import mesh_facts
from sherd.report.picture import picture, png_bytes

__all__ = [
    "correspondence_csv",
    "match_exhibit",
    "match_result",
    "write_match_report",
]


# So many pairs of the surest points are drawn as lines: enough to follow, few enough to see.
ANCHOR_COUNT = 60
# A score this near to the best deserves the reader's attention.
CLOSE_SCORE = 0.02


def write_match_report(
    result: MatchResult,
    folder: str | os.PathLike[str],
    *,
    command: str = "",
    notices: Mapping[str, tuple[str, ...]] | None = None,
    errors: Floats | None = None,
    check: MatchCheck | None = None,
    exports: tuple[str, ...] = (),
) -> dict[str, Any]:
    """Write all files of a match; docs/files.md describes them.

    Parameters
    ----------
    result
        Numbered as the user's files are.
    folder
        Made when missing; files of the same names are replaced.
    command
        What to type to get the same again, shown in the report.
    notices
        What was adapted while reading, by "full" and "part".
    errors
        (n_part,) error of each vertex in sqrt(area of the full shape), where the truth is known.
    check
        ``result.check()`` on the repaired meshes, where the files' own faces may be turned over.
    exports
        Further files, of :data:`sherd.report.exports.SHAPE_EXPORTS` and ``MAP_EXPORTS``.

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
    document = match_result(result, command=command, notices=notices, errors=errors, check=check)
    exhibit = match_exhibit(result, document, errors=errors)
    colors = exhibit.full_layers[0]
    carried = part_layer(exhibit, colors.name) or colors
    with ResultFolder(folder) as output:
        output.add("correspondence.csv", correspondence_csv(result))
        output.add("correspondence.corr", corr_text(_partner(result)))
        output.add("region.csv", _region_csv(result))
        output.add("full.ply", painted_ply(result.full, exhibit.full_layers, painted=colors))
        output.add("part.ply", painted_ply(result.part, exhibit.part_layers, painted=carried))
        output.add("match.png", png_bytes(picture(exhibit)))
        output.add("report.html", page(exhibit))
        for name, content in exported(exhibit, exports).items():
            output.add(name, content)
        return output.finish(plain(document))


def correspondence_csv(result: MatchResult) -> str:
    """``part_vertex,full_face,b0,b1,b2,full_vertex,matched,confidence``, from 0, a row each."""
    points, weights = result.point_map.points, result.point_map.barycentric
    return table_csv(
        {
            "part_vertex": np.arange(len(points)),
            "full_face": points.faces,
            "b0": weights[:, 0],
            "b1": weights[:, 1],
            "b2": weights[:, 2],
            "full_vertex": points.nearest_vertices(result.full),
            "matched": result.point_map.matched,
            "confidence": result.point_map.confidence,
        }
    )


def match_result(
    result: MatchResult,
    *,
    command: str = "",
    notices: Mapping[str, tuple[str, ...]] | None = None,
    errors: Floats | None = None,
    check: MatchCheck | None = None,
) -> dict[str, Any]:
    """The content of ``result.json`` but for the hashes: plain numbers, strings and lists."""
    said = notices or {}
    matched = result.point_map.matched
    document = {
        "format": "sherd match 1",
        "version": result.version,
        "command": command,
        "full": mesh_facts(result.full, said.get("full", ())),
        "part": mesh_facts(result.part, said.get("part", ())),
        "status": result.status.name.lower(),
        "advice": result.status.advice,
        "scale": result.scale,
        "area_fraction": result.part.area * result.scale**2 / result.full.area,
        "unmatched": int((~matched).sum()),
        "mean_confidence": float(result.point_map.confidence.mean()),
        "scores": dict(result.scores),
        "alternatives": [
            {"name": other.name, "score": other.score, "mirrored": other.mirrored}
            for other in result.alternatives
        ],
        "check": asdict(check or result.check()),
        "options": asdict(result.options),
        "seed": result.options.seed,
        "working_vertices": dict(result.working_vertices),
        "timings": dict(result.timings),
    }
    if errors is not None:
        document["ground_truth"] = {
            "mean_error_x100": 100 * float(errors.mean()),
            "median_error_x100": 100 * float(np.median(errors)),
            "share_below_0.05": float((errors < 0.05).mean()),
        }
    return document


def match_exhibit(
    result: MatchResult, document: Mapping[str, Any], *, errors: Floats | None = None
) -> Exhibit:
    """The match as something to look at; `document` from :func:`match_result`."""
    facts = {
        "Result": {
            key: document[key]
            for key in ("status", "advice", "scale", "area_fraction", "unmatched", "version")
        },
        **({"Ground truth": document["ground_truth"]} if "ground_truth" in document else {}),
        "Scores": document["scores"],
        "Full shape": document["full"],
        "Part": document["part"],
        "Check": document["check"],
        "Options": document["options"],
        "Seconds": document["timings"],
    }
    return Exhibit(
        title=f"{result.part.name} on {result.full.name}",
        full=result.full,
        part=result.part,
        full_layers=_full_layers(result),
        part_layers=_part_layers(result, errors),
        partner=_partner(result),
        anchors=_anchors(result),
        score=result.scores["best"],
        score_name="similarity of neighborhoods minus strain, 1 is best",
        alternatives=tuple(_placement(result, other, errors) for other in result.alternatives),
        summary=_sentences(result, document),
        facts=facts,
        command=str(document["command"]),
        region=result.region.mask,
    )


def _placement(result: MatchResult, other: Alternative, errors: Floats | None) -> Placement:
    """An alternative; what was found for the best map only is unknown for this one."""
    unknown = np.full(result.part.vertex_count, np.nan)
    undecided = np.full(result.part.vertex_count, -1)
    return Placement(
        name=other.name,
        score=other.score,
        description="What a mirror image of the part would match."
        if other.mirrored
        else "Another placement.",
        full_layers=(
            known_layer("region", other.mask),
            known_layer("membership", other.mask),
        ),
        partner=Partner(other.points),
        part_layers=(
            known_layer("confidence", unknown),
            Layer("matched", undecided, "category", description="Not decided for this placement."),
            known_layer("distortion", _distortion(result, other.points)),
            known_layer("orientation", _orientation(result, other.points)),
            *(() if errors is None else (error_layer(unknown),)),
        ),
    )


def _partner(result: MatchResult) -> Partner:
    point_map = result.point_map
    return Partner(point_map.points, point_map.matched, point_map.confidence)


def _full_layers(result: MatchResult) -> tuple[Layer, ...]:
    return (
        correspondence_layer(result.full),
        known_layer("region", result.region.mask),
        known_layer("membership", result.region.membership),
        *file_layers(result.full.fields, carried=True),
    )


def _part_layers(result: MatchResult, errors: Floats | None) -> tuple[Layer, ...]:
    return (
        known_layer("confidence", result.point_map.confidence),
        known_layer("matched", result.point_map.matched),
        known_layer("distortion", _distortion(result, result.point_map.points)),
        known_layer("orientation", _orientation(result, result.point_map.points)),
        *(() if errors is None else (error_layer(errors),)),
        *file_layers(result.part.fields),
    )


def _distortion(result: MatchResult, points: SurfacePoints) -> Floats:
    """Mean log stretch of the edges at each part vertex, (n_part,); NaN at lonely vertices."""
    edges, image = result.part.edges, points.positions(result.full)
    before = np.linalg.norm(np.diff(result.part.vertices[edges], axis=1)[:, 0], axis=1)
    after = np.linalg.norm(np.diff(image[edges], axis=1)[:, 0], axis=1)
    tiny = 1e-9 * result.full.length
    stretch = np.log(np.maximum(after, tiny) / np.maximum(before * result.scale, tiny))
    count = result.part.vertex_count
    total = np.bincount(edges.ravel(), np.repeat(stretch, 2), count)
    degree = np.bincount(edges.ravel(), minlength=count)
    mean: Floats = np.divide(total, degree, out=np.full(count, np.nan), where=degree > 0)
    return mean


def _orientation(result: MatchResult, points: SurfacePoints) -> Floats:
    """Share of the faces at each part vertex that the map does not turn over, (n_part,).

    A face is turned over if its image runs the other way around than the full shape there, as in
    :meth:`sherd.match.MatchResult.check`. NaN at lonely vertices.
    """
    faces = result.part.faces
    corners = points.positions(result.full)[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outward = points.interpolate(result.full, result.full.vertex_normals)[faces].sum(axis=1)
    kept = (normals * outward).sum(axis=1) > 0
    count = result.part.vertex_count
    total = np.bincount(faces.ravel(), np.repeat(kept, 3), count)
    degree = np.bincount(faces.ravel(), minlength=count)
    share: Floats = np.divide(total, degree, out=np.full(count, np.nan), where=degree > 0)
    return share


def _anchors(result: MatchResult) -> Ints:
    """Pairs of the surest vertices, spread over the part: part vertex, full vertex."""
    sure = np.argsort(-result.point_map.confidence, kind="stable")
    sure = sure[result.point_map.matched[sure]]
    half = sure[: max(ANCHOR_COUNT, len(sure) // 2)]
    chosen = half[np.linspace(0, len(half) - 1, min(ANCHOR_COUNT, len(half))).astype(int)]
    nearest = result.point_map.points[chosen].nearest_vertices(result.full)
    return np.column_stack([chosen, nearest]) if len(chosen) else np.empty((0, 2), dtype=np.int64)


def _sentences(result: MatchResult, document: Mapping[str, Any]) -> tuple[str, ...]:
    count = result.part.vertex_count
    said = [
        f"The part is {100 * document['area_fraction']:.0f} % of the full shape; "
        f"{document['unmatched']:,} of {count:,} vertices are unmatched.",
        f"An answer is within 0.05 sqrt(area) of the truth with a chance of "
        f"{100 * document['mean_confidence']:.0f} % on average.",
    ]
    if result.options.scale == "unknown":
        said.append(f"The part was enlarged {result.scale:.3f} times to fit.")
    said += _decimations(result)
    for other in result.alternatives:
        gap = result.scores["best"] - other.score
        close = "equally well" if gap < CLOSE_SCORE else f"with a score lower by {gap:.2f}"
        who = "A mirror image of the part" if other.mirrored else "Another placement"
        said.append(f"{who} would fit {close} ({other.name}, in the list of alternatives).")
    said.append(f"The result is {result.status.advice}.")
    if "ground_truth" in document:
        mean = document["ground_truth"]["mean_error_x100"]
        said.append(f"Mean error against the ground truth: {mean:.2f} % of sqrt(area).")
    for which in ("full", "part"):
        said += [f"{which.capitalize()}: {text}" for text in document[which]["notices"]]
    return tuple(said)


def _decimations(result: MatchResult) -> list[str]:
    """What was searched on fewer vertices than the file has."""
    said = []
    for name, mesh in (("full shape", result.full), ("part", result.part)):
        worked = result.working_vertices.get(name.split()[0], mesh.vertex_count)
        if worked < mesh.vertex_count:
            said.append(
                f"The {name} was searched on {worked:,} of its {mesh.vertex_count:,} vertices; the "
                "answers were then carried to every vertex on the surface itself."
            )
    return said


def _region_csv(result: MatchResult) -> str:
    return table_csv(
        {
            "full_vertex": np.arange(result.full.vertex_count),
            "membership": result.region.membership,
            "in_region": result.region.mask,
        }
    )
