"""Atomic files and progress by stage.

A file is written under a temporary name in its own folder and renamed when it is complete, so
a reader sees the old file or the new one and never half of either.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import logging
import os
import secrets
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from tqdm import tqdm

from sherd.errors import OutputError

__all__ = ["ResultFolder", "Stages", "replacing", "write_bytes", "write_text"]

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
        with _reported(target):
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


class ResultFolder:
    """Files that belong together: all are staged first, then renamed, ``result.json`` last.

    ``result.json`` names every other file with its SHA-256, so a folder that holds files of two
    runs is recognized. Use as a context manager; leaving the block without :meth:`finish` removes
    what was staged, and the folder too if it was made here and is empty.

    Parameters
    ----------
    path
        The folder; made when missing.

    Raises
    ------
    OutputError
        From any method, if the disk refuses; what stood there before is untouched unless the
        disk fails between two renames, which the hashes reveal.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self._made: list[Path] = []
        self._staged: dict[str, Path] = {}
        self._hashes: dict[str, str] = {}

    def __enter__(self) -> Self:
        with _reported(self.path):
            missing = [p for p in (self.path, *self.path.parents) if not p.exists()]
            self.path.mkdir(parents=True, exist_ok=True)
            self._made = missing
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for temporary in self._staged.values():
            with contextlib.suppress(OSError):
                temporary.unlink()
        for folder in self._made:
            with contextlib.suppress(OSError):
                folder.rmdir()  # fails, as it should, unless empty

    def add(self, name: str, content: bytes | str) -> None:
        """Stage one file; text is written as UTF-8."""
        data = content.encode("utf-8") if isinstance(content, str) else content
        temporary = self.path / f".{name}-{secrets.token_hex(4)}.partial"
        self._staged[name] = temporary
        self._hashes[name] = hashlib.sha256(data).hexdigest()
        with _reported(self.path / name):
            _write_through(temporary, data)

    def finish(self, result: dict[str, Any]) -> dict[str, Any]:
        """Rename all staged files and write ``result.json``: `result` plus ``files``."""
        document = {**result, "files": dict(sorted(self._hashes.items()))}
        self.add("result.json", json.dumps(document, indent=2, allow_nan=False) + "\n")
        for name, temporary in list(self._staged.items()):
            with _reported(self.path / name):
                temporary.replace(self.path / name)
            del self._staged[name]
        return document


@contextlib.contextmanager
def _reported(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise OutputError(
            f"{path}: cannot be written ({reason}); choose another folder or free some space"
        ) from error


def _write_through(path: Path, data: bytes) -> None:
    with path.open("wb") as stream:
        stream.write(data)
        stream.flush()
        os.fsync(stream.fileno())  # the bytes reach the disk before the name does


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
        # tqdm's disable=None means: quiet unless standard error is a terminal
        self._bar = tqdm(
            total=expected or None,
            disable=None if visible is None else not visible,
            file=sys.stderr,
            leave=False,
            bar_format="{desc:<28}|{bar:24}| {n_fmt}/{total_fmt} {elapsed}",
        )

    @contextlib.contextmanager
    def __call__(self, name: str) -> Iterator[None]:
        """Time the block as stage `name`; a repeated name adds up."""
        self._bar.set_description_str(name)
        start = time.perf_counter()
        try:
            yield
        finally:
            elapsed = time.perf_counter() - start
            self.seconds[name] = self.seconds.get(name, 0.0) + elapsed
            logger.debug("%s: %.3f s", name, elapsed)
            self._bar.update(1)

    def close(self) -> None:
        """Take the bar off the terminal."""
        self._bar.close()
