"""Atomic files and progress by stage.

A file is written under a temporary name in its own folder and renamed when it is complete, so
a reader sees the old file or the new one and never half of either.
"""

from __future__ import annotations

import contextlib
import errno
import logging
import os
import secrets
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from sherd.errors import OutputError

if TYPE_CHECKING:
    from tqdm import tqdm

__all__ = ["Stages", "replacing", "reported", "require_writable", "write_bytes", "write_text"]

logger = logging.getLogger(__name__)


@contextlib.contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path beside `path`; rename it to `path` when the block ends well.

    The temporary name keeps the suffix of `path`, because libraries choose a format by it.

    Raises
    ------
    OutputError
        If the folder cannot be made, the file cannot be written, or the rename fails. The
        temporary file is removed and `path` is as it was.
    """
    target = Path(path)
    temporary = target.with_name(f".{target.stem}-{secrets.token_hex(4)}.partial{target.suffix}")
    try:
        with reported(target):
            target.parent.mkdir(parents=True, exist_ok=True)
            yield temporary
            with temporary.open("rb") as stream:
                os.fsync(stream.fileno())  # the bytes reach the disk before the name does
            temporary.replace(target)
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()


def write_bytes(path: str | os.PathLike[str], data: bytes) -> None:
    """Write `data` to `path` atomically; see :func:`replacing` for errors."""
    with replacing(path) as temporary:
        temporary.write_bytes(data)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write `text` as UTF-8 with Unix line ends to `path` atomically."""
    write_bytes(path, text.encode("utf-8"))


def require_writable(path: str | os.PathLike[str], *, folder: bool = False) -> None:
    """Refuse now what could not be written later; nothing is made.

    Parameters
    ----------
    path
        A file that is to be written, or a folder that files are to be written into.
    folder
        Which of both.

    Raises
    ------
    OutputError
        If something else has that name or the folder, or the nearest one that exists above it,
        takes no files.
    """
    target = Path(path)
    with reported(target):
        if not folder and target.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        nearest = target if folder else target.parent
        while not nearest.exists() and nearest != nearest.parent:
            nearest = nearest.parent
        with tempfile.TemporaryFile(dir=nearest):
            pass


@contextlib.contextmanager
def reported(path: Path) -> Iterator[None]:
    """Turn what the disk refuses into an OutputError that names `path`."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise OutputError(
            f"{path}: cannot be written ({reason}); choose another folder or free some space"
        ) from error


class Stages:
    """Times named stages in order and shows them as a progress bar on a terminal.

    Parameters
    ----------
    expected
        Number of stages the bar is drawn for; 0 when unknown. Entering more is no error.
    visible
        True or False to force the bar; None shows it only if standard error is a terminal.

    Examples
    --------
    >>> stages = Stages(visible=False)
    >>> with stages("eigenbasis"):
    ...     total = sum(range(10))
    >>> list(stages.seconds)
    ['eigenbasis']
    """

    def __init__(self, expected: int = 0, *, visible: bool | None = None) -> None:
        self.seconds: dict[str, float] = {}
        shown = sys.stderr.isatty() if visible is None else visible
        self._bar = _bar(expected) if shown else None

    @contextlib.contextmanager
    def __call__(self, name: str) -> Iterator[None]:
        """Time the block as stage `name`; a repeated name adds up."""
        self.show(name)
        start = time.perf_counter()
        try:
            yield
        finally:
            elapsed = time.perf_counter() - start
            self.seconds[name] = self.seconds.get(name, 0.0) + elapsed
            logger.debug("%s: %.3f s", name, elapsed)
            if self._bar is not None:
                self._bar.update(1)

    def show(self, what: str) -> None:
        """Say what a long stage is at; nothing where no bar is shown."""
        if self._bar is not None:
            self._bar.set_description_str(what)

    def close(self) -> None:
        """Take the bar off the terminal."""
        if self._bar is not None:
            self._bar.close()


def _bar(expected: int) -> tqdm[NoReturn]:
    from tqdm import tqdm  # most runs show none, and it takes .03 s  # noqa: PLC0415

    return tqdm(
        total=expected or None,
        file=sys.stderr,
        leave=False,
        bar_format="{desc:<28}|{bar:24}| {n_fmt}/{total_fmt} {elapsed}",
    )
