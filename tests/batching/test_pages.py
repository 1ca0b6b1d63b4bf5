"""The how-to page runs, as far as it does without a scheduler."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import distributed
import pytest

import sherd
from sherd.cli.exits import SOME_FAILED

# Of a, b, the broken one and c, every second one: the first share has the broken one.
SHARES = [SOME_FAILED, 0]
PAGE = (Path(__file__).parents[2] / "docs/howto/batch.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


@pytest.fixture
def named(stand, command):
    """The page calls the full shape template.ply."""
    (stand.folder / "whole.ply").rename(stand.folder / "template.ply")
    return command


def words_of(line: str) -> list[str]:
    words = shlex.split(line.split("||", maxsplit=1)[0])
    assert words.pop(0) == "sherd"
    return words


def test_the_job_array_does_all_shares_and_collects_them(named, stand) -> None:
    array, submit = blocks("sh")
    line = array.splitlines()[-1].replace("/20", "/2")
    tasks = [line.replace("$SLURM_ARRAY_TASK_ID", task) for task in ("1", "2")]
    assert [named(*words_of(task)).exit_code for task in tasks] == SHARES
    last = re.search(r'--wrap "(.*)"', submit)
    assert named(*words_of(last[1])).exit_code == SOME_FAILED  # one file is broken
    assert len(sherd.collect_batch(stand.out).rows) == 4


def test_the_rules_of_snakemake_do_the_same(named, stand) -> None:
    (rules,) = blocks("text")
    share, collect = re.findall(r'shell: "(.*)"', rules)
    lines = [
        share.format(wildcards=type("Wildcards", (), {"share": number})).replace("/20", "/2")
        for number in (1, 2)
    ]
    assert [named(*words_of(line)).exit_code for line in lines] == SHARES
    done = named(*words_of(collect.format()))
    assert (done.exit_code, (stand.folder / "out/summary.csv").exists()) == (SOME_FAILED, True)


def test_the_programs_run(named, stand, monkeypatch) -> None:
    """That with Dask on threads, as what answers here is not in other processes."""
    here = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "dashboard_address": None}
    cluster = distributed.LocalCluster
    monkeypatch.setattr("dask.distributed.LocalCluster", lambda **_: cluster(**here))
    first, second = blocks("py")
    exec(compile(first, "batch.md", "exec"), {"__name__": "__main__"})  # noqa: S102
    assert len(stand.asked) == 3
    (stand.folder / "out").rename(stand.folder / "first")
    exec(compile(second, "batch.md", "exec"), {"__name__": "__main__"})  # noqa: S102
    assert len(stand.asked) == 6
