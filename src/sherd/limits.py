"""Limits of numbers that users choose, each refused with a reason, and of memory."""

from __future__ import annotations

import math
import numbers
import os
from pathlib import Path

from sherd.errors import OptionError

__all__ = [
    "SEED_REASON",
    "available_memory",
    "require_finite",
    "require_memory",
    "require_seed",
    "require_whole",
]

LARGEST_SEED = 2**53 - 1
SEED_REASON = "larger ones are not read back exactly from result.json by every program"


def require_whole(name: str, value: object, least: int, most: int, reason: str) -> None:
    """Refuse what is no whole number from `least` to `most`.

    Raises
    ------
    OptionError
        With the limits and the reason of the upper one.
    """
    whole = isinstance(value, numbers.Integral) and not isinstance(value, bool)
    if not (whole and least <= int(str(value)) <= most):
        raise OptionError(
            f"{name} is {value!r}, but a whole number >= {least} and <= {most} is needed: {reason}"
        )


def require_seed(value: object) -> None:
    """Refuse what cannot be a seed.

    Raises
    ------
    OptionError
        If it is no whole number that every reader of ``result.json`` knows exactly.
    """
    require_whole("seed", value, 0, LARGEST_SEED, SEED_REASON)


def require_finite(name: str, value: object, least: float, most: float, reason: str) -> None:
    """Refuse what is no finite number from `least` to `most`.

    Raises
    ------
    OptionError
        With the limits and the reason.
    """
    real = isinstance(value, numbers.Real) and not isinstance(value, bool)
    if not (real and math.isfinite(number := float(value)) and least <= number <= most):  # type: ignore[arg-type]
        raise OptionError(
            f"{name} is {value}, but a finite number >= {least:g} and <= {most:g} is needed: "
            f"{reason}"
        )


def require_memory(size: int, what: str, remedy: str) -> None:
    """Refuse work whose arrays of `size` bytes would not fit into what is free now.

    Raises
    ------
    OptionError
        With both sizes and the remedy. Where the system does not say what is free, never.
    """
    free = available_memory()
    if free is not None and size > free:
        raise OptionError(
            f"{what} needs about {size / 1e9:.1f} GB of memory, but {free / 1e9:.1f} GB are free; "
            f"{remedy}"
        )


def available_memory() -> int | None:
    """Bytes that can be taken without swapping, or None where the system does not say.

    In a container, what its limit leaves.
    """
    found = []
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        found += [1024 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable:")]
    except (OSError, ValueError):
        if hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names:
            found.append(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    group = Path("/sys/fs/cgroup")
    try:
        limit, used = (int((group / f"memory.{n}").read_text()) for n in ("max", "current"))
        # what is used holds the cache of files as well, which is given back on demand
        facts = (line.split() for line in (group / "memory.stat").read_text().splitlines())
        cached = next((int(value) for name, value in facts if name == "inactive_file"), 0)
        found.append(max(0, limit - used + cached))
    except (OSError, ValueError):
        pass  # no limit, or no control groups
    return min(found, default=None)
