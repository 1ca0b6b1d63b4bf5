"""Read back what `sherd fit` wrote."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sherd.report.stored.folder import FIT_FORMAT
from sherd.report.stored.reading import read_back, stored_points, stored_shape
from sherd.results.fitted.fit_options import FitOptions
from sherd.results.fitted.fit_result import Fit, FitCheck, FittedPiece, HiddenRegion
from sherd.results.status import Status

__all__ = ["read_fit"]


def read_fit(folder: str | os.PathLike[str]) -> Fit:
    """Read the output folder of `sherd fit`: all that the result said, to the printed digits.

    Raises
    ------
    InputError
        If the folder is missing, holds no fit, or mixes the files of two runs.

    Examples
    --------
    >>> read_fit("nowhere")
    Traceback (most recent call last):
        ...
    sherd.errors.InputError: nowhere holds no result.json: nothing was finished there; run again
    """
    return read_back(folder, {FIT_FORMAT: _fit}, "a fit")


def _fit(path: Path, document: Mapping[str, Any]) -> Fit:
    table = np.genfromtxt(path / "fit.csv", delimiter=",", names=True)
    return Fit(
        full=stored_shape(path / "full.ply", document["full"]),
        pieces=tuple(
            _piece(path / f"piece_{number}", facts)
            for number, facts in enumerate(document["pieces"])
        ),
        positions=np.column_stack([table[axis] for axis in "xyz"]),
        seen=table["seen"] > 0,
        chance=table["chance"],
        distances=table["distance"],
        strain=table["strain"],
        sizes=table["size"],
        check=FitCheck(**document["check"]),
        hidden=tuple(HiddenRegion(**region) for region in document["hidden"]),
        status=Status[document["status"].upper()],
        advice=document["advice"],
        timings=document["timings"],
        options=FitOptions(**document["options"]),
        version=document["version"],
        notices=tuple(document["full"]["notices"]),
    )


def _piece(path: Path, facts: Mapping[str, Any]) -> FittedPiece:
    table = np.genfromtxt(path / "distances.csv", delimiter=",", names=True)
    weights = np.column_stack([table[f"b{k}"] for k in range(3)])
    return FittedPiece(
        part=stored_shape(path / "part.ply", facts),
        points=stored_points(table["face"], weights),
        matched=table["matched"] > 0,
        distances=table["distance"],
        scale=float(facts["scale"]),
    )
