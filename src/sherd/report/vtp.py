"""VTK XML PolyData (.vtp) for ParaView: the mesh and every layer as a point array."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from sherd.drawing.colors import layer_colors
from sherd.drawing.exhibit import Layer
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.files import layer_values

__all__ = ["vtp_text"]


def vtp_text(mesh: TriangleMesh, layers: Iterable[Layer]) -> str:
    """Vertices, triangles and all layers as XML; layers of kind "color" become RGB arrays.

    Raises
    ------
    OptionError
        If two layers have the same name.

    References
    ----------
    Kitware, *VTK file formats*, XML PolyData; binary arrays are base64 of a 64-bit byte count and
    the numbers, little-endian, in the document itself.
    """
    layers = list(layers)
    arrays: dict[str, NDArray[np.generic]] = dict(layer_values(layers))
    for layer in layers:
        if layer.kind == "color":
            arrays[layer.name] = layer_colors(layer, mesh.vertex_count)
    first = next(iter(layer_values(layers)), "")
    ends = 3 * np.arange(1, mesh.face_count + 1, dtype=np.int64)
    return (
        '<?xml version="1.0"?>\n'
        '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n'
        f'<PolyData><Piece NumberOfPoints="{mesh.vertex_count}" '
        f'NumberOfPolys="{mesh.face_count}">\n'
        f'<PointData Scalars="{html.escape(first)}">\n'
        + "".join(_array(name, values) for name, values in arrays.items())
        + "</PointData>\n<Points>\n"
        + _array("Points", mesh.vertices)
        + "</Points>\n<Polys>\n"
        + _array("connectivity", mesh.faces.ravel())
        + _array("offsets", ends)
        + "</Polys>\n</Piece></PolyData></VTKFile>\n"
    )


def _array(name: str, values: NDArray[np.generic]) -> str:
    kind = {"f": "Float64", "i": "Int64", "u": "UInt8"}[values.dtype.kind]
    little = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<")).tobytes()
    coded = base64.b64encode(len(little).to_bytes(8, "little") + little).decode("ascii")
    components = values.shape[1] if values.ndim == 2 else 1
    return (
        f'<DataArray type="{kind}" Name="{html.escape(name)}" NumberOfComponents="{components}" '
        f'format="binary">{coded}</DataArray>\n'
    )
