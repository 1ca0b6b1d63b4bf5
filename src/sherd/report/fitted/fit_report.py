"""The report of `sherd fit`: tables, meshes, page and picture of a Fit."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np

from sherd.arrays import Floats
from sherd.drawing.camera import upward
from sherd.drawing.colors import correspondence_layer, full_layer
from sherd.drawing.exhibit import Exhibit, Layer, Partner, Verdict
from sherd.files.encode import encoded
from sherd.files.obj_texture import moved_obj
from sherd.mesh.geometry import closest_rotation
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.files import painted_ply, table_csv
from sherd.report.fitted.morph import morph_glb
from sherd.report.frame import Content, Report, mesh_facts
from sherd.report.known_layers import file_layers, known_layer
from sherd.report.stored.folder import FIT_FORMAT
from sherd.results.fitted.completion import FITTED, Completion
from sherd.results.fitted.fit_result import Fit, FittedPiece
from sherd.results.status import Status

__all__ = ["completion_words", "fit_report", "fitted_exhibit"]

# So many of the hidden regions are said in words.
NAMED = 4
# What is less larger or smaller is not worth a sentence.
LEAST_SIZE = 0.005


def fit_report(
    result: Fit, *, command: str = "", texture: str | os.PathLike[str] | None = None
) -> Report:
    """All that is written of a fit, its OBJ file textured as the file `texture` is."""
    document = _document(result, command)
    exhibit = fitted_exhibit(result, document)
    colors = full_layer(exhibit, "correspondence") or exhibit.full_layers[0]
    files: dict[str, Content] = {
        "fit.ply": partial(painted_ply, result.mesh, exhibit.full_layers, painted=colors),
        "fit.obj": partial(_obj, result, texture),
        "fit.glb": partial(morph_glb, result.full, result.positions, colors),
        "fit.csv": partial(_vertices_csv, result),
        "full.ply": partial(painted_ply, result.full, file_layers(result.full.fields)),
    }
    for number, piece in enumerate(result.pieces):
        files[f"piece_{number}/part.ply"] = partial(painted_ply, piece.part, _piece_layers([piece]))
        files[f"piece_{number}/distances.csv"] = partial(_distances_csv, piece)
    done = result.completion
    if done is not None:
        files["completed.ply"] = partial(encoded, done.mesh, ".ply", fields={"origin": done.origin})
    return Report(document, exhibit, files, picture_name="fit.png")


def _obj(result: Fit, texture: str | os.PathLike[str] | None) -> bytes:
    if texture is not None:
        return moved_obj(texture, result.positions)
    return encoded(TriangleMesh(result.positions, result.full.faces), ".obj")


def fitted_exhibit(result: Fit, document: Mapping[str, Any]) -> Exhibit:
    """The fit beside what it was fitted to, both in the same place and pose."""
    parts = _together(result.pieces)
    counts = np.cumsum([0, *(piece.part.vertex_count for piece in result.pieces[:-1])])
    return Exhibit(
        title=f"{result.full.name} fitted to {parts.name}",
        full=result.mesh.with_vertices(result.positions),
        part=parts,
        full_layers=_fit_layers(result),
        part_layers=_piece_layers(result.pieces),
        partner=Partner(
            SurfacePoints(
                np.concatenate([piece.points.faces for piece in result.pieces]),
                np.concatenate([piece.points.barycentric for piece in result.pieces]),
            ),
            np.concatenate([piece.matched for piece in result.pieces]),
        ),
        verdict=Verdict.from_advice(result.advice, trusted=result.status is Status.GOOD),
        summary=_sentences(result),
        facts={
            "Result": {key: document[key] for key in ("status", "advice", "seen_share", "version")},
            "Scan to fit": document["scan_to_fit"],
            "Fit to scan": document["fit_to_scan"],
            "Check": document["check"],
            "Options": document["options"],
            "Seconds": document["timings"],
        },
        command=str(document["command"]),
        region=np.ones(result.full.vertex_count, dtype=bool),
        names=("Fit", "Scan" if len(result.pieces) == 1 else "Scans"),
        part_stands=True,
        full_before=_brought_near(result),
        up=_up(result),
        overlaid=True,
        part_numbers=np.arange(parts.vertex_count)
        - np.repeat(counts, [piece.part.vertex_count for piece in result.pieces]),
    )


def _turn(result: Fit) -> Floats:
    """The rotation (3, 3) that brings the full shape as a whole to where the fit is."""
    full = result.full
    return closest_rotation(full.vertices, result.positions, full.vertex_areas)


def _up(result: Fit) -> tuple[float, float, float]:
    """What is up for the full shape as it was given, turned with it: a scan may lie anyhow."""
    x, y, z = (_turn(result) @ upward(result.full)).tolist()
    return x, y, z


def _brought_near(result: Fit) -> Floats:
    """The full shape as it was given (n, 3), moved and sized as a whole to where the fit is."""
    full, areas, turn = result.full, result.full.vertex_areas, _turn(result)
    center = np.average(full.vertices, axis=0, weights=areas)
    there = np.average(result.positions, axis=0, weights=areas)
    near: Floats = (full.vertices - center) @ turn.T / result.pieces[0].scale + there
    return near


def _document(result: Fit, command: str) -> dict[str, Any]:
    done = result.completion
    return {
        "format": FIT_FORMAT,
        "version": result.version,
        "command": command,
        "full": mesh_facts(result.full, result.notices),
        "status": result.status.name.lower(),
        "advice": result.advice,
        "seen_share": result.seen_share,
        "scan_to_fit": asdict(result.scan_summary),
        "fit_to_scan": asdict(result.fit_summary),
        "mean_strain_seen": _mean(result.strain[result.seen]),
        "size": [float(result.sizes.min()), float(result.sizes.max())],
        "hidden": [asdict(region) for region in result.hidden],
        "near": result.options.near * result.unit,
        "pieces": [
            {
                **mesh_facts(piece.part, ()),
                "scale": piece.scale,
                "unmatched": int((~piece.matched).sum()),
                "distances": asdict(piece.summary),
                "file": f"piece_{number}/distances.csv",
            }
            for number, piece in enumerate(result.pieces)
        ],
        "completion": None if done is None else _completion_facts(done),
        "check": asdict(result.check),
        "options": asdict(result.options),
        "timings": dict(result.timings),
    }


def _completion_facts(done: Completion) -> dict[str, Any]:
    return {
        "vertices": done.mesh.vertex_count,
        "faces": done.mesh.face_count,
        "from_scan": float((done.origin != FITTED).mean()),
        "watertight": done.watertight,
        "stitched": done.stitched,
        "reason": done.reason,
    }


def completion_words(done: Completion) -> str:
    """How the scan was completed, in a part of a sentence."""
    closed = "watertight" if done.watertight else "not watertight"
    why = f" ({done.reason})" if done.reason else ""
    if done.stitched:
        return f"the scan with the fit stitched to it, {closed}{why}"
    return f"the fit moved onto the scan, {closed}, not the scan itself: {done.reason}"


def _mean(values: Floats) -> float:
    return float(values.mean()) if len(values) else float("nan")


def _fit_layers(result: Fit) -> tuple[Layer, ...]:
    reach = _range([result.distances, *(piece.distances for piece in result.pieces)])
    correspondence = correspondence_layer(result.full)
    return (
        correspondence,
        Layer(
            "distance",
            result.distances,
            range=reach,
            color_map="ember",
            description="To the scan, in the unit of its file; gray where nothing was seen.",
        ),
        known_layer("seen", result.seen),
        known_layer("chance", result.chance),
        known_layer("strain", result.strain),
        known_layer("size", result.sizes),
        *file_layers(result.full.fields, carried=True),
    )


def _piece_layers(pieces: Sequence[FittedPiece]) -> tuple[Layer, ...]:
    distances = np.concatenate([piece.distances for piece in pieces])
    matched = np.concatenate([piece.matched for piece in pieces])
    return (
        Layer(
            "distance",
            distances,
            range=_range([np.where(matched, distances, np.nan)]),
            color_map="ember",
            description="To the fit, in the unit of the file.",
        ),
        known_layer("matched", matched),
        *(file_layers(pieces[0].part.fields) if len(pieces) == 1 else ()),
    )


def _range(distances: Sequence[Floats]) -> tuple[float, float]:
    """From 0 to what 95 % of the matched are below: clutter does not set the scale."""
    known = np.concatenate([values[np.isfinite(values)] for values in distances])
    top = float(np.quantile(known, 0.95)) if len(known) else 1.0
    return 0.0, max(top, 1e-12)


def _together(pieces: Sequence[FittedPiece]) -> TriangleMesh:
    if len(pieces) == 1:
        return pieces[0].part
    starts = np.cumsum([0, *(piece.part.vertex_count for piece in pieces[:-1])])
    return TriangleMesh(
        np.concatenate([piece.part.vertices for piece in pieces]),
        np.concatenate(
            [piece.part.faces + start for piece, start in zip(pieces, starts, strict=True)]
        ),
        name=", ".join(piece.part.name for piece in pieces),
    )


def _vertices_csv(result: Fit) -> str:
    """``vertex,x,y,z,seen,chance,distance,strain,size``, a row for each vertex, from 0."""
    return table_csv(
        {
            "vertex": np.arange(len(result.positions)),
            **{axis: result.positions[:, k] for k, axis in enumerate("xyz")},
            "seen": result.seen,
            "chance": result.chance,
            "distance": result.distances,
            "strain": result.strain,
            "size": result.sizes,
        }
    )


def _distances_csv(piece: FittedPiece) -> str:
    """``part_vertex,distance,matched,face,b0,b1,b2``: the closest point of the fit, from 0."""
    return table_csv(
        {
            "part_vertex": np.arange(len(piece.distances)),
            "distance": piece.distances,
            "matched": piece.matched,
            "face": piece.points.faces,
            **{f"b{k}": piece.points.barycentric[:, k] for k in range(3)},
        }
    )


def _sentences(result: Fit) -> tuple[str, ...]:
    scan, back = result.scan_summary, result.fit_summary
    said = [
        f"{result.seen_share:.0%} of the full shape was seen; scan and fit are {scan.mean:.3g} "
        f"apart on average, {scan.mean_in_edges:.2f} edges of the scan, and less than "
        f"{scan.most:.3g} at 95 % of its vertices.",
        f"From the fit back to the scan it is {back.mean:.3g} on average, {back.largest:.3g} at "
        "most.",
    ]
    scale = result.pieces[0].scale
    beside = "" if scale == 1 else ", beside the scale of the match"
    if scale != 1:
        said.append(f"Lengths of the scan were multiplied by {scale:.4g} to match.")
    if np.abs(result.sizes - 1).max() > LEAST_SIZE:
        said.append(
            f"The full shape was made {result.sizes.min():.2f} to {result.sizes.max():.2f} times "
            f"as large{beside}."
        )
    for region in result.hidden[:NAMED]:
        deepest = result.chance[region.vertex]
        said.append(
            f"{region.area:.1%} of the full shape, around vertex {region.vertex}, was never seen: "
            "its pose is unknown, and drawn as in the full shape; at its far end the chance to be "
            f"within {result.options.near * result.unit:.3g} is {deepest:.0%}."
        )
    if result.completion is not None:
        said.append(f"completed.ply is {completion_words(result.completion)}.")
    if result.check.new_intersections:
        said.append(
            f"{result.check.new_intersections} faces pierce others that do not in the full shape."
        )
    return (*said, *(f"Full shape: {text}" for text in result.notices))
