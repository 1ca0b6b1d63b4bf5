"""SHREC'16 partial matching with :func:`sherd.match.match`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from sherd.benchmark.datasets import shrec16_pairs
from sherd.benchmark.match_benchmark import match_benchmark
from sherd.benchmark.match_row import BenchmarkSettings
from sherd.errors import OptionError

__all__ = ["shrec16_benchmark"]

KINDS = ("cuts", "holes")


def shrec16_benchmark(
    directory: Path,
    *,
    output: Path,
    kinds: tuple[str, ...] = KINDS,
    settings: BenchmarkSettings | None = None,
    remeshed: Path | None = None,
    only: tuple[str, ...] = (),
    jobs: int = 1,
) -> dict[str, Any]:
    """Match all pairs, write ``bench.json`` to `output`, and return its content.

    Parameters
    ----------
    directory
        Folder of SHREC'16 with ``null``, ``cuts`` and ``holes``.
    output, settings, jobs
        See :func:`sherd.benchmark.match_benchmark.match_benchmark`.
    kinds
        ``"cuts"``, ``"holes"`` or both.
    remeshed
        Folder with the parts meshed anew.
    only
        Names of the parts to measure; all if empty.

    Raises
    ------
    MeshFileError
        If a file is missing or damaged.
    OptionError
        If a kind is unknown or none is given, or `jobs` is below 1.
    """
    if not kinds or set(kinds) - set(KINDS):
        raise OptionError(f'kinds is {kinds}, but "cuts" and "holes" can be measured')
    sources = [
        pair
        for kind in kinds
        for pair in shrec16_pairs(directory, kind=kind, remeshed=remeshed)
        if not only or pair.name in only
    ]
    words = {
        "title": "SHREC'16",
        "data": "SHREC'16 training set; the method is not trained",
        "meshes": "as stored" if remeshed is None else "remeshed",
    }
    return match_benchmark(
        sources, output, settings=settings or BenchmarkSettings(), words=words, jobs=jobs
    )
