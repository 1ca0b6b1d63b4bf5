"""Questions are measured once, kept at once, and answered in order; rows come back from files."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import pytest

from sherd.benchmark.row_file import content_hash, stored_rows, write_rows
from sherd.benchmark.runner import measured_and_kept, measured_rows
from sherd.errors import OptionError


@dataclass(frozen=True)
class Named:
    """A row that is nothing but its name."""

    case: str


QUESTIONS = [Path("b/two"), Path("a/one"), Path("c/three")]


@pytest.mark.parametrize("jobs", [1, 2])
def test_what_is_known_is_not_measured_again(jobs) -> None:
    kept = []

    def keep(name: str, row: str) -> None:
        kept.append((name, row))

    rows = measured_rows(QUESTIONS, os.fspath, known={"one": "known"}, keep=keep, jobs=jobs)
    assert rows == ["b/two", "known", "c/three"]
    assert kept == [("two", "b/two"), ("three", "c/three")]


def test_what_was_measured_before_an_error_is_kept() -> None:
    kept = []

    def fail_at_the_second(question: Path) -> str:
        if question.name == "one":
            raise ValueError(question.name)
        return question.name

    with pytest.raises(ValueError, match="one"):
        measured_rows(
            QUESTIONS, fail_at_the_second, known={}, keep=lambda name, _: kept.append(name)
        )
    assert kept == ["two"]


def test_no_process_is_refused() -> None:
    with pytest.raises(OptionError, match="jobs is 0"):
        measured_rows([], os.fspath, known={}, keep=lambda *_: None, jobs=0)


@dataclass(frozen=True)
class Measured:
    name: str
    error: float | None


def test_rows_are_read_back_only_for_the_same_settings(tmp_path) -> None:
    path = tmp_path / "bench.json"
    rows = [Measured("one", 0.5), Measured("two", None)]
    assert stored_rows(path, {"seed": 0}, Measured) == []
    write_rows(path, {"seed": 0, "total": 2}, rows)
    assert stored_rows(path, {"seed": 0}, Measured) == rows
    assert stored_rows(path, {"seed": 1}, Measured) == []
    assert stored_rows(path, {"vertices": 5}, Measured) == []
    path.write_text('{"seed": 0, "rows": [{"name": "one"}]}')  # of another version
    assert stored_rows(path, {"seed": 0}, Measured) == []
    path.write_text("[")
    assert stored_rows(path, {"seed": 0}, Measured) == []


def test_rows_depend_on_what_files_hold_and_not_on_where_they_lie(tmp_path) -> None:
    for folder in ("one", "other"):
        (tmp_path / folder / "poses").mkdir(parents=True)
        (tmp_path / folder / "poses" / "a.off").write_text("a")
    one, other = tmp_path / "one" / "poses", tmp_path / "other" / "poses"
    assert content_hash([one]) == content_hash([other, other])
    (other / "a.off").write_text("b")
    assert content_hash([one]) != content_hash([other])
    (other / "a.off").rename(other / "b.off")
    (one / "a.off").write_text("b")
    assert content_hash([one]) != content_hash([other])


def test_rows_of_other_files_or_settings_are_measured_anew(tmp_path) -> None:
    source, path, asked = tmp_path / "a.off", tmp_path / "rows.json", []
    source.write_text("a")

    def measure(question: Path) -> Named:
        asked.append(question.name)
        return Named(question.name)

    def run(**settings: int) -> list[Named]:
        return measured_and_kept(
            QUESTIONS, measure, kind=Named, name=lambda row: row.case, path=path,
            inputs=[source], settings=settings,
        )  # fmt: skip

    assert run() == run() == [Named(question.name) for question in QUESTIONS]
    assert len(asked) == len(QUESTIONS)
    source.write_text("b")
    run()
    assert len(asked) == 2 * len(QUESTIONS)
    run(seed=1)
    assert len(asked) == 3 * len(QUESTIONS)
