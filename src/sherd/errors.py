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
    """Base of every exception that sherd raises on purpose.

    Examples
    --------
    >>> try:
    ...     raise InfeasibleError("the part is larger than the full shape")
    ... except SherdError as error:
    ...     print(error)
    the part is larger than the full shape
    """


class InputError(SherdError, ValueError):
    """The input cannot be used; the message names the element and the remedy.

    Examples
    --------
    >>> issubclass(InputError, ValueError)
    True
    """


class MeshFileError(InputError):
    """A mesh file is missing, empty, truncated or in no format that sherd reads.

    Examples
    --------
    >>> from sherd.files.mesh_files import read_mesh
    >>> try:
    ...     read_mesh("nowhere.ply")
    ... except MeshFileError as error:
    ...     print(error)
    nowhere.ply: no such file; check the path
    """


class InvalidMeshError(InputError):
    """Arrays do not describe a triangle mesh; the message names the first bad element.

    Examples
    --------
    >>> from sherd.mesh.triangle_mesh import TriangleMesh
    >>> try:
    ...     TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 9]])
    ... except InvalidMeshError as error:
    ...     print(str(error)[:46])
    faces[0, 2] = 9, but there are 3 vertices (0..
    """


class InfeasibleError(InputError):
    """The question has no answer, for example a part larger than the full shape.

    Examples
    --------
    >>> issubclass(InfeasibleError, InputError)
    True
    """


class OptionError(SherdError, ValueError):
    """An option has a value outside its range.

    Examples
    --------
    >>> from sherd.results.match_options import MatchOptions
    >>> try:
    ...     MatchOptions(seed=-1)
    ... except OptionError as error:
    ...     print(error)
    seed is -1, but it must not be negative
    """


class OutputError(SherdError, OSError):
    """A result could not be written; what stood there before is untouched.

    Examples
    --------
    >>> issubclass(OutputError, OSError)
    True
    """
