"""The commands of sherd; each is loaded when it is called, so that help is instant."""

from __future__ import annotations

import atexit
import gc
import importlib
import sys
from typing import Any

import click

from sherd._version import __version__
from sherd.cli.exits import ReportingGroup

__all__ = ["main"]

# Seconds after which a thread that interprets lets another one do so. What computes on the other
# core does for moments only, and by default waits 5 ms for each while modules are loaded: with
# this a `locate` takes 4 % less (five runs each, in turn).
SWITCH = 2e-4

# Before Python ends it looks for garbage a last time, in everything that is about to go anyway:
# half of the 0.09 s between the last line of a `locate` and the prompt.
atexit.register(gc.freeze)

# name: (module, function, first line of its help, repeated here so that help loads nothing)
COMMANDS = {
    "match": ("sherd.cli.matching", "match_command", "Find the partner of every point of a piece."),
    "locate": ("sherd.cli.locating", "locate_command", "Find where a piece belongs on the whole."),
    "overlap": (
        "sherd.cli.overlapping",
        "overlap_command",
        "Find what two incomplete shapes share.",
    ),
    "assemble": (
        "sherd.cli.assembling",
        "assemble_command",
        "Find where all pieces of a puzzle belong.",
    ),
    "identify": (
        "sherd.cli.many.identifying",
        "identify_command",
        "Find which of several shapes a piece is of.",
    ),
    "template": (
        "sherd.cli.many.templates",
        "template_command",
        "Prepare full shapes once, as a library.",
    ),
    "batch": (
        "sherd.cli.batch.command",
        "batch_command",
        "Match many parts; goes on after any interruption.",
    ),
    "fit": ("sherd.cli.fitting", "fit_command", "Lay the whole onto the pieces, in their pose."),
    "view": ("sherd.cli.viewing", "view_command", "Open a report again, or draw it as PNG."),
    "transfer": (
        "sherd.cli.transferring",
        "transfer_command",
        "Carry labels, colors, landmarks and values over.",
    ),
    "landmarks": (
        "sherd.cli.many.landmarking",
        "landmarks_command",
        "Carry landmarks to many specimens, into one table.",
    ),
    "check": ("sherd.cli.checking", "check_command", "Say what is wrong with a mesh."),
    "demo": ("sherd.cli.demo", "demo_command", "See it work on a generated animal."),
    "bench": ("sherd.cli.bench.group", "bench_group", "Measure accuracy and speed."),
}


class _LazyGroup(ReportingGroup):
    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        if cmd_name not in COMMANDS:
            return None
        module, name, _ = COMMANDS[cmd_name]
        sys.setswitchinterval(SWITCH)
        # what a thousand modules make stays: to look for garbage in it is a tenth of their time
        gc.disable()
        try:
            command: click.Command = getattr(importlib.import_module(module), name)
            gc.freeze()
        finally:
            gc.enable()
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, _, text) in COMMANDS.items()])


@click.group(cls=_LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="sherd")
def main(**_: Any) -> None:
    """Partial matching of non-rigid 3D shapes.

    Where does a deformed, incomplete piece belong on the whole?

    \b
    Examples:
      sherd demo
      sherd match template.ply scan.ply -o out/
      sherd batch template.ply --parts scans/ -o out/
    """  # noqa: D301
