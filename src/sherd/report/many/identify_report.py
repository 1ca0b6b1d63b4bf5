"""The report of `sherd identify`: that of the likeliest match, with all full shapes in a table."""

from __future__ import annotations

import csv
import io
from dataclasses import asdict, replace
from typing import Any

from sherd.drawing.exhibit import Verdict
from sherd.errors import InfeasibleError
from sherd.report.frame import Report
from sherd.report.match_report import match_report
from sherd.results.many.identification import CandidateAnswer, Identification
from sherd.results.status import Status

COLUMNS = ("name", "evidence", "ratio", "refused", "status", "chance", "score")

__all__ = ["candidates_csv", "identification_facts", "identify_report"]


def identify_report(result: Identification, *, command: str = "") -> Report:
    """All that is written of an identification: a folder that reads as that of a match.

    Where the part belongs to none, the likeliest placement is shown for what it is.

    Raises
    ------
    InfeasibleError
        If no full shape was matched, as all are out of the question by their size.
    """
    first = result.candidates[0].match
    if first is None:
        raise InfeasibleError(f"{result.part.name}: {result.advice}")
    report = match_report(first, command=command)
    facts = identification_facts(result)
    names = {each.name: f"evidence {each.evidence:.2f}; {each.said}" for each in result.candidates}
    exhibit = replace(
        report.exhibit,
        title=f"{result.part.name} among {len(names)} shapes",
        verdict=Verdict.from_advice(result.advice, trusted=result.status is Status.GOOD),
        summary=(*_sentences(result), *report.exhibit.summary),
        facts={"Full shapes": names, **report.exhibit.facts},
    )
    files = {**report.files, "candidates.csv": lambda: candidates_csv(result)}
    document = {**report.document, "identification": facts}
    return Report(document, exhibit, files, report.picture_name)


def identification_facts(result: Identification) -> dict[str, Any]:
    """What ``result.json`` says under ``identification``; see docs/schema/identification.json."""
    best = result.best
    return {
        "status": result.status.name.lower(),
        "advice": result.advice,
        "full": None if best is None else best.name,
        "also": [each.name for each in result.also],
        "candidates": [_candidate_facts(each) for each in result.candidates],
        "options": asdict(result.options),
        "timings": dict(result.timings),
    }


def candidates_csv(result: Identification) -> str:
    """``name,evidence,ratio,refused,status,chance,score``, the likeliest first."""
    stream = io.StringIO()
    writer = csv.DictWriter(stream, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for each in result.candidates:
        row = _candidate_facts(each)
        numbers = {k: f"{v:.9g}" for k, v in row.items() if isinstance(v, float)}
        writer.writerow(row | numbers)
    return stream.getvalue()


def _candidate_facts(answer: CandidateAnswer) -> dict[str, Any]:
    match = answer.match
    return {
        "name": answer.name,
        "evidence": answer.evidence,
        "ratio": answer.ratio,
        "refused": answer.refused,
        "status": None if match is None else match.status.name.lower(),
        "chance": None if match is None else match.chance,
        "score": None if match is None else match.best.score,
    }


def _sentences(result: Identification) -> tuple[str, ...]:
    asked = sum(each.match is not None for each in result.candidates)
    said = [
        f"{len(result.candidates)} full shapes were compared by cheap evidence, and "
        f"{asked} matched with the part."
    ]
    first = result.candidates[0]
    if result.best is None:
        said.append(
            f"The part belongs to none of them; what is shown is the likeliest, {first.name}."
        )
    return tuple(said)
