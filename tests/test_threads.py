"""over_rows: every row once, errors reach the caller, and match from several threads at once."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import threading
import time
import weakref
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from sherd.assemble import assemble
from sherd.errors import InfeasibleError
from sherd.locate import locate
from sherd.match import match
from sherd.overlap import overlap
from sherd.shapes.creature import creature
from sherd.shapes.fragment import cut_by_ball, whole
from sherd.surface.template import Template
from sherd.threads import (
    begun,
    cached_property,
    one_blas_thread,
    over_rows,
    search_threads,
    set_thread_count,
    side_by_side,
    thread_count,
)


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


def test_a_search_takes_as_many_threads_as_may_work_if_it_is_long(threads: int) -> None:
    assert search_threads(10) == 1
    assert search_threads(10_000) == threads


def test_threads_are_made_once(threads: int) -> None:
    seen = set()

    def kernel(rows: tuple[int, int]) -> None:
        seen.add(threading.get_ident())
        time.sleep(0.001)

    for _ in range(30):
        over_rows(kernel, 100)
    assert len(seen) <= threads


def test_callers_that_are_all_busy_do_not_wait_for_each_other() -> None:
    """A kernel that calls again has nobody left to help it."""
    usual = thread_count()
    set_thread_count(2)

    def inner(rows: tuple[int, int], out: np.ndarray) -> None:
        out[rows[0] : rows[1]] += 1

    def outer(rows: tuple[int, int], out: np.ndarray) -> None:
        for row in range(*rows):
            over_rows(inner, out.shape[1], out[row])

    visited = np.zeros((20, 50), dtype=int)
    over_rows(outer, 20, visited)
    set_thread_count(usual)
    assert (visited == 1).all()


def test_what_is_taken_back_from_a_busy_pool_is_let_go() -> None:
    usual = thread_count()
    set_thread_count(2)
    done = threading.Event()
    busy = begun(done.wait)
    out = np.zeros(1000)
    kept = weakref.ref(out)
    over_rows(lambda rows, out: out.fill(len(rows)), 1000, out)
    assert out.sum() == 2000
    del out
    gc.collect()
    assert kept() is None
    done.set()
    assert busy()
    set_thread_count(usual)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system cannot fork")
def test_a_forked_child_makes_its_own_threads() -> None:
    code = (
        "import os, sys, numpy as np\n"
        "from sherd.threads import over_rows, set_thread_count\n"
        "set_thread_count(2)\n"
        "def kernel(rows, out): out[rows[0]:rows[1]] += 1\n"
        "def all_once():\n"
        "    out = np.zeros(100); over_rows(kernel, 100, out); return (out == 1).all()\n"
        "assert all_once()\n"
        "child = os.fork()\n"
        "if child == 0: os._exit(0 if all_once() else 1)\n"
        "sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], timeout=60, capture_output=True, check=False
    )
    assert done.returncode == 0, done.stderr


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


@pytest.mark.parametrize("count", [0, 1, 2, 7])
def test_works_side_by_side_give_their_results_in_order(threads: int, count: int) -> None:
    assert side_by_side([partial(pow, number, 2) for number in range(count)]) == [
        number**2 for number in range(count)
    ]


def test_the_caller_works_beside_the_other_threads(threads: int) -> None:
    """Each waits until all threads are at work; if the caller only waited, it would be in vain."""
    together = threading.Barrier(threads, timeout=30)
    side_by_side([together.wait] * threads)


def blas_threads() -> set[int]:
    return {each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"}


def test_blas_obeys_whoever_asks_while_others_live_that_asked_before() -> None:
    finish_elsewhere()
    with threadpool_limits(2, user_api="blas"), ThreadPoolExecutor(1) as other:

        def seen() -> set[int]:
            with one_blas_thread():
                return blas_threads()

        assert other.submit(seen).result() == {1}
        assert blas_threads() == {2}
        assert seen() == {1}
        assert other.submit(seen).result() == {1}
        assert blas_threads() == {2}


def finish_elsewhere() -> None:
    """Wait until the other threads have nothing to do; an answer may have ended early."""
    together = threading.Barrier(thread_count(), timeout=60)
    waiting = [begun(together.wait) for _ in range(thread_count() - 1)]
    together.wait()
    for each in waiting:
        each()


@pytest.mark.parametrize(
    ("module", "inside", "asked"),
    [
        ("sherd.match", "placed_part", match),
        ("sherd.locate", "locate_by_voting", locate),
        ("sherd.overlap", "kept_shape", overlap),
        ("sherd.overlap", "two_way_labelings", overlap),
        ("sherd.assemble", "trials_alone", lambda full, part: assemble(full, [part])),
    ],
)
def test_sums_do_not_depend_on_the_number_of_threads(monkeypatch, module, inside, asked) -> None:
    """BLAS splits a sum over more than 10,000 numbers by threads, which changes its last digit."""

    def seen(*_: object, **__: object) -> None:
        raise InfeasibleError(f"threads of BLAS: {blas_threads()}")

    full = creature(5000)
    part = cut_by_ball(whole(full, full), 0, 0.5).mesh
    monkeypatch.setattr(sys.modules[module], inside, seen)
    finish_elsewhere()
    # on a machine of one core it is asked as well
    with threadpool_limits(2), pytest.raises(InfeasibleError, match=r"threads of BLAS: \{1\}"):
        asked(full, part)


class Slow:
    """Its value is there when that of another one is asked for as well."""

    def __init__(self, together: threading.Barrier) -> None:
        self.together = together
        self.asked = 0

    @cached_property
    def value(self) -> object:
        self.together.wait(timeout=10)
        self.asked += 1
        return object()


def test_properties_of_two_objects_are_computed_at_once() -> None:
    together = threading.Barrier(2)
    objects = [Slow(together), Slow(together)]
    with ThreadPoolExecutor(2) as pool:
        values = list(pool.map(lambda each: each.value, objects))
    assert [each.value for each in objects] == values
    assert [each.asked for each in objects] == [1, 1]


def test_threads_that_ask_one_object_get_one_value() -> None:
    slow = Slow(threading.Barrier(2))
    with ThreadPoolExecutor(2) as pool:
        first, second = pool.map(lambda _: slow.value, range(2))
    assert first is second
    assert slow.value is first
