"""The exceptions of sherd.

::

    SherdError
    |-- InputError (ValueError)         wrong input; the command line ends with exit code 3
    |   |-- MeshFileError               cannot be read: missing, empty, truncated, hostile
    |   |-- InvalidMeshError            arrays that are no mesh: NaN, index out of range, no faces
    |   `-- InfeasibleError             a question without answer: part larger than the full shape
    |-- OptionError (ValueError)        an option out of range; exit code 2
    `-- OutputError (OSError)           a result that cannot be written; exit code 5

Not converging is no exception: it is a status on the result, with advice.
"""

from __future__ import annotations

__all__ = [
    "InfeasibleError",
    "InputError",
    "InvalidMeshError",
    "MeshFileError",
    "OptionError",
    "OutputError",
    "SherdError",
]


class SherdError(Exception):
    """Base of every exception that sherd raises on purpose."""


class InputError(SherdError, ValueError):
    """The input cannot be used; the message names the element and the remedy."""


class MeshFileError(InputError):
    """A mesh file is missing, empty, truncated or in no format that sherd reads."""


class InvalidMeshError(InputError):
    """Arrays do not describe a triangle mesh; the message names the first bad element."""


class InfeasibleError(InputError):
    """The question has no answer, for example a part larger than the full shape."""


class OptionError(SherdError, ValueError):
    """An option has a value outside its range."""


class OutputError(SherdError, OSError):
    """A result could not be written; what stood there before is untouched."""
