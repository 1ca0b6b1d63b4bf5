"""workers: who computes a batch, and how much at a time."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from concurrent.futures import Executor

from sherd.batching.options import job_count
from sherd.batching.processes import IsolatedProcesses
from sherd.errors import OptionError

__all__ = ["workers"]

# An executor of others has so many tasks at a time: enough for a large cluster never to wait, and
# not so many that a hundred thousand lie in its memory.
FOREIGN_WINDOW = 1000


@contextlib.contextmanager
def workers(
    jobs: int | None, executor: Executor | None, memory: int | None, tasks: int
) -> Iterator[tuple[Executor, int]]:
    """An executor and how many tasks it has at a time; own processes end with the block.

    Parameters
    ----------
    jobs
        Own processes; as many as cores, or as memory is free for, if None.
    executor
        Someone else's, instead.
    memory
        Bytes that each own process may hold; an equal share of what is free if None.
    tasks
        How many there are.

    Raises
    ------
    OptionError
        If both are given, or jobs are out of range or need more memory than there is.
    """
    if executor is not None:
        if jobs is not None:
            raise OptionError("jobs are own processes, and an executor brings its own: give one")
        yield executor, FOREIGN_WINDOW
        return
    count, memory = job_count(jobs, memory)
    own = IsolatedProcesses(max(1, min(count, tasks)), memory=memory)
    try:
        yield own, own.jobs
    except BaseException:
        own.shutdown(cancel_futures=True)
        raise
    own.shutdown()
