"""A batch goes on where it was, believes nothing that is half done, and computes nothing twice."""

from __future__ import annotations

import csv
import json
import os
import shutil

import pytest

from sherd.batching.collect import collect_batch
from sherd.batching.options import BatchOptions
from sherd.errors import InputError, OptionError, OutputError
from sherd.report.stored.folder import folder_problems
from sherd.results.match_options import MatchOptions

PARTS = ["a.ply", "b.ply", "c.ply"]


def statuses(result) -> dict[str, str]:
    return {row.name: row.status for row in result.rows}


def test_a_batch_has_a_folder_for_each_part_and_a_row_for_each_failure(stand) -> None:
    told = []
    result = stand.run(tell=told.append)
    assert stand.asked == PARTS
    assert statuses(result) == {"a": "good", "b": "good", "broken": "failed", "c": "good"}
    assert sorted(told, key=lambda row: row.name) == list(result.rows)
    assert not result.all_answered
    for name in ("a", "b", "c"):
        assert folder_problems(stand.out / "parts" / name) == ()
    with (stand.out / "summary.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["name"] for row in rows] == ["a", "b", "broken", "c"]
    assert "broken.ply" in rows[2]["reason"]
    document = json.loads((stand.out / "summary.json").read_text())
    assert document["counts"] == {"good": 3, "doubtful": 0, "foreign": 0, "failed": 1}
    assert document["waiting"] == []
    assert not list((stand.out / "parts").glob(".*"))


def test_nothing_is_computed_twice(stand) -> None:
    first = stand.run()
    again = stand.run()
    assert stand.asked == []
    assert (again.computed, again.rows) == (0, first.rows)


def test_only_what_changed_is_computed_again(stand) -> None:
    stand.run()
    scans = stand.folder / "scans"
    text = (scans / "a.ply").read_bytes()
    (scans / "a.ply").write_bytes(text + b"\n")  # another file
    os.utime(scans / "b.ply", ns=(1, 1))  # the same, copied
    (scans / "broken.ply").write_bytes(text)
    shutil.rmtree(stand.out / "parts" / "c")
    result = stand.run()
    assert stand.asked == ["a.ply", "broken.ply", "c.ply"]
    assert set(statuses(result).values()) == {"good"}


@pytest.mark.parametrize(
    "changed",
    [
        {"options": MatchOptions(seed=1)},
        {"batch_options": BatchOptions(min_confidence=0.5)},
        {"batch_options": BatchOptions(exports=("map",))},
    ],
)
def test_other_options_are_another_question(stand, changed) -> None:
    stand.run()
    stand.run(**changed)
    assert stand.asked == PARTS


def test_another_version_asks_again(stand, monkeypatch) -> None:
    stand.run()
    monkeypatch.setattr("sherd.batching.task.__version__", "9")
    stand.run()
    assert stand.asked == PARTS


def test_an_answer_that_was_changed_by_hand_is_not_believed(stand) -> None:
    stand.run()
    path = stand.out / "parts" / "b" / "result.json"
    path.write_text(path.read_text().replace('"good"', '"fine"'))
    (stand.out / "parts" / "b" / "notes.txt").write_text("mine")
    stand.run()
    assert stand.asked == ["b.ply"]
    assert (stand.out / "parts" / "b" / "notes.txt").read_text() == "mine"
    assert folder_problems(stand.out / "parts" / "b") == ()


def test_torn_and_lost_journals_cost_nothing_that_has_a_folder(stand) -> None:
    first = stand.run()
    for path in (stand.out / "journal").glob("*.jsonl"):
        path.write_bytes(path.read_bytes()[:-20])
    assert stand.run().rows == first.rows
    assert stand.asked == []
    for path in (stand.out / "journal").glob("*.jsonl"):
        path.unlink()
    assert stand.run().rows[0] == first.rows[0]
    assert stand.asked == []


def test_interrupted_after_any_part_the_rest_is_done(stand) -> None:
    def interrupt(name: str) -> None:
        if name == "b.ply":
            raise KeyboardInterrupt

    stand.before = interrupt
    with pytest.raises(KeyboardInterrupt):
        stand.run()
    document = json.loads((stand.out / "summary.json").read_text())
    assert (len(document["parts"]), len(document["waiting"])) == (1, 3)
    assert not list((stand.out / "parts").glob(".*"))
    stand.before = lambda _: None
    assert set(statuses(stand.run()).values()) == {"good", "failed"}
    assert "a.ply" not in stand.asked  # c was perhaps begun, and is found in its folder


def test_what_may_go_better_is_tried_again_and_what_may_not_is_not(stand) -> None:
    def fail(name: str) -> None:
        if name == "a.ply":
            raise MemoryError
        if name == "b.ply":
            raise ZeroDivisionError("one / zero")

    stand.before = fail
    rows = stand.run().rows
    assert [row.failure for row in rows] == ["memory", "internal", "refused", None]
    assert "ZeroDivisionError: one / zero" in rows[1].reason
    stand.before = lambda _: None
    stand.run()
    assert stand.asked == ["a.ply"]


def test_leftovers_of_dead_processes_are_removed_and_others_kept(stand) -> None:
    from sherd.batching.ledger.place import HOST  # noqa: PLC0415

    parts = stand.out / "parts"
    dead, alive, elsewhere = (
        parts / f".x.{host}.{process}.0123abcd.partial"
        for host, process in ((HOST, 2**22 + 1), (HOST, os.getppid()), ("moon", 1))
    )
    for folder in (dead, alive, elsewhere):
        folder.mkdir(parents=True)
    (dead / "result.json").write_text("{}")
    assert len(stand.run().rows) == 4
    assert [path.exists() for path in (dead, alive, elsewhere)] == [False, True, True]


def test_shards_share_the_work_and_are_collected(stand) -> None:
    first = stand.run(batch_options=BatchOptions(shard="1/2"))
    assert statuses(first) == {"a": "good", "broken": "failed"}
    assert not (stand.out / "summary.csv").exists()
    half = collect_batch(stand.out)
    assert (half.waiting, half.all_answered) == (("b", "c"), False)
    stand.run(batch_options=BatchOptions(shard="2/2"))
    assert stand.asked == ["b.ply", "c.ply"]
    result = collect_batch(stand.out)
    assert statuses(result) == {"a": "good", "b": "good", "broken": "failed", "c": "good"}
    assert (stand.out / "gallery.html").exists()
    stand.run()
    assert stand.asked == []
    stand.run(options=MatchOptions(seed=1), batch_options=BatchOptions(shard="1/2"))
    assert collect_batch(stand.out).waiting == ("b", "c")  # with other options they have no answer
    with pytest.raises(InputError, match="holds no batch"):
        collect_batch(stand.folder)


@pytest.mark.parametrize("text", ["0/2", "3/2", "2", "a/b", "-1/2"])
def test_a_shard_that_does_not_exist_is_refused(text) -> None:
    with pytest.raises(InputError, match="shard"):
        BatchOptions(shard=text)


def test_two_processes_in_one_folder(stand) -> None:
    """The second is refused, unless it does another share."""

    def start_another(_name: str) -> None:
        stand.before = lambda _: None
        with pytest.raises(OutputError, match=r"process \d+ on \w+ works on it"):
            stand.run()

    stand.before = start_another
    assert len(stand.run().rows) == 4


def test_others_files_are_not_touched(stand) -> None:
    stand.out.mkdir()
    (stand.out / "thesis.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"holds thesis\.txt and no batch"):
        stand.run()
    stand.run(batch_options=BatchOptions(overwrite=True))
    assert (stand.out / "thesis.txt").read_text() == "mine"
    mine = stand.out / "parts" / "d"
    mine.mkdir()
    (mine / "report.html").write_text("mine")
    shutil.copy(stand.folder / "scans" / "a.ply", stand.folder / "scans" / "d.ply")
    rows = stand.run().rows
    assert (rows[-1].failure, (mine / "report.html").read_text()) == ("not written", "mine")


def test_options_of_one_part_are_refused_for_many(stand) -> None:
    with pytest.raises(OptionError, match="those of one part"):
        stand.run(options=MatchOptions(ignore=(1,)))
    with pytest.raises(OptionError, match="give one"):
        stand.run(jobs=2)
