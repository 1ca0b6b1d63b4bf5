"""Fingerprint: which file it was, cheaply told apart by size and time, surely by its hash."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Self

__all__ = ["Fingerprint"]


@dataclass(frozen=True)
class Fingerprint:
    """Size, time of the last change, and SHA-256 of a file.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder, "a.txt")
    ...     _ = file.write_text("abc")
    ...     Fingerprint.of(file).still_of(file)
    True
    """

    size: int
    time: int
    sha256: str

    @classmethod
    def of(cls, path: str | os.PathLike[str]) -> Self:
        """Read the file.

        Raises
        ------
        OSError
            If it cannot be read.
        """
        with Path(path).open("rb") as stream:
            before = os.fstat(stream.fileno())
            digest = hashlib.file_digest(stream, "sha256").hexdigest()
        return cls(before.st_size, before.st_mtime_ns, digest)

    def looks_like(self, path: str | os.PathLike[str]) -> bool:
        """Whether size and time are those of the file now; it is not read."""
        try:
            status = os.stat(path)  # noqa: PTH116 - ten thousand of them
        except OSError:
            return False
        return (status.st_size, status.st_mtime_ns) == (self.size, self.time)

    def still_of(self, path: str | os.PathLike[str]) -> bool:
        """Whether the file is the same; it is read only if it was touched."""
        if self.looks_like(path):
            return True
        try:
            return Fingerprint.of(path).sha256 == self.sha256
        except OSError:
            return False
