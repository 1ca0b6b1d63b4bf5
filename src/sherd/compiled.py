"""`compiled()`: numba's compiler for our loops, with a cache that is found, safe and never stale.

Compiling takes some 15 s, so what was compiled is kept. Numba loads the index of its cache
before it looks how old it is, and an index that names a class which is gone fails to load. Here the
folder of the cache carries the version and a hash of all sources that compiled code depends on:
another version never sees it. Several processes may fill it at once; numba renames whole files.
"""

from __future__ import annotations

import hashlib
import logging
import os
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numba

from sherd._version import __version__

__all__ = ["cache_folder", "compiled", "kernel_hash"]

logger = logging.getLogger(__name__)

ROOT = Path(__file__).parent
# Other modules that define named tuples which compiled loops take.
TUPLES = ("correspondence/labels/labeling_data.py", "surface/elastic_surface.py")
_settings = threading.Lock()


def compiled(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Decorate a function to be compiled by :func:`numba.njit` with `options`, cached if possible.

    It runs beside other threads: none of ours touches Python's objects.
    Where no folder can be written it is compiled anew in every process.
    """
    options = {"nogil": True, **options}

    def decorate(function: Callable[..., Any]) -> Any:
        folder = cache_folder()
        if folder is None:
            return numba.njit(**options)(function)
        # numba reads the setting while it decorates; other code that uses numba keeps its own
        settings: Any = numba.config
        with _settings:
            usual, settings.CACHE_DIR = settings.CACHE_DIR, str(folder)
            try:
                return numba.njit(cache=True, **options)(function)
            finally:
                settings.CACHE_DIR = usual

    return decorate


@cache
def cache_folder() -> Path | None:
    """Where compiled loops are kept: the first folder that can be written, or None.

    These are ``NUMBA_CACHE_DIR`` of the environment, the package's own ``__pycache__``, the user's
    folder for caches, and a folder for the user among the temporary files. The last, and none, are
    told to the log, which shows warnings on standard error unless it was set up otherwise.
    """
    name = f"sherd-{__version__}-{kernel_hash()}"
    for base in _lasting_bases():
        if _writable(base / name):
            return base / name
    base = Path(tempfile.gettempdir()) / f"sherd-cache-{_user()}"
    if _private(base) and _writable(base / name):
        logger.warning(
            "no lasting folder for compiled code can be written; it is kept in %s "
            "(set NUMBA_CACHE_DIR to choose another)",
            base,
        )
        return base / name
    logger.warning(
        "no folder for compiled code can be written; every run compiles anew, which takes half a "
        "minute (set NUMBA_CACHE_DIR to choose one)"
    )
    return None


@cache
def kernel_hash() -> str:
    """A hash of the sources of compiled loops and of the named tuples that are handed to them."""
    digest = hashlib.sha256()
    for name in sorted([*_kernels(), *TUPLES]):
        digest.update(name.encode() + b"\0" + (ROOT / name).read_bytes())
    return digest.hexdigest()[:12]


def _kernels() -> Iterator[str]:
    # every process waits for this: to read all sources takes six times as long
    for folder, _, files in os.walk(ROOT):
        inside = Path(folder).relative_to(ROOT)
        yield from ((inside / name).as_posix() for name in files if name.endswith("_kernel.py"))


def _lasting_bases() -> Iterator[Path]:
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    if chosen:
        yield Path(chosen)
    yield ROOT / "__pycache__"
    for variable in ("XDG_CACHE_HOME", "LOCALAPPDATA"):
        if os.environ.get(variable):
            yield Path(os.environ[variable]) / "sherd"
    home = Path("~").expanduser()
    if home.is_absolute() and home.is_dir():  # a container may run as a user without a home
        yield home / ("Library/Caches" if sys.platform == "darwin" else ".cache") / "sherd"


def _user() -> str:
    return str(os.getuid()) if hasattr(os, "getuid") else "user"


def _private(folder: Path) -> bool:
    """Whether the folder, made if missing, is ours alone: others could plant code to be loaded."""
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.lstat()
    except OSError:
        return False
    if not hasattr(os, "getuid"):
        return folder.is_dir() and not folder.is_symlink()
    is_folder = folder.is_dir() and not folder.is_symlink()
    return is_folder and status.st_uid == os.getuid() and not status.st_mode & 0o077


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
