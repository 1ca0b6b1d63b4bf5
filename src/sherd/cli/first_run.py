"""The first run of a version: its loops are compiled, by two processes where there are two cores.

A run meets the loops in the order of its stages. Another process begins with those of the last
stages, on a shape of a few triangles, and leaves them where the first one finds them.
"""

from __future__ import annotations

import os
import subprocess
import sys

import click

__all__ = ["prepare_first_run", "rehearse"]

# Nobody waits for it: what it has compiled when it is needed is of use, the rest next time. It is
# kept here, as Python warns of processes that are forgotten while they run.
_beside: list[subprocess.Popen[bytes]] = []


def prepare_first_run(*, quiet: bool) -> None:
    """Say that loops have to be compiled, and begin to, if this version never ran here."""
    # loads slowly, and is not needed for help
    from sherd.compiled import cache_folder  # noqa: PLC0415

    folder = cache_folder()
    if folder is None or next(folder.rglob("*.nbi"), None) is not None:
        return
    if not quiet:
        click.echo(
            "note: first run of this version: its loops are compiled, which takes about half a "
            "minute once",
            err=True,
        )
    if (os.cpu_count() or 1) > 1:
        _beside.append(
            subprocess.Popen(
                [sys.executable, "-c", "from sherd.cli.first_run import rehearse; rehearse()"],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
        )


def rehearse() -> None:
    """Call the compiled loops of the later stages of a match with little to do."""
    from sherd.correspondence.rehearsal import rehearsed_placement  # noqa: PLC0415
    from sherd.drawing.exhibit import Exhibit  # noqa: PLC0415
    from sherd.drawing.picture import picture  # noqa: PLC0415

    ball = rehearsed_placement()
    picture(Exhibit("rehearsal", ball, ball))
