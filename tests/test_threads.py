"""over_rows: every row once, errors reach the caller, and match from several threads at once."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from sherd.match import match
from sherd.shapes.creature import creature
from sherd.shapes.fragment import cut_by_ball, whole
from sherd.surface.template import Template
from sherd.threads import over_rows, set_thread_count, thread_count


@pytest.fixture(params=[1, 3])
def threads(request: pytest.FixtureRequest) -> Iterator[int]:
    usual = thread_count()
    set_thread_count(request.param)
    yield request.param
    set_thread_count(usual)


@pytest.mark.parametrize("count", [0, 1, 2, 11, 12, 13, 1000])
def test_every_row_is_visited_once(threads: int, count: int) -> None:
    visited = np.zeros(count, dtype=int)

    def kernel(rows: tuple[int, int], out: np.ndarray) -> None:
        out[rows[0] : rows[1]] += 1

    over_rows(kernel, count, visited)
    assert (visited == 1).all()


def test_as_many_slices_as_threads_are_worked_on_at_once(threads: int) -> None:
    """Each waits until all threads are at work; one thread after the other waits in vain."""
    together = threading.Barrier(threads, timeout=30)

    def kernel(rows: tuple[int, int]) -> None:
        together.wait()

    over_rows(kernel, 1000)


def test_errors_reach_the_caller(threads: int) -> None:
    def kernel(rows: tuple[int, int]) -> None:
        if rows[1] == 100:
            raise ValueError("the last slice")

    with pytest.raises(ValueError, match="the last slice"):
        over_rows(kernel, 100)


def test_matches_at_the_same_time_are_those_one_after_the_other() -> None:
    template = Template(creature(5000))
    template.prepare()
    parts = [
        cut_by_ball(whole(creature(5000, pose=pose), template.full), 0, 0.4).mesh
        for pose in ("walk", "sit")
    ]
    alone = [match(template, part).points for part in parts]
    with ThreadPoolExecutor(2) as pool:
        together = list(pool.map(lambda part: match(template, part).points, parts))
    for one, two in zip(alone, together, strict=True):
        assert (one.faces == two.faces).all()
        assert np.array_equal(one.barycentric, two.barycentric)
