"""What the reports of all questions have in common: facts, sentences, files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, TypeAlias

import numpy as np

from sherd.drawing.exhibit import Exhibit
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.files import table_csv
from sherd.results.locate_result import LocateResult
from sherd.results.match_result import MatchResult
from sherd.results.placement import Placement

__all__ = [
    "Answer",
    "Content",
    "Report",
    "alternative_facts",
    "alternative_sentences",
    "common_facts",
    "decimation_sentences",
    "facts_of",
    "mesh_facts",
    "notice_sentences",
    "region_csv",
]

# A score this near to the best deserves the reader's attention: repeated runs on remeshed copies of
# one pair differ by about as much.
CLOSE_SCORE = 0.02


Answer: TypeAlias = MatchResult | LocateResult
Content: TypeAlias = Callable[[], str | bytes]


@dataclass(frozen=True, eq=False)
class Report:
    """All that is written of one result.

    Attributes
    ----------
    document
        The content of ``result.json`` but for the hashes: plain numbers, strings and lists.
    exhibit
        What the page and the picture show.
    files
        What makes the content of further files, by name: of a million vertices text takes seconds,
        which another core may use.
    picture_name
        What the picture is called.
    """

    document: Mapping[str, Any]
    exhibit: Exhibit
    files: Mapping[str, Content]
    picture_name: str


def common_facts(answer: Answer, *, file_format: str, command: str) -> dict[str, Any]:
    """What ``result.json`` says of every result."""
    return {
        "format": file_format,
        "version": answer.version,
        "command": command,
        "full": mesh_facts(answer.full, answer.notices.get("full", ())),
        "part": mesh_facts(answer.part, answer.notices.get("part", ())),
        "check": asdict(answer.check()),
        "options": asdict(answer.options),
        "seed": answer.options.seed,
        "working_vertices": dict(answer.working_vertices),
        "timings": dict(answer.timings),
    }


def facts_of(
    document: Mapping[str, Any], answer_keys: Sequence[str], **extra: Mapping[str, Any]
) -> dict[str, Mapping[str, Any]]:
    """The tables of the page: `answer_keys` of the document first, `extra` tables after them."""
    return {
        "Result": {key: document[key] for key in (*answer_keys, "version")},
        **extra,
        "Full shape": document["full"],
        "Part": document["part"],
        "Check": document["check"],
        "Options": document["options"],
        "Seconds": document["timings"],
    }


def alternative_facts(answer: Answer) -> list[dict[str, Any]]:
    """Name, score and overlap (IoU by area) with the best region of each alternative."""
    return [
        {
            "name": other.name,
            "score": other.score,
            "mirrored": other.mirrored,
            "overlap": _overlap(answer, other),
        }
        for other in answer.alternatives
    ]


def alternative_sentences(answer: Answer) -> list[str]:
    """How much worse the alternatives are, in words."""
    said = []
    for other in answer.alternatives:
        gap = answer.best.score - other.score
        close = "equally well" if gap < CLOSE_SCORE else f"with a score lower by {gap:.2f}"
        who = "A mirror image of the part" if other.mirrored else "Another placement"
        said.append(f"{who} would fit {close} ({other.name}, in the list of alternatives).")
    return said


def decimation_sentences(answer: Answer) -> list[str]:
    """What was searched on fewer vertices than the file has."""
    said = []
    for name, mesh in (("full shape", answer.full), ("part", answer.part)):
        worked = answer.working_vertices.get(name.split()[0], mesh.vertex_count)
        if worked < mesh.vertex_count:
            said.append(
                f"The {name} was searched on {worked:,} of its {mesh.vertex_count:,} vertices; the "
                "answers were then carried to every vertex on the surface itself."
            )
    return said


def notice_sentences(answer: Answer) -> list[str]:
    """What was adapted in the shapes."""
    return [
        f"{which.capitalize()}: {text}"
        for which in ("full", "part")
        for text in answer.notices.get(which, ())
    ]


def region_csv(place: Placement) -> str:
    """``full_vertex,membership,in_region``, one row per vertex of the full shape, from 0."""
    return table_csv(
        {
            "full_vertex": np.arange(len(place.mask)),
            "membership": place.membership,
            "in_region": place.mask,
        }
    )


def mesh_facts(mesh: TriangleMesh, notices: tuple[str, ...]) -> dict[str, Any]:
    """What ``result.json`` says of a shape."""
    return {
        "name": mesh.name,
        "vertices": mesh.vertex_count,
        "faces": mesh.face_count,
        "area": mesh.area,
        "notices": list(notices),
    }


def _overlap(answer: Answer, other: Placement) -> float | None:
    areas, best = answer.full.vertex_areas, answer.best.mask
    union = float(areas[best | other.mask].sum())
    return float(areas[best & other.mask].sum()) / union if union > 0 else None
