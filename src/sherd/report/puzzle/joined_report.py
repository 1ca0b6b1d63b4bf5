"""The report of `sherd assemble --no-full`: tables, page and picture of a Joined."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.drawing.exhibit import Exhibit, Layer, Partner, Verdict
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.files import painted_ply, table_csv
from sherd.report.frame import Content, Report, mesh_facts
from sherd.report.known_layers import known_layer
from sherd.report.puzzle.assembly_report import piece_file
from sherd.report.puzzle.piece_colors import piece_palette
from sherd.report.puzzle.piece_row import ShownPiece, piece_row, resized
from sherd.report.stored.folder import JOINED_FORMAT
from sherd.results.puzzle.joined import Joined

__all__ = ["Partners", "joined_exhibit", "joined_report", "stored_partners"]


@dataclass(frozen=True, eq=False)
class Partners:
    """The points of one piece on the others, a row for each vertex and piece that has it.

    Attributes
    ----------
    vertices, pieces
        (r,) the vertex, and the other piece.
    points
        (r,) of that piece.
    nearest
        (r,) the vertex of that piece nearest to the point.
    confidence
        (r,) chance to be near the truth.
    """

    vertices: Ints
    pieces: Ints
    points: SurfacePoints
    nearest: Ints
    confidence: Floats


def joined_report(result: Joined, *, command: str = "") -> Report:
    """All that is written of pieces without a whole."""
    document = _document(result, command)
    partners = [_partners(result, number) for number in range(len(result.pieces))]
    files: dict[str, Content] = {"pairs.csv": partial(_pairs_csv, result)}
    for number, (piece, own) in enumerate(zip(result.pieces, partners, strict=True)):
        layer = _group_layer(np.full(piece.vertex_count, result.group_of[number]), result.groups)
        files[piece_file(number, "part.ply")] = partial(painted_ply, piece, [layer])
        files[piece_file(number, "partners.csv")] = partial(_partners_csv, own)
    exhibit = replace(
        joined_exhibit(result.pieces, result.groups, partners),
        verdict=Verdict.from_advice(_said(result), trusted=result.sure),
        summary=_sentences(result),
        facts={
            "Groups": {
                f"{k}": ", ".join(f"{n} {result.named(n)}" for n in group)
                for k, group in enumerate(result.groups)
            },
            "Pairs": {
                f"{p.first} and {p.second}": _pair_words(p.evidence, p.chance, asked=p.asked)
                for p in result.pairs
            },
            "Options": document["options"],
            "Seconds": document["timings"],
        },
        command=command,
    )
    return Report(document, exhibit, files, picture_name="assembly.png")


def joined_exhibit(
    pieces: Sequence[TriangleMesh],
    groups: Sequence[Sequence[int]],
    partners: Sequence[Partners],
) -> Exhibit:
    """The pieces in rows, twice: a point on one side shows its surest partner on the other."""
    reference = _reference(pieces, groups)
    row = piece_row(pieces[0], [ShownPiece(piece, None) for piece in pieces], reference.length)
    group_of = np.empty(len(pieces), dtype=np.int64)
    for number, group in enumerate(groups):
        group_of[list(group)] = number
    layers = (
        _group_layer(group_of[row.owner], groups),
        Layer(
            "piece",
            row.owner,
            kind="category",
            description="Each piece in a color of its own.",
            labels=tuple(f"{k} {piece.name}" for k, piece in enumerate(pieces)),
        ),
    )
    partner = _surest(pieces, partners)
    return Exhibit(
        title=f"{len(pieces)} pieces without a whole",
        full=row.mesh,
        part=row.mesh,
        full_layers=layers,
        part_layers=(*layers, known_layer("confidence", np.asarray(partner.confidence))),
        partner=partner,
        region=np.ones(row.mesh.vertex_count, dtype=bool),
        names=("Pieces", "Pieces again"),
        part_stands=True,
        part_numbers=row.numbers,
        unit_of=reference,
    )


def _reference(pieces: Sequence[TriangleMesh], groups: Sequence[Sequence[int]]) -> TriangleMesh:
    """The largest piece that belongs to another one; of all, if none does."""
    together = [pieces[number] for group in groups if len(group) > 1 for number in group]
    return max(together or pieces, key=lambda piece: piece.area)


def _surest(pieces: Sequence[TriangleMesh], partners: Sequence[Partners]) -> Partner:
    """For each vertex of all pieces, one after the other, its surest point on another piece."""
    starts = np.cumsum([0, *(piece.vertex_count for piece in pieces)])
    first_face = np.cumsum([0, *(piece.face_count for piece in pieces)])
    count = int(starts[-1])
    faces, weights = np.zeros(count, dtype=np.int64), np.tile([1.0, 0.0, 0.0], (count, 1))
    known, confidence = np.zeros(count, dtype=bool), np.full(count, np.nan)
    for number, own in enumerate(partners):
        order = np.argsort(own.confidence, kind="stable")  # the surest is written last
        rows = starts[number] + own.vertices[order]
        faces[rows] = first_face[own.pieces[order]] + own.points.faces[order]
        weights[rows] = own.points.barycentric[order]
        known[rows], confidence[rows] = True, own.confidence[order]
    return Partner(SurfacePoints(faces, weights), known, confidence)


def _group_layer(values: Ints, groups: Sequence[Sequence[int]]) -> Layer:
    return Layer(
        "group",
        values,
        kind="category",
        description="Pieces of one color belong together.",
        labels=tuple(
            f"{'piece' if len(group) == 1 else 'pieces'} {', '.join(map(str, group))}"
            for group in groups
        ),
        palette=piece_palette(max(len(groups), 7)),
    )


def _partners(result: Joined, number: int) -> Partners:
    """The known points of one piece on all others."""
    found = [
        (there, result.maps[here, there]) for here, there in sorted(result.maps) if here == number
    ]
    rows = [np.flatnonzero(each.matched) for _, each in found]
    points = [each.points[some] for (_, each), some in zip(found, rows, strict=True)]
    nearest = [
        some.nearest_vertices(result.pieces[there])
        for (there, _), some in zip(found, points, strict=True)
    ]
    none = np.empty(0, dtype=np.int64)
    return Partners(
        vertices=np.concatenate([none, *rows]),
        pieces=np.concatenate(
            [none, *(np.full(len(r), t) for (t, _), r in zip(found, rows, strict=True))]
        ),
        points=SurfacePoints(
            np.concatenate([none, *(some.faces for some in points)]),
            np.concatenate([np.empty((0, 3)), *(some.barycentric for some in points)]),
        ),
        nearest=np.concatenate([none, *nearest]),
        confidence=np.concatenate(
            [np.empty(0), *(e.confidence[r] for (_, e), r in zip(found, rows, strict=True))]
        ),
    )


def _partners_csv(own: Partners) -> str:
    """``part_vertex,piece,face,b0,b1,b2,vertex,confidence``, a row for each known point."""
    return table_csv(
        {
            "part_vertex": own.vertices,
            "piece": own.pieces,
            "face": own.points.faces,
            **{f"b{k}": own.points.barycentric[:, k] for k in range(3)},
            "vertex": own.nearest,
            "confidence": own.confidence,
        }
    )


def _pairs_csv(result: Joined) -> str:
    columns = ("first", "second", "evidence", "asked", "chance", "joined")
    return table_csv(
        {name: np.array([getattr(pair, name) for pair in result.pairs]) for name in columns}
    )


def _document(result: Joined, command: str) -> dict[str, Any]:
    return {
        "format": JOINED_FORMAT,
        "version": result.version,
        "command": command,
        "full": None,
        "status": "good" if result.sure else "doubtful",
        "pieces": [
            {
                **mesh_facts(piece, result.notices[k] if result.notices else ()),
                "group": result.group_of[k],
                "likely": result.likely.get(k),
                "by_twin": k in result.by_twin,
                "unplaced": k in result.unplaced,
                "file": piece_file(k, "partners.csv"),
            }
            for k, piece in enumerate(result.pieces)
        ],
        "groups": [list(group) for group in result.groups],
        "pairs": [asdict(pair) for pair in result.pairs],
        "cycle_before": _known(result.cycle_before),
        "cycle_after": _known(result.cycle_after),
        "options": asdict(result.options),
        "seed": result.options.seed,
        "timings": dict(result.timings),
    }


def _known(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _said(result: Joined) -> str:
    unplaced = f", {len(result.unplaced)} without a place" if result.unplaced else ""
    if not result.sure:
        nothing = "no two pieces were surely found to share anything, if they overlap at all"
        return f"doubtful: {nothing}{unplaced}"
    alone = sum(len(group) == 1 for group in result.groups)
    together = len(result.groups) - alone
    likely = f", {len(result.likely)} likely but not sure" if result.likely else ""
    return f"good: {together} group{'s' * (together > 1)}, {alone} alone{likely}{unplaced}"


def _pair_words(evidence: float, chance: float, *, asked: bool) -> str:
    if not asked:
        return f"evidence {evidence:.2f}, not asked"
    return f"evidence {evidence:.2f}, chance {chance:.2f}"


def _sentences(result: Joined) -> tuple[str, ...]:
    asked = sum(pair.asked for pair in result.pairs)
    count = len(result.groups)
    said = [f"{len(result.pieces)} pieces form {count} group{'s' * (count > 1)}."]
    said.append(f"{asked} of {len(result.pairs)} pairs were asked.")
    reference = _reference(result.pieces, result.groups).length
    said += [
        f"{number} {result.pieces[number].name} is drawn as large as the others, as it is "
        f"{times:.3g} times as wide."
        for number, times in resized(result.pieces, reference).items()
    ]
    said += [
        f"{number} {result.pieces[number].name}: {text}."
        for number, texts in enumerate(result.notices)
        for text in texts
    ]
    said += [_likely_words(result, number) for number in result.likely]
    said += [
        f"{number} {result.pieces[number].name} belongs to its group, but where it lies is not "
        "likely enough, so no map has it."
        for number in result.unplaced
    ]
    if np.isfinite(result.cycle_before):
        said.append(
            f"Around loops of three pieces a point comes back {result.cycle_before:.3f} away "
            f"before, and {result.cycle_after:.3f} after the maps were made consistent, in "
            "sqrt(area) of the largest piece."
        )
    return tuple(said)


def _likely_words(result: Joined, number: int) -> str:
    said = (
        f"{number} {result.pieces[number].name} is where it lies with a chance of "
        f"{result.likely[number]:.2f}, which is not sure; look at it."
    )
    if number not in result.by_twin:
        return said
    return (
        f"{said} Only its twin tells, on which its mirror image lies; so would that of another "
        "body of the same kind."
    )


def stored_partners(table: Mapping[str, Any]) -> Partners:
    """The rows of a ``partners.csv``."""
    weights = np.column_stack([table[f"b{k}"] for k in range(3)]).reshape(-1, 3)
    total = weights.sum(axis=1, keepdims=True)
    return Partners(
        vertices=table["part_vertex"].astype(np.int64).ravel(),
        pieces=table["piece"].astype(np.int64).ravel(),
        points=SurfacePoints(table["face"].astype(np.int64).ravel(), weights / total),
        nearest=table["vertex"].astype(np.int64).ravel(),
        confidence=table["confidence"].ravel(),
    )
