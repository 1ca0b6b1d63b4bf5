"""Further files on request: VTP for ParaView, GLB, NPZ, MAT, the vertex maps of the field."""

from __future__ import annotations

import io
from collections.abc import Iterable
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from sherd.drawing.colors import full_layer, part_layer
from sherd.drawing.exhibit import Exhibit, Layer, Partner
from sherd.errors import OptionError
from sherd.files.parquet import parquet_bytes, require_parquet
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.npz import arrays_npz
from sherd.report.files import layer_values, vertex_map_text
from sherd.report.glb import glb_scene
from sherd.report.vtp import vtp_text

__all__ = ["MAP_EXPORTS", "SHAPE_EXPORTS", "exported", "require_exports"]

SHAPE_EXPORTS = ("vtp", "glb", "npz", "mat")
# These say which point is which, so they need a map.
MAP_EXPORTS = ("map", "vts", "parquet")

# The text that a MAT file begins with names the date otherwise, and equal results should give
# equal bytes; the format wants 116 characters.
MAT_TITLE = b"MATLAB 5.0 MAT-file, written by sherd".ljust(116)
# What counts vertices or faces; MATLAB counts from 1.
INDICES = ("full_faces", "part_faces", "full_face", "full_vertex")

Arrays = dict[str, NDArray[np.generic]]


def require_exports(kinds: Iterable[str]) -> None:
    """Refuse now what could not be exported later.

    Raises
    ------
    OptionError
        If a kind is unknown, or its library is not installed.
    """
    for kind in kinds:
        if kind not in SHAPE_EXPORTS + MAP_EXPORTS:
            raise _unknown(kind)
        if kind == "parquet":
            require_parquet()


def exported(exhibit: Exhibit, kinds: Iterable[str]) -> dict[str, bytes | str]:
    """Contents by file name for the kinds that are asked for.

    Raises
    ------
    OptionError
        If a kind is unknown, or needs a map and the exhibit has none.
    """
    contents: dict[str, bytes | str] = {}
    for kind in kinds:
        if kind in MAP_EXPORTS and exhibit.partner is None:
            raise OptionError(f"a .{kind} file holds a map, but this result has none")
        contents.update(_files(exhibit, kind))
    return contents


def _files(exhibit: Exhibit, kind: str) -> dict[str, bytes | str]:
    partner, full = exhibit.partner, exhibit.full
    if kind == "vtp":
        return {
            "full.vtp": vtp_text(full, _seen_on_full(exhibit)),
            "part.vtp": vtp_text(exhibit.part, _seen_on_part(exhibit)),
        }
    if kind == "glb":
        return {"result.glb": _glb(exhibit)}
    if kind == "npz":
        return {"result.npz": arrays_npz(_arrays(exhibit))}
    if kind == "mat":
        return {"result.mat": _mat(_arrays(exhibit))}
    if kind in MAP_EXPORTS and partner is not None:
        return {f"correspondence.{kind}": _map(partner, full, kind)}
    raise _unknown(kind)


def _map(partner: Partner, full: TriangleMesh, kind: str) -> bytes | str:
    if kind == "parquet":
        return parquet_bytes(_correspondence(partner, full))
    return vertex_map_text(partner, full, first=0 if kind == "map" else 1)


def _unknown(kind: str) -> OptionError:
    return OptionError(f"export {kind!r} is unknown; choose from {SHAPE_EXPORTS + MAP_EXPORTS}")


def _correspondence(partner: Partner, full: TriangleMesh) -> Arrays:
    """The columns of ``correspondence.csv``, but numbers as they are."""
    points = partner.points
    columns: Arrays = {
        "part_vertex": np.arange(len(points)),
        "full_face": points.faces,
        **{f"b{k}": points.barycentric[:, k] for k in range(3)},
        "full_vertex": points.nearest_vertices(full),
    }
    given = {"matched": partner.known, "confidence": partner.confidence}
    return columns | {name: values for name, values in given.items() if values is not None}


def _seen_on_full(exhibit: Exhibit) -> tuple[Layer, ...]:
    """The layers of the full shape as the report shows them: gray where the part does not lie."""
    shown = (full_layer(exhibit, layer.name) for layer in exhibit.full_layers)
    return tuple(layer for layer in shown if layer is not None)


def _seen_on_part(exhibit: Exhibit) -> tuple[Layer, ...]:
    """The part's own layers and those that the map carries over."""
    own = {layer.name for layer in exhibit.part_layers}
    names = [layer.name for layer in exhibit.full_layers if layer.name not in own]
    carried = (part_layer(exhibit, name) for name in names)
    return (*(layer for layer in carried if layer is not None), *exhibit.part_layers)


def _glb(exhibit: Exhibit) -> bytes:
    """Both shapes painted with the first layer; neutral where the part does not show it."""
    first = exhibit.full_layers[0].name if exhibit.full_layers else None
    painted = None if first is None else full_layer(exhibit, first)
    carried = None if first is None else part_layer(exhibit, first)
    return glb_scene(
        (exhibit.full, _seen_on_full(exhibit), painted),
        (exhibit.part, _seen_on_part(exhibit), carried),
    )


def _arrays(exhibit: Exhibit) -> Arrays:
    full, part, partner = exhibit.full, exhibit.part, exhibit.partner
    arrays: Arrays = {
        "full_vertices": full.vertices,
        "full_faces": full.faces,
        "part_vertices": part.vertices,
        "part_faces": part.faces,
    }
    if partner is not None:
        arrays |= {
            "full_face": partner.points.faces,
            "barycentric": partner.points.barycentric,
            "full_vertex": partner.points.nearest_vertices(full),
        }
    # a quantity that both shapes have, as membership, is told apart by its shape's name
    on_full, on_part = layer_values(exhibit.full_layers), layer_values(exhibit.part_layers)
    arrays |= on_full
    arrays |= {(f"part_{name}" if name in on_full else name): on_part[name] for name in on_part}
    return arrays


def _mat(arrays: Arrays) -> bytes:
    from scipy.io import savemat  # noqa: PLC0415  loaded only on request

    counted = {name: a + 1 if name in INDICES else a for name, a in arrays.items()}
    stream = io.BytesIO()
    # scipy writes to streams as well, which its type hints do not say
    target = cast("Any", stream)
    savemat(target, counted, do_compression=True, oned_as="column", long_field_names=True)
    data = stream.getvalue()
    return MAT_TITLE + data[len(MAT_TITLE) :]
