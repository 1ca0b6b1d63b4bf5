"""`sherd batch`: words in, words out, exit codes."""

from __future__ import annotations

import csv
import json

import pytest
from pyarrow import parquet

from sherd.cli.exits import INVALID_INPUT, NOT_CONVERGED, SOME_FAILED, USAGE

WORDS = ("batch", "whole.ply", "--parts", "scans", "-o", "out")


def test_failures_are_said_and_the_exit_code_says_that_there_are_some(command, stand) -> None:
    done = command(*WORDS)
    assert done.exit_code == SOME_FAILED, done.output
    assert "3 good, 1 failed." in done.stdout
    assert "failed: broken: " in done.stderr
    (stand.folder / "scans" / "broken.ply").unlink()
    done = command(*WORDS, "-q")
    assert (done.exit_code, done.output) == (0, "")


def test_answers_that_are_not_all_good_have_a_code_of_their_own(command, stand, written) -> None:
    (stand.folder / "scans" / "broken.ply").unlink()
    path = stand.out / "parts" / "a" / "outcome.json"
    assert command(*WORDS).exit_code == 0
    path.write_text(path.read_text().replace('"status":"good"', '"status":"doubtful"'))
    for journal in (stand.out / "journal").glob("*.jsonl"):
        journal.unlink()
    assert command(*WORDS).exit_code == NOT_CONVERGED


def test_a_line_of_json_for_each_part(command) -> None:
    for _ in range(2):
        rows = [json.loads(line) for line in command(*WORDS, "--json").stdout.splitlines()]
        assert sorted(row["name"] for row in rows) == ["a", "b", "broken", "c"]
        assert {row["status"] for row in rows} == {"good", "failed"}


def test_a_table_names_parts_and_where_they_belong(command, stand) -> None:
    (stand.folder / "scans" / "t.csv").write_text(
        "part,name,full\na.ply,first,whole.ply\nb.ply,,\n"
    )
    words = ("batch", "whole.ply", "--parts", "scans/t.csv", "-o", "out")
    assert command(*words).exit_code == 0
    with (stand.out / "summary.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [(row["name"], row["full"]) for row in rows] == [
        ("b", "whole.ply"),
        ("first", "whole.ply"),
    ]
    (stand.folder / "scans" / "t.csv").write_text("part,full\na.ply,cat.ply\n")
    done = command(*words)
    assert done.exit_code == 3
    assert "belongs to cat.ply, but given were whole.ply" in done.stderr


def test_shards_write_no_tables_until_they_are_collected(command, stand) -> None:
    assert command(*WORDS, "--shard", "1/2", "-q").exit_code == SOME_FAILED
    assert not (stand.out / "summary.csv").exists()
    done = command("batch", "--collect", "out", "--json")
    assert done.exit_code == SOME_FAILED
    assert len(done.stdout.splitlines()) == 2


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_parquet_holds_the_same_rows(command, stand, suffix) -> None:
    command(*WORDS, "--format", suffix)
    path = stand.out / "summary.parquet"
    assert path.exists() == (suffix == "parquet")
    if path.exists():
        table = parquet.read_table(path)
        assert table.column("name").to_pylist() == ["a", "b", "broken", "c"]
        assert table.column("chance").null_count >= 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["batch", "whole.ply", "-o", "out"], "are needed"),
        (["batch", "--collect", "out", "--parts", "scans"], "nothing but the folder"),
        (["batch", "--all-pairs", "scans", "whole.ply", "-o", "out"], "has no full shape"),
        ([*WORDS, "--jobs", "0"], "jobs is 0"),
        ([*WORDS, "--memory", "0.1"], "memory is 100000000"),
        ([*WORDS, "--dask", "tcp://x", "--jobs", "2"], "brings its own"),
        ([*WORDS, "--min-confidence", "2"], "it is a chance"),
    ],
)
def test_words_that_do_not_go_together_are_usage_errors(command, stand, words, said) -> None:
    done = command(*words)
    assert (done.exit_code, stand.asked) == (USAGE, [])
    assert said in done.stderr


def test_a_missing_extra_names_itself(command, stand, monkeypatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    done = command(*WORDS, "--dask", "tcp://x")
    assert 'python -m pip install "sherd[cluster]"' in done.stderr
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    done = command(*WORDS, "--format", "parquet")
    assert 'python -m pip install "sherd[parquet]"' in done.stderr
    assert not stand.out.exists()


def test_landmarks_of_the_full_shape_are_carried_to_all_parts(
    command, stand, exhibit, match_result_of, monkeypatch
) -> None:
    result = match_result_of(exhibit)
    monkeypatch.setattr("sherd.batching.specimens.read_match", lambda folder: result)
    x, y, z = result.full.vertices[0]
    (stand.folder / "tips.csv").write_text(f"name,x,y,z\ntip,{x},{y},{z}\n")
    (stand.folder / "scans" / "broken.ply").unlink()
    assert command(*WORDS, "--landmarks", "tips.csv", "-q").exit_code == 0
    with (stand.out / "landmarks.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [(row["specimen"], row["landmark"]) for row in rows] == [
        ("a", "tip"),
        ("b", "tip"),
        ("c", "tip"),
    ]
    done = command(*WORDS, "--landmarks", "other.ply=tips.csv")
    assert done.exit_code == USAGE
    assert "none are given for whole.ply" in done.stderr
    done = command(*WORDS, "--landmarks", "tips.csv", "--shard", "1/2")
    assert done.exit_code == USAGE
    assert "when all are there" in done.stderr


def test_a_template_that_cannot_be_read_is_refused_once(command, stand) -> None:
    (stand.folder / "horse.npz").mkdir()
    done = command(*WORDS, "--template", "horse.npz")
    assert done.exit_code == INVALID_INPUT
    assert "horse.npz: cannot be read as a template" in done.stderr
    assert stand.asked == []
