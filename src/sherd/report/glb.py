"""A scene as binary glTF (.glb): both shapes in the colors of the report, for web viewers."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sherd.arrays import Floats
from sherd.drawing.colors import layer_colors, linear_from_srgb
from sherd.drawing.exhibit import Layer
from sherd.errors import OptionError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.files import layer_values

__all__ = ["Buffer", "PaintedShape", "glb_bytes", "glb_scene", "painted_mesh"]

PaintedShape = tuple[TriangleMesh, tuple[Layer, ...], Layer | None]

# Numbers that the glTF schema gives to kinds of content.
FLOAT, UNSIGNED_INT = 5126, 5125
VERTEX_BUFFER, INDEX_BUFFER = 34962, 34963
LARGEST_SINGLE = float(np.finfo(np.float32).max)
# The second shape stands beside the first, this share of the first one's width away.
GAP = 0.15
# Plain paint, seen from both sides: parts are open surfaces.
MATERIAL = {
    "name": "sherd",
    "doubleSided": True,
    "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.9},
}


def glb_scene(full: PaintedShape, part: PaintedShape) -> bytes:
    """Scene with the nodes "full" and "part" beside each other.

    The coordinates are those of the files; only the node of the part is shifted. Every layer
    without unknown values is an attribute, its name after an underscore; glTF has no NaN.

    Parameters
    ----------
    full, part
        Mesh, its layers, and the layer whose colors are painted (None: neutral).

    Raises
    ------
    OptionError
        If coordinates are too large for single precision, or two layers have the same name.

    References
    ----------
    Khronos, *glTF 2.0 specification*: 3.7.2 (meshes; COLOR_0 is linear, not sRGB), 4.4 (GLB).
    """
    buffer = Buffer()
    names, shapes = ("full", "part"), (full, part)
    meshes = [painted_mesh(buffer, name, *shape) for name, shape in zip(names, shapes, strict=True)]
    nodes = [
        {"name": "full", "mesh": 0},
        {"name": "part", "mesh": 1, "translation": _beside(full[0], part[0])},
    ]
    return glb_bytes(buffer, meshes, nodes)


def glb_bytes(buffer: Buffer, meshes: list[dict[str, Any]], nodes: list[dict[str, Any]]) -> bytes:
    """The file of a scene with all of these nodes, whose arrays are in the buffer."""
    header = {
        "asset": {"version": "2.0", "generator": "sherd"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": [MATERIAL],
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(buffer.content)}],
    }
    text = json.dumps(header, allow_nan=False, separators=(",", ":")).encode("ascii")
    chunks = _chunk(b"JSON", text + b" " * (-len(text) % 4)) + _chunk(b"BIN\0", buffer.content)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


class Buffer:
    """Arrays one after the other, and where each is; all are of four-byte numbers, so aligned."""

    def __init__(self) -> None:
        self.content = b""
        self.views: list[dict[str, int]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, array: NDArray[np.generic], target: int = VERTEX_BUFFER) -> int:
        """The number of the accessor of a (n,), (n, 2) or (n, 3) array."""
        kind = FLOAT if array.dtype.kind == "f" else UNSIGNED_INT
        data = np.ascontiguousarray(array, dtype="<f4" if kind == FLOAT else "<u4").tobytes()
        self.views.append(
            {
                "buffer": 0,
                "byteOffset": len(self.content),
                "byteLength": len(data),
                "target": target,
            }
        )
        self.accessors.append(
            {
                "bufferView": len(self.views) - 1,
                "componentType": kind,
                "count": len(array),
                "type": f"VEC{array.shape[1]}" if array.ndim == 2 else "SCALAR",
            }
        )
        self.content += data
        return len(self.accessors) - 1

    def add_boxed(self, places: NDArray[np.float32]) -> int:
        """The same of positions (n, 3), with the box of exactly the numbers that are stored."""
        number = self.add(places)
        self.accessors[number] |= {
            "min": places.min(axis=0).tolist(),
            "max": places.max(axis=0).tolist(),
        }
        return number


def painted_mesh(
    buffer: Buffer,
    name: str,
    mesh: TriangleMesh,
    layers: tuple[Layer, ...],
    painted: Layer | None,
) -> dict[str, Any]:
    """The mesh of a glTF document, its arrays added to the buffer.

    Raises
    ------
    OptionError
        If coordinates are too large for single precision, or two layers have the same name.
    """
    if np.abs(mesh.vertices).max() > LARGEST_SINGLE:
        raise OptionError("coordinates are too large for .glb files; write a .ply file")
    attributes = {"POSITION": buffer.add_boxed(mesh.vertices.astype(np.float32))}
    attributes["NORMAL"] = buffer.add(_unit_normals(mesh))
    colors = layer_colors(painted, mesh.vertex_count)
    attributes["COLOR_0"] = buffer.add(linear_from_srgb(colors))
    for key, values in layer_values(layers).items():
        if np.isfinite(values).all():
            attributes[f"_{key}"] = buffer.add(values)
    indices = buffer.add(mesh.faces.ravel(), INDEX_BUFFER)
    return {
        "name": name,
        "primitives": [{"attributes": attributes, "indices": indices, "material": 0}],
    }


def _unit_normals(mesh: TriangleMesh) -> Floats:
    """(n, 3) normals; glTF wants length 1 also where a vertex has none."""
    normals = mesh.vertex_normals.copy()
    normals[~(np.linalg.norm(normals, axis=1) > 0.5)] = (0.0, 0.0, 1.0)
    return normals


def _beside(full: TriangleMesh, part: TriangleMesh) -> list[float]:
    """Shift that puts the part to the right of the full shape, at the same height."""
    low, high = full.vertices.min(axis=0), full.vertices.max(axis=0)
    shift = (low + high) / 2 - (part.vertices.min(axis=0) + part.vertices.max(axis=0)) / 2
    shift[0] = high[0] + GAP * (high[0] - low[0]) - part.vertices[:, 0].min()
    return [float(value) for value in shift]


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack("<I4s", len(content), kind) + content
