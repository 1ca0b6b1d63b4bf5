"""The report of `sherd assemble`: tables, page and picture of an Assembly."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from sherd.arrays import Floats
from sherd.drawing.exhibit import Exhibit, Layer, Partner, Verdict
from sherd.mesh.surface_points import SurfacePoints
from sherd.report.files import painted_ply, table_csv
from sherd.report.frame import Report, mesh_facts
from sherd.report.known_layers import known_layer
from sherd.report.match_report import correspondence_csv
from sherd.report.piece_colors import piece_palette
from sherd.report.piece_row import PieceRow, piece_row
from sherd.report.stored.folder import ASSEMBLY_FORMAT
from sherd.results.assembly import Assembly, PieceAnswer
from sherd.results.status import Status

__all__ = ["assembly_report", "piece_file"]

# So many of the gap's parts, of the contacts and of the shared places are said in words.
NAMED = 3


def piece_file(piece: int, name: str = "correspondence.csv") -> str:
    """Where a file of one piece lies in the folder.

    Examples
    --------
    >>> piece_file(2)
    'piece_2/correspondence.csv'
    """
    return f"piece_{piece}/{name}"


def assembly_report(result: Assembly, *, command: str = "") -> Report:
    """All that is written of an assembly."""
    document = _document(result, command)
    full_layers, row = _full_layers(result), piece_row(result.full, result.pieces)
    files: dict[str, str | bytes] = {
        "labels.csv": _labels_csv(result),
        "full.ply": painted_ply(result.full, full_layers),
    }
    for number, piece in enumerate(result.pieces):
        layers = _piece_layers(result, number, piece)
        files[piece_file(number, "part.ply")] = painted_ply(piece.part, layers)
        if piece.placed and piece.match is not None:
            files[piece_file(number)] = correspondence_csv(piece.match)
    exhibit = _exhibit(result, document, full_layers, row)
    return Report(document, exhibit, files, picture_name="assembly.png")


def _labels_csv(result: Assembly) -> str:
    """``full_vertex,piece,membership``, a row for each vertex of the full shape, from 0."""
    both = np.concatenate([result.memberships, result.gap_membership[None, :]])
    row = np.where(result.labels < 0, len(result.pieces), result.labels)
    count = len(result.labels)
    return table_csv(
        {
            "full_vertex": np.arange(count),
            "piece": result.labels,
            "membership": both[row, np.arange(count)],
        }
    )


def _document(result: Assembly, command: str) -> dict[str, Any]:
    return {
        "format": ASSEMBLY_FORMAT,
        "version": result.version,
        "command": command,
        "full": mesh_facts(result.full, result.notices),
        "status": _status(result).name.lower(),
        "pieces": [_piece_facts(k, piece) for k, piece in enumerate(result.pieces)],
        "gap": {
            "area": result.gap_area,
            "share": result.gap_share,
            "components": [asdict(gap) for gap in result.gaps],
        },
        "contacts": [asdict(contact) for contact in result.contacts],
        "shared": [asdict(place) for place in result.shared],
        "energy": result.energy,
        "check": asdict(result.check()),
        "options": asdict(result.options),
        "seed": result.options.seed,
        "timings": dict(result.timings),
    }


def _piece_facts(number: int, piece: PieceAnswer) -> dict[str, Any]:
    match = piece.match
    notices = () if match is None else match.notices.get("part", ())
    return {
        **mesh_facts(piece.part, notices),
        "placed": piece.placed,
        "reason": piece.reason,
        "chance": piece.chance,
        "file": piece_file(number) if piece.placed else None,
        "instead": piece.instead,
        "status": None if match is None else match.status.name.lower(),
        "score": None if match is None else match.best.score,
        "mean_confidence": None if match is None else float(match.confidence.mean()),
        "unmatched": None if match is None else int((~match.matched).sum()),
        "transform": None if piece.transform is None else piece.transform.tolist(),
    }


def _status(result: Assembly) -> Status:
    """Good if all that is placed is; refusals are answers."""
    known = [piece.match.status for piece in result.pieces if piece.placed and piece.match]
    return Status.GOOD if known and set(known) == {Status.GOOD} else Status.DOUBTFUL


def _names(result: Assembly) -> tuple[str, ...]:
    own = (f"{k} {piece.part.name}" for k, piece in enumerate(result.pieces))
    return (*own, "gap", "refused")


def _piece_layer(result: Assembly, values: Any) -> Layer:
    return Layer(
        "piece",
        values,
        kind="category",
        description="Which piece lies where; equal colors belong together.",
        labels=_names(result),
        palette=piece_palette(len(result.pieces)),
    )


def _full_layers(result: Assembly) -> tuple[Layer, ...]:
    gap = len(result.pieces)
    surest = np.max(result.memberships, axis=0, initial=0.0)
    return (
        _piece_layer(result, np.where(result.labels < 0, gap, result.labels)),
        known_layer("membership", np.where(result.labels < 0, result.gap_membership, surest)),
    )


def _color_number(result: Assembly, number: int) -> int:
    return number if result.pieces[number].placed else len(result.pieces) + 1


def _piece_layers(result: Assembly, number: int, piece: PieceAnswer) -> tuple[Layer, ...]:
    count = piece.part.vertex_count
    layers = [_piece_layer(result, np.full(count, _color_number(result, number)))]
    if piece.placed and piece.match is not None:
        layers.append(known_layer("confidence", piece.match.confidence))
        layers.append(known_layer("matched", piece.match.matched))
    return tuple(layers)


def _exhibit(
    result: Assembly, document: Mapping[str, Any], full_layers: tuple[Layer, ...], row: PieceRow
) -> Exhibit:
    colors = np.array([_color_number(result, k) for k in range(len(result.pieces))])
    partner, confidence = _partner(result)
    status = _status(result)
    words = "good: each placed piece fits" if status is Status.GOOD else _doubts(result)
    return Exhibit(
        title=f"{len(result.pieces)} pieces on {result.full.name}",
        full=result.full,
        part=row.mesh,
        full_layers=full_layers,
        part_layers=(
            _piece_layer(result, colors[row.owner]),
            known_layer("confidence", confidence),
        ),
        partner=partner,
        verdict=Verdict.from_advice(words, trusted=status is Status.GOOD),
        summary=_sentences(result),
        facts={
            "Pieces": {f"{k} {p.part.name}": _piece_words(p) for k, p in enumerate(result.pieces)},
            "Gap": {"area": result.gap_area, "share": result.gap_share, "parts": len(result.gaps)},
            "Borders": {
                f"{c.first} and {c.second}": f"length {c.length:.4g}, apart {c.apart:.2g}"
                for c in result.contacts
            },
            "Check": document["check"],
            "Options": document["options"],
            "Seconds": document["timings"],
        },
        command=str(document["command"]),
        region=np.ones(result.full.vertex_count, dtype=bool),
        names=("Full shape", "Pieces"),
        part_stands=True,
        part_numbers=row.numbers,
    )


def _partner(result: Assembly) -> tuple[Partner, Floats]:
    """The map of all pieces, one after the other, and its confidence."""
    faces, weights, known, sure = [], [], [], []
    for piece in result.pieces:
        count = piece.part.vertex_count
        match = piece.match if piece.placed else None
        if match is None:
            faces.append(np.zeros(count, dtype=np.int64))
            weights.append(np.tile([1.0, 0.0, 0.0], (count, 1)))
            known.append(np.zeros(count, dtype=bool))
            sure.append(np.full(count, np.nan))
        else:
            faces.append(match.points.faces)
            weights.append(match.points.barycentric)
            known.append(match.matched)
            sure.append(match.confidence)
    points = SurfacePoints(np.concatenate(faces), np.concatenate(weights))
    confidence = np.concatenate(sure)
    return Partner(points, np.concatenate(known), confidence), confidence


def _piece_words(piece: PieceAnswer) -> str:
    word = "placed" if piece.placed else "refused"
    return f"{word}, chance {piece.chance:.2f}; {piece.reason}"


def _doubts(result: Assembly) -> str:
    if not result.placed:
        return "doubtful: no piece has a place; is this the right full shape, in the same unit?"
    doubted = [
        str(k)
        for k, piece in enumerate(result.pieces)
        if piece.placed and piece.match is not None and piece.match.status is not Status.GOOD
    ]
    return f"doubtful: look at the place of piece {', '.join(doubted)}"


def _sentences(result: Assembly) -> tuple[str, ...]:
    said = [
        f"{len(result.placed)} of {len(result.pieces)} pieces have a place; "
        f"{100 * result.gap_share:.1f} % of the full shape is missing."
    ]
    said += [
        f"Piece {k}, {result.pieces[k].part.name}, is refused: it {result.pieces[k].reason}."
        for k in result.refused
    ]
    said += [
        f"The gap at vertex {gap.vertex} has {100 * gap.area / result.full.area:.1f} % of the area."
        for gap in result.gaps[:NAMED]
    ]
    said += [
        f"Pieces {c.first} and {c.second} meet along {c.length:.3g} in the unit of the file; their "
        f"borders are {c.apart:.2g} apart on average."
        for c in result.contacts[:NAMED]
        if np.isfinite(c.apart)
    ]
    said += [
        f"Pieces {s.first} and {s.second} share {100 * s.area / result.full.area:.1f} % of the "
        "full shape."
        for s in result.shared[:NAMED]
    ]
    return (*said, *(f"Full shape: {text}" for text in result.notices))
