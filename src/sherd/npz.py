"""NPZ archives of arrays, whose bytes depend on the arrays only."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from sherd.errors import OptionError

__all__ = ["arrays_npz"]

ZIP_DATE = (1980, 1, 1, 0, 0, 0)  # the earliest that the format knows


def arrays_npz(arrays: Mapping[str, ArrayLike], *, compressed: bool = True) -> bytes:
    """NPZ (no pickled objects) whose bytes depend on the arrays only.

    Parameters
    ----------
    arrays
        By name.
    compressed
        Whether space matters more than the time of writing and reading.

    Raises
    ------
    OptionError
        If an array holds objects.
    """
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, values in arrays.items():
            array = np.asarray(values)
            if array.dtype.hasobject:
                raise OptionError(f"array {name!r} holds Python objects; only numbers are stored")
            entry = io.BytesIO()
            np.lib.format.write_array(entry, array, allow_pickle=False)
            # numpy.savez would store the time of day here
            info = zipfile.ZipInfo(f"{name}.npy", date_time=ZIP_DATE)
            info.compress_type = zipfile.ZIP_DEFLATED if compressed else zipfile.ZIP_STORED
            archive.writestr(info, entry.getbuffer())
    return stream.getvalue()
