"""The robustness table tells refusals from failures; each command is a process of its own."""

from __future__ import annotations

import csv
import json
import sys

import pytest

from sherd.benchmark.robustness import check_command, robustness


def python(program):
    return lambda mesh, output: [sys.executable, "-c", program, str(mesh), str(output)]


WRITING = "import pathlib, sys; out = pathlib.Path(sys.argv[2]); out.mkdir(); "
PROGRAMS = {
    "": "print('fine')",
    "traceback": "1 / 0",
    "exit code 70": "raise SystemExit(70)",
    "killed by signal 9": "import os; os.kill(os.getpid(), 9)",
    "no answer within 2 s": "import time; time.sleep(30)",
    "refused without a word": "raise SystemExit(3)",
    "refused in more than one line": "import sys; print('a\\nb', file=sys.stderr); sys.exit(3)",
    "refused, but left a.txt": WRITING + "(out / 'a.txt').touch(); print('no'); sys.exit(3)",
    "left the half-written .a.partial": WRITING + "(out / '.a.partial').touch()",
    "a.csv holds 'nan'": WRITING + "(out / 'a.csv').write_text('x,y\\n1,nan\\n')",
    "a.json holds 'NaN'": WRITING + "(out / 'a.json').write_text('[NaN]')",
    "a.ply cannot be read back": WRITING + "(out / 'a.ply').write_text('ply')",
    "holds no result.json": WRITING + "[(out / name).touch() for name in ('a.txt', 'b.txt')]",
}


@pytest.mark.parametrize("failure", list(PROGRAMS))
def test_each_kind_of_failure_is_told(tmp_path, failure):
    folder = tmp_path / "meshes"
    folder.mkdir()
    (folder / "a.off").write_text("anything")
    (row,) = robustness(
        folder, tmp_path / "out", commands={"run": python(PROGRAMS[failure])}, seconds=2
    )
    assert failure in row.failure
    assert bool(failure) == bool(row.failure)
    assert row.verdict == ("failed" if failure else "done")


def test_words_that_only_contain_nan_are_no_failure(tmp_path):
    folder = tmp_path / "meshes"
    folder.mkdir()
    (folder / "banana.off").write_text("")
    program = WRITING + "(out / 'a.csv').write_text('nana,info.inf,finance\\n')"
    (row,) = robustness(folder, tmp_path / "out", commands={"run": python(program)})
    assert row.failure == ""


def test_an_interrupted_run_goes_on(tmp_path):
    folder = tmp_path / "meshes"
    folder.mkdir()
    for name in ("a.off", "b.off", "c.off"):
        (folder / name).write_text(name)
    failing = "import sys; sys.exit(70 if 'b.off' in sys.argv[1] else 0)"
    jobs = {"run": python(failing)}
    first = robustness(folder, tmp_path / "out", commands=jobs)
    (folder / "c.off").write_text("changed")
    seen = []
    second = robustness(folder, tmp_path / "out", commands=jobs, progress=seen.append)
    assert [row.file for row in seen] == ["b.off", "c.off"]  # failed, and other content
    assert second[0] == first[0]
    robustness(folder, tmp_path / "out", commands=jobs, seconds=30, progress=seen.append)
    assert len(seen) == 5  # another limit: all anew


def test_check_says_what_is_wrong_and_the_table_is_written(tmp_path):
    folder = tmp_path / "meshes" / "deep"
    folder.mkdir(parents=True)
    good = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n"
    (folder / "flipped.off").write_text(good.replace("3 0 2 3", "3 0 3 2"))
    (folder / "short.off").write_text(good[:-10])
    (folder / "notes.md").write_text("skipped")
    seen = []
    rows = robustness(
        folder.parent, tmp_path / "out", commands={"check": check_command}, progress=seen.append
    )
    assert seen == rows
    assert [(row.file, row.verdict, row.exit_code) for row in rows] == [
        ("deep/flipped.off", "done", 0),
        ("deep/short.off", "refused", 3),
    ]
    assert rows[0].wrong.startswith("1 face turned against the neighbors")
    assert "short.off: the header promises 4 vertices and 2 faces" in rows[1].said
    with (tmp_path / "out" / "robustness.csv").open() as stream:
        assert [row["file"] for row in csv.DictReader(stream)] == [row.file for row in rows]
    content = json.loads((tmp_path / "out" / "robustness.json").read_text())
    assert content["total"] == {"done": 1, "refused": 1, "failed": 0}
