"""Compiled loops over rows, on all cores: one slice of the rows for each thread.

Numba's own parallel loops take three times as long to compile, and depending on the machine end
the process when two threads call them at once.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any

__all__ = ["over_rows", "set_thread_count", "thread_count"]

# So that no core waits long for the slowest slice; a slice costs 20 microseconds.
SLICES_PER_THREAD = 4

_limit: list[int] = []


def thread_count() -> int:
    """How many threads work at once: as many as cores, or NUMBA_NUM_THREADS of the environment."""
    if not _limit:
        import numba  # loads slowly  # noqa: PLC0415

        _limit.append(int(numba.config.NUMBA_NUM_THREADS))  # type: ignore[attr-defined]
    return _limit[0]


def set_thread_count(count: int) -> None:
    """Let fewer threads work, as when several processes share the cores."""
    _limit[:] = [count]


def over_rows(kernel: Callable[..., None], count: int, *arguments: Any) -> None:
    """Call `kernel((start, stop), *arguments)` for slices that make up the rows 0 to `count`.

    Parameters
    ----------
    kernel
        Compiled with ``nogil=True``. It writes into its arguments, for each row something that
        does not depend on other rows, so that the slices do not matter.
    count
        Number of rows.
    """
    threads = thread_count()
    slices = min(SLICES_PER_THREAD * threads, count)
    if threads == 1 or slices <= 1:
        kernel((0, count), *arguments)
        return
    bounds = [count * k // slices for k in range(slices + 1)]
    with ThreadPoolExecutor(threads) as pool:
        work = [pool.submit(kernel, rows, *arguments) for rows in pairwise(bounds)]
    for done in work:
        done.result()
