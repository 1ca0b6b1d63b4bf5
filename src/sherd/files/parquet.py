"""Tables as Parquet, which data frames and databases read; needs the extra ``parquet``."""

from __future__ import annotations

import importlib.util
import io
from collections.abc import Mapping
from typing import Any

from sherd.errors import OptionError

__all__ = ["parquet_bytes", "require_parquet"]


def require_parquet() -> None:
    """Refuse now what could not be written later.

    Raises
    ------
    OptionError
        If the extra is not installed.
    """
    if importlib.util.find_spec("pyarrow") is None:
        raise OptionError(
            'Parquet files need the extra "parquet": python -m pip install "sherd[parquet]"'
        )


def parquet_bytes(columns: Mapping[str, Any]) -> bytes:
    """The content of a Parquet file; equal columns give equal bytes.

    Parameters
    ----------
    columns
        Arrays or lists of one length, by name; None in a list is unknown.

    Raises
    ------
    OptionError
        If the extra is not installed.
    """
    require_parquet()
    import pyarrow  # an optional extra  # noqa: PLC0415
    from pyarrow import parquet  # noqa: PLC0415

    stream = io.BytesIO()
    parquet.write_table(pyarrow.table(dict(columns)), stream)
    return stream.getvalue()
