"""The command line in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

SECONDS = 400  # the first run compiles its kernels


def _run(
    *arguments: object, modules: Path | None = None, **settings: str
) -> subprocess.CompletedProcess[str]:
    """`sherd` with these words.

    Environment variables are set besides the usual ones, and modules looked for in a folder first.
    """
    environment = {**os.environ, **settings}
    if modules is not None:
        usual = os.environ.get("PYTHONPATH")
        paths = [str(modules)] if usual is None else [str(modules), usual]
        environment["PYTHONPATH"] = os.pathsep.join(paths)
    return subprocess.run(
        [sys.executable, "-m", "sherd", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=SECONDS,
        env=environment,
        check=False,
    )


@pytest.fixture(scope="session")
def run() -> Callable[..., subprocess.CompletedProcess[str]]:
    """`run("locate", full, part, ..., VARIABLE="value")`: what was said and the exit code."""
    return _run
