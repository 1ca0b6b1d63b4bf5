"""The report of `sherd assemble`: tables, page and picture of an Assembly."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from functools import partial
from typing import Any

import numpy as np

from sherd.drawing.exhibit import Exhibit, Partner, Verdict
from sherd.report.files import painted_ply, table_csv
from sherd.report.frame import Content, Report, mesh_facts
from sherd.report.match_report import correspondence_csv
from sherd.report.puzzle.assembly_scene import AssemblyScene
from sherd.report.puzzle.piece_row import ShownPiece, resized
from sherd.report.stored.folder import ASSEMBLY_FORMAT
from sherd.results.puzzle.assembly import Assembly, PieceAnswer
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
    scene = _scene(result)
    files: dict[str, Content] = {
        "labels.csv": partial(_labels_csv, result, scene),
        "full.ply": partial(painted_ply, result.full, scene.full_layers),
    }
    for number, piece in enumerate(result.pieces):
        files[piece_file(number, "part.ply")] = partial(
            painted_ply, piece.part, scene.piece_layers(number)
        )
        if piece.placed and piece.match is not None:
            files[piece_file(number)] = partial(correspondence_csv, piece.match)
        laid = piece.on_full
        if laid is not None:
            files[piece_file(number, "placed.ply")] = partial(
                painted_ply, laid, scene.piece_layers(number)
            )
    return Report(document, _exhibit(result, document, scene), files, picture_name="assembly.png")


def _scene(result: Assembly) -> AssemblyScene:
    both = np.concatenate([result.memberships, result.gap_membership[None, :]])
    row = np.where(result.labels < 0, len(result.pieces), result.labels)
    return AssemblyScene(
        full=result.full,
        pieces=[ShownPiece(piece.part, _partner(piece)) for piece in result.pieces],
        labels=result.labels,
        membership=both[row, np.arange(len(row))],
    )


def _partner(piece: PieceAnswer) -> Partner | None:
    if not piece.placed or piece.match is None:
        return None
    return Partner(piece.match.points, piece.match.matched, piece.match.confidence)


def _labels_csv(result: Assembly, scene: AssemblyScene) -> str:
    """``full_vertex,piece,membership``, a row for each vertex of the full shape, from 0."""
    return table_csv(
        {
            "full_vertex": np.arange(len(result.labels)),
            "piece": result.labels,
            "membership": scene.membership,
        }
    )


def _document(result: Assembly, command: str) -> dict[str, Any]:
    return {
        "format": ASSEMBLY_FORMAT,
        "version": result.version,
        "command": command,
        "full": mesh_facts(result.full, result.notices),
        "status": result.status.name.lower(),
        "pieces": [_piece_facts(k, piece) for k, piece in enumerate(result.pieces)],
        "gap": {
            "area": result.gap_area,
            "share": result.gap_share,
            "components": [asdict(gap) for gap in result.gaps],
        },
        "contacts": [asdict(contact) for contact in result.contacts],
        "shared": [asdict(place) for place in result.shared],
        "energy": result.energy,
        "proven": result.proven,
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


def _exhibit(result: Assembly, document: Mapping[str, Any], scene: AssemblyScene) -> Exhibit:
    status = result.status
    words = "good: each placed piece fits" if status is Status.GOOD else _doubts(result)
    return replace(
        scene.exhibit(),
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
    )


def _piece_words(piece: PieceAnswer) -> str:
    word = "placed" if piece.placed else "refused"
    return f"{word}, chance {piece.chance:.2f}; {piece.reason}"


def _doubts(result: Assembly) -> str:
    if not result.placed:
        return "doubtful: no piece has a place; is this the right full shape, in the same unit?"
    doubted = [str(k) for k in result.placed if not result.pieces[k].sure]
    if not doubted:
        return (
            "doubtful: there may be a better choice of places for all pieces together, as so many "
            "fit in so many places; give fewer at a time"
        )
    return f"doubtful: look at the place of piece {', '.join(doubted)}"


def _sentences(result: Assembly) -> tuple[str, ...]:
    said = [
        f"{len(result.placed)} of {len(result.pieces)} pieces have a place; "
        f"{100 * result.gap_share:.1f} % of the full shape is missing."
    ]
    said += [
        f"Piece {k}, {result.pieces[k].part.name}, is refused: {result.pieces[k].reason}."
        for k in result.refused
    ]
    said += [
        f"Piece {k} is drawn as large as the full shape, as it is {times:.3g} times as wide."
        for k, times in resized([piece.part for piece in result.pieces], result.full.length).items()
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
