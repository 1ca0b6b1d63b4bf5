"""Results as files that other tools open: PLY, VTP, CSV, NPZ, SHREC'16 .corr, vertex maps.

Each function makes the content of one file; :func:`sherd.output.write_bytes`, `write_text` or a
:class:`sherd.output.ResultFolder` writes it. Equal results give equal bytes.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sherd.arrays import Bools, Floats
from sherd.drawing.colors import layer_colors
from sherd.drawing.exhibit import Layer, Partner
from sherd.errors import OptionError
from sherd.files.encode import encoded
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = [
    "corr_text",
    "layer_values",
    "painted_ply",
    "property_name",
    "table_csv",
    "vertex_map_text",
]


def property_name(name: str) -> str:
    """A layer's name as a word that every file format takes.

    Examples
    --------
    >>> property_name("phase field")
    'phase_field'
    """
    return re.sub(r"\W+", "_", name.strip(), flags=re.ASCII).strip("_") or "values"


def layer_values(layers: Iterable[Layer]) -> dict[str, Floats]:
    """Numbers of all layers that are more than colors, by file-safe name, (n,) float.

    Raises
    ------
    OptionError
        If two layers have the same name.
    """
    values: dict[str, Floats] = {}
    for layer in layers:
        if layer.kind == "color":
            continue
        name = property_name(layer.name)
        if name in values:
            raise OptionError(f"two layers are named {name!r}; rename one")
        values[name] = layer.values.astype(np.float64)
    return values


def painted_ply(
    mesh: TriangleMesh, layers: Iterable[Layer], *, painted: Layer | None = None
) -> bytes:
    """PLY with vertex colors and every layer as a vertex property.

    MeshLab and Blender show the colors. One scalar is also stored as `quality`, the only one that
    MeshLab reads, maps to colors and selects by: the painted layer, or the first scalar when the
    painted one is none. Any other PLY reader finds all properties.

    Parameters
    ----------
    mesh
        The shape.
    layers
        Its layers; a mask is 0 or 1, a category its number.
    painted
        The layer whose colors are painted; the first one when None.

    Raises
    ------
    OptionError
        If two layers have the same name.
    """
    layers = list(layers)
    chosen = painted or (layers[0] if layers else None)
    colors = layer_colors(chosen, mesh.vertex_count)
    values = layer_values(layers)
    painted_first = [layer for layer in (chosen, *layers) if layer is not None]
    scalar = next((layer for layer in painted_first if layer.kind == "scalar"), None)
    if scalar is not None:
        values.setdefault("quality", scalar.values)
    return encoded(mesh, ".ply", fields=values, colors=colors)


def table_csv(columns: Mapping[str, ArrayLike]) -> str:
    """CSV with a header; integers as they are, floats as %.9g (nan is unknown), booleans 0 or 1.

    Parameters
    ----------
    columns
        Arrays of one length by column name.

    Raises
    ------
    OptionError
        If the columns differ in length or type, or a name needs quoting.

    Examples
    --------
    >>> print(table_csv({"vertex": [0, 1], "membership": [0.5, 1.0], "in_region": [False, True]}))
    vertex,membership,in_region
    0,0.5,0
    1,1,1
    <BLANKLINE>
    """
    arrays = {name: np.asarray(values) for name, values in columns.items()}
    lengths = {array.shape for array in arrays.values()}
    if len(lengths) > 1 or any(len(shape) != 1 for shape in lengths):
        shapes = {name: array.shape for name, array in arrays.items()}
        raise OptionError(f"columns must be (n,) of one length, but are {shapes}")
    for name in arrays:
        if re.search(r'[",\r\n]', name):
            raise OptionError(
                f"column name {name!r} would need quoting; leave out commas and quotes"
            )
    cells = [_cells(array) for array in arrays.values()]
    lines = [",".join(arrays), *(",".join(row) for row in zip(*cells, strict=True))]
    return "\n".join(lines) + "\n"


def corr_text(partner: Partner) -> str:
    """SHREC'16 correspondence: per part vertex a face of the full shape from 1 and three weights.

    An unmatched vertex is ``-1 0 0 0``.

    References
    ----------
    Cosmo, Rodola, Bronstein, Torsello, Cremers, Sahillioglu, *SHREC'16: Partial matching of
    deformable shapes*, 2016, submission format.
    """
    rows = _corr_rows(partner.points, partner.known)
    return "".join(f"{row}\n" for row in rows)


def vertex_map_text(partner: Partner, full: TriangleMesh, *, first: int = 0) -> str:
    """One vertex of the full shape per line for each part vertex: .map (from 0), .vts (from 1).

    Parameters
    ----------
    partner
        The map; its points are rounded to the corner with the largest weight.
    full
        The full shape.
    first
        Number of the first vertex, 0 or 1, as the reader of the file counts. An unmatched vertex
        is -1 either way.

    Raises
    ------
    OptionError
        If `first` is neither 0 nor 1.
    """
    if first not in (0, 1):
        raise OptionError(f"first is {first}, but vertices are counted from 0 or from 1")
    vertices = np.full(len(partner.points), -1, dtype=np.int64)
    known = partner.known
    vertices[known] = partner.points[known].nearest_vertices(full) + first
    return "".join(f"{vertex}\n" for vertex in vertices)


def _cells(array: NDArray[np.generic]) -> list[str]:
    if array.dtype.kind == "f":
        return [
            f"{value:.9g}" for value in (array.astype(np.float64) + 0.0).tolist()
        ]  # no minus zero
    if array.dtype.kind == "b":
        return ["1" if value else "0" for value in array.tolist()]
    if array.dtype.kind in "iu":
        return [str(value) for value in array.tolist()]
    raise OptionError(f"a column of type {array.dtype} cannot be written; only numbers are")


def _corr_rows(points: SurfacePoints, matched: Bools) -> Iterable[str]:
    for face, weights, known in zip(
        points.faces.tolist(), points.barycentric.tolist(), matched.tolist(), strict=True
    ):
        yield f"{face + 1} {' '.join(f'{w:.9g}' for w in weights)}" if known else "-1 0 0 0"
