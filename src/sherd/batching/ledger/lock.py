"""One process a share of a batch: the second one is refused, and the killed one is no obstacle."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from sherd.batching.ledger.journal import JOURNALS
from sherd.batching.ledger.place import HOST
from sherd.batching.parts import Share
from sherd.errors import OutputError
from sherd.output import reported

__all__ = ["lock_of", "locked"]


def lock_of(folder: Path, share: Share | None) -> contextlib.AbstractContextManager[None]:
    """Held by the process that works on a share of the batch in a folder, or on all of it.

    Raises
    ------
    OutputError
        When entered, if another process does.
    """
    if share is None:
        return locked(folder / JOURNALS / "batch.lock", "it")
    name = f"shard-{share.index}-of-{share.count}"
    return locked(folder / JOURNALS / f"{name}.lock", f"shard {share.index}/{share.count}")


@contextlib.contextmanager
def locked(path: Path, what: str) -> Iterator[None]:
    """Hold the file `path` while the block runs.

    The system lets go of it when the process ends in whatever way. Where it has no such locks, or
    the file system none, nothing is held: two processes then do the same work twice, and each
    folder is still moved into place as a whole.

    Raises
    ------
    OutputError
        If another process holds it, or it cannot be made.
    """
    try:
        import fcntl  # not on every system  # noqa: PLC0415
    except ImportError:
        yield
        return
    with reported(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        stream = path.open("a+", encoding="utf-8")
    with stream:
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            stream.seek(0)
            who = stream.read().strip() or "another process"
            raise OutputError(
                f"{path.parent.parent}: {who} works on {what}; wait for it, or share the work "
                "with --shard"
            ) from error
        except OSError:
            pass  # a file system without locks
        stream.truncate(0)
        stream.write(f"process {os.getpid()} on {HOST}")
        stream.flush()
        yield
