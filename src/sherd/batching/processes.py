"""Worker processes that end with their parent, and an executor that loses one call at most.

A worker that is killed takes with it all calls of a `ProcessPoolExecutor`, and nobody knows which
one it was. Here every worker is a pool of its own: its death costs the call that it had, and
another worker takes its place.
"""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context, parent_process
from typing import Any, ParamSpec, TypeVar

from sherd.errors import SherdError
from sherd.threads import set_thread_count

__all__ = ["IsolatedProcesses", "process_pool"]

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")

# A killed process is gone after milliseconds, unless it waits for a disk.
SECONDS_TO_END = 5.0


def process_pool(
    jobs: int, *, threads: int | None = 1, memory: int | None = None
) -> ProcessPoolExecutor:
    """A pool of `jobs` processes that end when this process does.

    Parameters
    ----------
    jobs
        Processes.
    threads
        Of each process; as many as cores if None.
    memory
        Bytes of data that each may hold, where the system can limit them; more is a MemoryError.
    """
    return ProcessPoolExecutor(
        jobs,
        mp_context=get_context("spawn"),
        initializer=_begin_worker,
        initargs=(threads, memory),
    )


class IsolatedProcesses(Executor):
    """An executor of worker processes of which each can die alone.

    Parameters
    ----------
    jobs
        Processes. If there are several, each runs on one thread.
    memory
        Bytes of data that each may hold, where the system can limit them; more is a MemoryError.

    Notes
    -----
    A call whose worker was killed ends with :class:`BrokenProcessPool`. The calls of others go on,
    and the next call finds a new worker. Not more than `jobs` calls are taken at a time: submit
    waits until a worker is free.

    Examples
    --------
    >>> with IsolatedProcesses(1) as workers:
    ...     workers.submit(abs, -3).result()
    3
    """

    def __init__(self, jobs: int, *, memory: int | None = None) -> None:
        self.jobs = jobs
        self._memory = memory
        self._threads = None if jobs == 1 else 1
        self._free: list[ProcessPoolExecutor | None] = [None] * jobs
        self._busy: dict[Future[Any], ProcessPoolExecutor] = {}
        self._pools: list[ProcessPoolExecutor] = []  # all, whatever was interrupted meanwhile
        self._change = threading.Condition()
        self._ever_started = False
        self._closed = False

    def submit(
        self,
        fn: Callable[Parameters, Result],
        /,
        *args: Parameters.args,
        **kwargs: Parameters.kwargs,
    ) -> Future[Result]:
        """Call `fn` in a free worker, waiting for one.

        Raises
        ------
        SherdError
            If no worker process ever came up.
        """
        with self._change:
            if self._closed:
                raise RuntimeError("these processes were shut down")
            while not self._free:
                self._change.wait()
            pool = self._free.pop()
        with _deaf_to_interrupts():  # a worker begins here, and never hears what we do not
            pool = pool or self._new_pool()
            future = pool.submit(fn, *args, **kwargs)
        with self._change:
            self._busy[future] = pool
        future.add_done_callback(self._give_back)
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:  # noqa: FBT001, FBT002
        """End all workers; with `cancel_futures` also those that compute."""
        with self._change:
            self._closed = True
            pools = list(self._pools)
        if not cancel_futures:
            for pool in pools:
                pool.shutdown(wait=wait)
            return
        workers = [worker for pool in pools for worker in (pool._processes or {}).values()]
        managers: list[Any] = [pool._executor_manager_thread for pool in pools]
        for pool in pools:
            pool.shutdown(wait=False, cancel_futures=True)
        for worker in workers:
            with contextlib.suppress(OSError, ValueError):
                worker.kill()
        for worker in workers if wait else ():
            worker.join(SECONDS_TO_END)
        for manager in managers if wait else ():
            if manager is not None:
                manager.join(SECONDS_TO_END)  # it gives back what the pool had of the system

    def _new_pool(self) -> ProcessPoolExecutor:
        pool = process_pool(1, threads=self._threads, memory=self._memory)
        self._pools.append(pool)
        if not self._ever_started:
            try:
                pool.submit(os.getpid).result()
            except BrokenProcessPool as error:
                with self._change:
                    self._free.append(None)
                    self._change.notify()
                raise SherdError(
                    "no worker process could be started; a program must begin its work under "
                    '`if __name__ == "__main__":`, as its workers import it'
                ) from error
            self._ever_started = True
        return pool

    def _give_back(self, future: Future[Any]) -> None:
        broken = not future.cancelled() and isinstance(future.exception(), BrokenProcessPool)
        with self._change:
            pool = self._busy.pop(future)
            if broken:
                self._pools.remove(pool)
            self._free.append(None if broken else pool)
            self._change.notify()


@contextlib.contextmanager
def _deaf_to_interrupts() -> Iterator[None]:
    """Let processes that begin in this block not hear Ctrl-C: their parent ends them."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin_worker(threads: int | None, memory: int | None) -> None:
    """What a worker does first: from now on it ends with its parent."""
    threading.Thread(target=_end_with_parent, name="sherd-parent", daemon=True).start()
    if threads is not None:
        set_thread_count(threads)
    if memory is not None:
        _limit_memory(memory)


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()  # a killed parent tells nobody, but its end of a pipe is closed
        os._exit(1)


def _limit_memory(size: int) -> None:
    """Let larger allocations fail here, before the system kills whatever process it likes."""
    try:
        import resource  # not on every system  # noqa: PLC0415
    except ImportError:
        return
    with contextlib.suppress(OSError, ValueError):
        _, most = resource.getrlimit(resource.RLIMIT_DATA)
        resource.setrlimit(resource.RLIMIT_DATA, (size, most))
