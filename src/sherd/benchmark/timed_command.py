"""Time and memory of a command line, in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from sherd.errors import SherdError

__all__ = ["THIS", "Timing", "timed"]

# This very installation, as a command.
THIS = (sys.executable, "-m", "sherd")


@dataclass(frozen=True)
class Timing:
    """One run: wall and CPU seconds, and the largest resident memory in gigabytes."""

    wall_seconds: float
    cpu_seconds: float
    peak_gigabytes: float


def timed(command: Sequence[str], *, environment: Mapping[str, str] | None = None) -> Timing:
    """Run a command of sherd to its end, with `environment` added to that of this process.

    Raises
    ------
    SherdError
        If it cannot be started or ends in an error.
    """
    variables = {**os.environ, **(environment or {})}
    start = time.perf_counter()
    try:
        process = subprocess.Popen(  # noqa: S603 - no shell; the user named the command
            command, env=variables, stdout=subprocess.DEVNULL
        )
    except OSError as error:
        raise SherdError(
            f"{command[0]}: cannot be started ({error.strerror}); name a command such as "
            "other/.venv/bin/sherd"
        ) from error
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - start
    code = process.returncode = os.waitstatus_to_exitcode(status)
    if code not in (0, 4):  # done, or done with doubts
        raise SherdError(f"{' '.join(command)} ended with exit code {code}")
    # Linux counts kibibytes, macOS bytes
    unit = 1 if sys.platform == "darwin" else 1024
    return Timing(wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * unit / 1e9)
