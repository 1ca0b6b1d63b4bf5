"""Reading a result folder back: is it whole, and plain values for its result.json."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sherd.result_folder import RESULT, inside_name

__all__ = [
    "ASSEMBLY_FORMAT",
    "FIT_FORMAT",
    "JOINED_FORMAT",
    "MATCH_FORMAT",
    "OVERLAP_FORMAT",
    "REGION_FORMAT",
    "folder_problems",
    "plain",
    "result_format",
]

# Of result.json; raise the number when a field changes its meaning.
MATCH_FORMAT = "sherd match 1"
REGION_FORMAT = "sherd region 1"
OVERLAP_FORMAT = "sherd overlap 1"
ASSEMBLY_FORMAT = "sherd assembly 1"
JOINED_FORMAT = "sherd assembly-alone 1"
FIT_FORMAT = "sherd fit 1"


def folder_problems(folder: str | os.PathLike[str]) -> tuple[str, ...]:
    """Say what is wrong with a result folder, one sentence each; empty if it is whole.

    A folder whose writing was interrupted, or of which a file was changed afterwards, is not.
    """
    target = Path(folder)
    try:
        result = json.loads((target / RESULT).read_text(encoding="utf-8"))
        hashes = dict(result["files"])
    except FileNotFoundError:
        return (f"{target} holds no {RESULT}: nothing was finished there; run again",)
    except (OSError, ValueError, KeyError, TypeError) as error:
        return (f"{target / RESULT} cannot be read ({error}); run again",)
    problems = []
    for name, expected in hashes.items():
        file = target / inside_name(str(name))
        if not file.is_file():
            problems.append(f"{name} is missing; run again")
        elif _sha256(file) != expected:
            problems.append(f"{name} does not belong to this {RESULT}; run again")
    return tuple(problems)


def result_format(folder: str | os.PathLike[str]) -> str:
    """What a folder holds, as its ``result.json`` says; empty if it says nothing."""
    try:
        result = json.loads((Path(folder) / RESULT).read_text(encoding="utf-8"))
        return str(result["format"])
    except (OSError, ValueError, KeyError, TypeError):
        return ""


def plain(value: Any) -> Any:
    """What JSON can say of a value: arrays become lists, NaN becomes None, others their text.

    Examples
    --------
    >>> plain({"score": np.float64("nan"), "counts": np.array([1, 2])})
    {'score': None, 'counts': [1, 2]}
    """
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    if value is None or isinstance(value, bool | int | float | str):
        return value
    return str(value)


def _sha256(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
