"""An executor of a Dask cluster that runs already; needs the extra ``cluster``."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from concurrent.futures import Executor
from typing import Any

from sherd.errors import InputError, OptionError

__all__ = ["dask_executor"]

# A scheduler on the other side of a busy network answers within this, or is not there.
SECONDS = 20


@contextlib.contextmanager
def dask_executor(address: str) -> Iterator[Executor]:
    """The executor of the Dask cluster at an address, such as ``tcp://login1:8786``.

    Raises
    ------
    OptionError
        If the extra is not installed.
    InputError
        If no scheduler answers there.
    """
    try:
        from distributed import Client  # an optional extra  # noqa: PLC0415
    except ImportError as error:
        raise OptionError(
            'a Dask cluster needs the extra "cluster": python -m pip install "sherd[cluster]"'
        ) from error
    try:
        client: Any = Client(address, timeout=SECONDS)  # type: ignore[no-untyped-call]
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(
            f"{address}: no Dask scheduler answers there ({error}); start one with `dask "
            "scheduler` and give the address that it prints"
        ) from error
    with client:
        # not pure: a part whose worker died is asked again, not looked up
        executor: Executor = client.get_executor(pure=False)
        yield executor
