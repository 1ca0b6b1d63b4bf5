"""What commands that measure the pairs of a data set have in common."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar

import click

from sherd.benchmark.datasets.pairs import BenchmarkSettings

__all__ = ["measuring"]

Pairs = TypeVar("Pairs")

OPTIONS = (
    click.argument("directory", type=click.Path(path_type=Path)),
    click.option("--rotate", is_flag=True, help="Turn them at random."),
    click.option("--unknown-scale", is_flag=True, help="Scale them by 0.5 to 2, untold."),
    click.option("--only", multiple=True, help="Names of pairs; all if none."),
    click.option("--pairs", "limit", type=int, help="First pairs only."),
    click.option("--jobs", type=int, default=1, show_default=True, help="Processes."),
    click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="Folder."),
)


def measuring(
    measure: Callable[..., str],
) -> Callable[[Callable[..., Pairs]], Callable[..., int]]:
    """Decorate what gives the pairs of a folder for settings: a command that measures them.

    `measure` is told the pairs, and by name `output`, `only`, `limit` and `jobs`; it returns what
    is to be said. The command has the common options, and those declared on what is decorated.
    """

    def decorate(pair_set: Callable[..., Pairs]) -> Callable[..., int]:
        @wraps(pair_set)
        def body(
            directory: Path,
            *,
            rotate: bool,
            unknown_scale: bool,
            only: tuple[str, ...],
            limit: int | None,
            jobs: int,
            output: Path,
            **own: Any,
        ) -> int:
            settings = BenchmarkSettings(rotate=rotate, unknown_scale=unknown_scale)
            pairs = pair_set(directory, settings, **own)
            click.echo(measure(pairs, output=output, only=only, limit=limit, jobs=jobs))
            return 0

        for option in reversed(OPTIONS):
            body = option(body)
        return body

    return decorate
