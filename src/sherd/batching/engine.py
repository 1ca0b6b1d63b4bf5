"""outcomes: many tasks computed by any executor, a few at a time, in the order they finish."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from concurrent.futures.process import BrokenProcessPool
from queue import Empty, SimpleQueue
from typing import Protocol, TypeVar

from sherd.errors import SherdError

__all__ = ["KILLED", "finished_tasks"]

# A task whose process was killed may have died for another's hunger: it is asked once more.
ATTEMPTS = 2
KILLED = "its process was killed, most likely out of memory; decimate the mesh, or use fewer jobs"
# How often to look up while nothing finishes; some systems hear Ctrl-C only then.
SECONDS = 1.0


class Named(Protocol):
    """A task."""

    @property
    def name(self) -> str:
        """Unique among all tasks."""
        ...


Task = TypeVar("Task", bound=Named)
Result = TypeVar("Result")


def finished_tasks(
    tasks: Iterable[Task],
    work: Callable[[Task], Result],
    executor: Executor,
    *,
    window: int,
    idle: Callable[[], None] = lambda: None,
) -> Iterator[tuple[Task, Result | Exception]]:
    """Each task with its result, or with the error that its process ended in.

    Parameters
    ----------
    tasks
        Taken one by one, when there is room for them.
    work
        Called with a task, in whatever process or machine the executor chooses.
    executor
        Of any kind. Of one that survives the death of a worker, a task that died with its worker
        is tried again once.
    window
        How many tasks the executor has at a time.
    idle
        Called at least once a second, between results.

    Raises
    ------
    SherdError
        If the executor as a whole is broken.
    """
    left, again = iter(tasks), deque[Task]()
    running: dict[Future[Result], Task] = {}
    finished: SimpleQueue[Future[Result]] = SimpleQueue()
    attempts: Counter[str] = Counter()
    try:
        while True:
            while len(running) < window:
                task = again.popleft() if again else next(left, None)
                if task is None:
                    break
                attempts[task.name] += 1
                future = _submitted(executor, work, task)
                running[future] = task
                future.add_done_callback(finished.put)
            if not running:
                return
            try:
                future = finished.get(timeout=SECONDS)
            except Empty:
                idle()
                continue
            task = running.pop(future)
            error = _error(future)
            if error is not None and attempts[task.name] < ATTEMPTS and _died(error):
                again.append(task)
                continue
            del attempts[task.name]
            yield task, future.result() if error is None else error
            idle()
    finally:
        for future in running:
            future.cancel()


def _submitted(executor: Executor, work: Callable[[Task], Result], task: Task) -> Future[Result]:
    try:
        return executor.submit(work, task)
    except (BrokenExecutor, RuntimeError) as error:
        raise SherdError(
            f"the executor takes no more tasks ({error}); start again, what is finished is kept"
        ) from error


def _error(future: Future[Result]) -> Exception | None:
    try:
        error = future.exception()
    except CancelledError as cancelled:  # not by us: we cancel only when we leave
        raise SherdError(
            "the executor has dropped a task that it had taken, as one does that has lost its "
            "workers or its scheduler; start again, what is finished is kept"
        ) from cancelled
    if error is None or isinstance(error, Exception):
        return error
    raise error


def _died(error: Exception) -> bool:
    """Whether a worker is gone; names differ, but no task raises by itself."""
    return isinstance(error, BrokenProcessPool) or "Killed" in type(error).__name__
