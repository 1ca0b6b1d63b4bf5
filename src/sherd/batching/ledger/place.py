"""The folder of one part: made under another name, moved into place when it is whole.

A temporary folder says in its name who makes it, so that the next run on the same machine can tell
what a killed process left from what another one is writing.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import re
import secrets
import shutil
import socket
from collections.abc import Iterator
from pathlib import Path

from sherd.output import reported
from sherd.result_folder import RESULT, inside_name

__all__ = ["HOST", "OUTCOME", "PARTS", "THUMBNAIL", "move_into_place", "remove_leftovers", "staged"]

PARTS = "parts"
# Files in the folder of a part that are the batch's, not the result's.
OUTCOME = "outcome.json"
THUMBNAIL = "thumbnail.webp"
HOST = re.sub(r"[^A-Za-z0-9]+", "_", socket.gethostname()) or "host"
TEMPORARY = re.compile(r"\..+\.(?P<host>\w+)\.(?P<process>\d+)\.[0-9a-f]{8}\.partial")
# What stands in the way is moved aside; more than once only if others write the same part.
TRIES = 5


@contextlib.contextmanager
def staged(target: Path) -> Iterator[Path]:
    """Yield a new folder beside `target`, which is gone when the block ends.

    Raises
    ------
    OutputError
        If it cannot be made.
    """
    folder = _temporary(target)
    with reported(target):
        folder.mkdir(parents=True)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def move_into_place(folder: Path, target: Path) -> None:
    """Give a whole folder its name; an older result there is replaced.

    Files there that are neither of the older result nor of the batch are kept.

    Raises
    ------
    OutputError
        If the disk refuses.
    """
    with reported(target):
        for attempt in range(TRIES):
            try:
                folder.rename(target)
            except OSError as error:
                taken = error.errno in (errno.ENOTEMPTY, errno.EEXIST, errno.EACCES)
                if not (taken and target.is_dir()) or attempt == TRIES - 1:
                    raise
            else:
                return
            aside = _temporary(target)
            with contextlib.suppress(FileNotFoundError):  # another process was faster
                target.rename(aside)
                _keep_others_files(aside, folder)
                shutil.rmtree(aside, ignore_errors=True)


def remove_leftovers(folder: Path) -> int:
    """Remove temporary folders of processes of this machine that have ended; say how many."""
    removed = 0
    for path in (folder / PARTS).glob(".*.partial"):
        found = TEMPORARY.fullmatch(path.name)
        if found and found["host"] == HOST and not _alive(int(found["process"])):
            shutil.rmtree(path, ignore_errors=True)
            removed += 1
    return removed


def _temporary(target: Path) -> Path:
    own = f"{HOST}.{os.getpid()}.{secrets.token_hex(4)}"
    return target.with_name(f".{target.name}.{own}.partial")


def _keep_others_files(old: Path, new: Path) -> None:
    try:
        document = json.loads((old / RESULT).read_text(encoding="utf-8"))
        named = {inside_name(name) for name in document["files"]}
    except (OSError, ValueError, KeyError, TypeError):
        named = set()
    for path in old.iterdir():
        ours = path.name in named | {RESULT, OUTCOME, THUMBNAIL}
        if not ours and not (new / path.name).exists():
            path.rename(new / path.name)


def _alive(process: int) -> bool:
    if os.name == "nt":
        return True  # to ask would end it
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True  # of another user
    return True
