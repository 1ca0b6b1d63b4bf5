"""Work on all cores: compiled loops over rows, and one piece of work beside another.

Numba's own parallel loops take three times as long to compile, and depending on the machine end
the process when two threads call them at once.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from itertools import pairwise
from threading import Lock
from typing import Any, Generic, TypeVar, overload

__all__ = [
    "begun", "cached_property", "one_blas_thread", "over_rows", "search_threads",
    "set_thread_count", "side_by_side", "thread_count",
]  # fmt: skip

Result = TypeVar("Result")

# So that no core waits long for the slowest slice; a slice costs 20 microseconds.
SLICES_PER_THREAD = 4
# To start the threads of a search takes as long as one thread needs for 200 neighborhoods; five
# times as many are worth it.
SEARCHED_TOGETHER = 1000

_limit: list[int] = []


class cached_property(functools.cached_property[Result]):  # noqa: N801 - stands for another
    """Without the lock that all instances share in Python 3.11.

    With it two shapes that are described side by side wait for each other. Threads that ask one
    object at the same time may compute its value twice; all of them get the first.
    """

    @overload
    def __get__(self, instance: None, owner: Any = None) -> cached_property[Result]: ...
    @overload
    def __get__(self, instance: object, owner: Any = None) -> Result: ...
    def __get__(
        self, instance: object | None, owner: Any = None
    ) -> cached_property[Result] | Result:
        if instance is None:
            return self
        value = self.func(instance)
        first: Result = instance.__dict__.setdefault(str(self.attrname), value)
        return first


def thread_count() -> int:
    """How many threads work at once: as many as cores, or NUMBA_NUM_THREADS of the environment."""
    if not _limit:
        import numba  # loads slowly  # noqa: PLC0415

        _limit.append(int(numba.config.NUMBA_NUM_THREADS))  # type: ignore[attr-defined]
    return _limit[0]


def set_thread_count(count: int) -> None:
    """Let fewer threads work, as when several processes share the cores."""
    _limit[:] = [count]


def search_threads(count: int) -> int:
    """The `workers` of a search of scipy's k-d tree for the neighbors of so many places."""
    return thread_count() if count >= SEARCHED_TOGETHER else 1


def over_rows(kernel: Callable[..., None], count: int, *arguments: Any) -> None:
    """Call `kernel((start, stop), *arguments)` for slices that make up the rows 0 to `count`.

    Parameters
    ----------
    kernel
        Compiled with ``nogil=True``. It writes into its arguments, for each row something that
        does not depend on other rows, so that the slices do not matter.
    count
        Number of rows.

    Notes
    -----
    The calling thread works too, and takes back what no other thread has begun: callers in several
    threads, and a pool busy with their work, cost time but cannot wait for each other.
    """
    threads = thread_count()
    number = min(SLICES_PER_THREAD * threads, count)
    if threads == 1 or number <= 1:
        kernel((0, count), *arguments)
        return
    slices = iter(list(pairwise(count * k // number for k in range(number + 1))))

    def work() -> None:
        for rows in slices:  # taking the next of a list is atomic
            kernel(rows, *arguments)

    others = [_Given(work, threads - 1) for _ in range(min(threads, number) - 1)]
    try:
        work()
    finally:
        for other in others:
            if not other.taken_back():
                other.result()


def begun(work: Callable[[], Result]) -> Callable[[], Result]:
    """Begin `work` on another core, if there is one to spare, and return what waits for its result.

    Otherwise it is done when it is asked for, by whoever asks. It must not depend on what the
    caller does meanwhile; then the result is the same.
    """
    if thread_count() == 1:
        return work
    given = _Given(work, thread_count() - 1)
    return lambda: work() if given.taken_back() else given.result()


def side_by_side(works: Iterable[Callable[[], Result]]) -> list[Result]:
    """Do all of `works`, as many at a time as there are cores, and return their results in order.

    None may depend on another. The other threads take them from the front, so the calling thread
    asks from the back: it does what nobody has begun, and waits for the last ones only.
    """
    results = [begun(work) for work in works]
    return [result() for result in reversed(results)][::-1]


class _Given(Generic[Result]):
    """A work given to the pool of so many threads, which can be taken back until it is begun.

    The pool keeps what was taken back until a thread comes to it. What is left of it there is
    empty: its arrays would be kept for seconds, up to a quarter of the memory of a `match`.
    """

    def __init__(self, work: Callable[[], Result], threads: int) -> None:
        self._work = [work]
        self._future = _pool(threads).submit(self._begin)

    def _begin(self) -> Result:
        return self._work.pop()()

    def taken_back(self) -> bool:
        """Whether nobody has begun it; then nobody will."""
        back = self._future.cancel()
        if back:
            self._work.clear()
        return back

    def result(self) -> Result:
        """What it returns, when it is done."""
        return self._future.result()


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Let matrix products of all threads take one thread each.

    Their sums then have the same order on every machine, and at our sizes two threads are slower
    than one. The setting is global, so the last of several threads to leave takes it back.
    """
    with _making:
        if not _inside:
            from threadpoolctl import threadpool_limits  # noqa: PLC0415

            _take_control_of_blas()
            _limits.append(threadpool_limits(limits=1, user_api="blas"))
        _inside.append(None)
    try:
        yield
    finally:
        with _making:
            _inside.pop()
            if not _inside:
                _take_control_of_blas()
                _limits.pop().restore_original_limits()
                _take_control_of_blas()


def _take_control_of_blas() -> None:
    """Let the next thread that sets the number of BLAS's threads do so, whichever did before.

    Since threadpoolctl 3.8 OpenBLAS obeys only the first thread that ever set it, as long as that
    one lives: threads of our pool live on, and what others ask for is silently not done.
    """
    import threadpoolctl  # noqa: PLC0415

    blas: Any = getattr(threadpoolctl, "OpenBLASController", None)
    if hasattr(blas, "clear_controlling_thread"):
        blas.clear_controlling_thread(force=True)


# One for the life of the process: to make one takes longer than most of the work.
_pools: dict[int, ThreadPoolExecutor] = {}
_making = Lock()
_inside: list[None] = []
_limits: list[Any] = []


def _pool(threads: int) -> ThreadPoolExecutor:
    with _making:
        if threads not in _pools:
            _pools[threads] = ThreadPoolExecutor(threads, thread_name_prefix="sherd")
        return _pools[threads]


def _forget() -> None:
    """In a forked child the threads are gone, and the lock may have been held."""
    global _making  # noqa: PLW0603
    _pools.clear()
    _inside.clear()
    _limits.clear()
    _making = Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
