"""Options that several commands have."""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from sherd.scan.either_side import SIDES

__all__ = [
    "json_option",
    "overwrite_option",
    "quiet_option",
    "seed_option",
    "side_option",
    "template_option",
]

template_option = click.option(
    "--template",
    type=click.Path(path_type=Path),
    help="File (.npz) that keeps what depends on FULL alone: made if missing, used if there.",
)

overwrite_option = click.option(
    "--overwrite",
    is_flag=True,
    help="Replace what another command or other files left in the folder.",
)


json_option = click.option(
    "--json", "as_json", is_flag=True, help="Print result.json on standard output."
)

seed_option = click.option("--seed", type=int, default=0, show_default=True)


def side_option(whose: str = "PART") -> Callable[[Any], Any]:
    """`--side`, of the faces of a part, or of what else is called a part."""
    return click.option(
        "--side",
        type=click.Choice(SIDES),
        default="either",
        show_default=True,
        help=f"Given: the faces of {whose} look outward.",
    )


def quiet_option(text: str = "Print errors only.") -> Callable[[Any], Any]:
    """`-q`, which silences warnings of the log as well."""
    return click.option("-q", "--quiet", is_flag=True, help=text, callback=_silenced)


def _silenced(_context: click.Context, _option: click.Parameter, quiet: bool) -> bool:  # noqa: FBT001
    if quiet:
        logging.getLogger("sherd").setLevel(logging.ERROR)
    return quiet
