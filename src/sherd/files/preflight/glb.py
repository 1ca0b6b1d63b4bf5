"""GLB: every view inside its buffer, every accessor inside its view, nothing outside the file."""

from __future__ import annotations

import json
import struct
from typing import Any

from sherd.errors import MeshFileError
from sherd.files.preflight.prepared import Prepared

__all__ = ["prepare"]

_COMPONENT_BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
_COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_TRIANGLES = (4, 5, 6)  # list, strip and fan in the primitive modes of glTF 2.0
# A file may place one mesh many times. Ten times the vertices of the largest mesh that sherd is
# made for is an attack, not a scene.
_LARGEST_SCENE = 10_000_000
_DEEPEST_NODE = 256


def prepare(data: bytes) -> Prepared:
    """Check a binary glTF 2.0 file and take its materials, pictures and animations away.

    Raises
    ------
    MeshFileError
        If a count or an offset points outside the file, or the file needs other files.
    """
    header, body = _chunks(data)
    try:
        _check_buffers(header, len(body))
        for index, accessor in enumerate(header.get("accessors", [])):
            _check_accessor(header, index, accessor)
        kept, faces = _only_triangles(header)
        _check_scene(kept)
        text = json.dumps(kept).encode()
    except MeshFileError:
        raise
    except (
        TypeError,
        LookupError,
        ValueError,
        AttributeError,
        OverflowError,
        RecursionError,
    ) as error:
        raise MeshFileError(
            f"its JSON part is damaged ({error!r}); export the mesh again"
        ) from None
    text += b" " * (-len(text) % 4)
    body += b"\0" * (-len(body) % 4)
    parts = [struct.pack("<II", len(text), 0x4E4F534A), text]
    if body:
        parts += [struct.pack("<II", len(body), 0x004E4942), body]
    size = 12 + sum(len(part) for part in parts)
    return Prepared(
        b"".join([struct.pack("<4sII", b"glTF", 2, size), *parts]), None, None if faces else 0
    )


def _chunks(data: bytes) -> tuple[dict[str, Any], bytes]:
    if len(data) < 20 or data[:4] != b"glTF":
        raise MeshFileError("does not start with 'glTF'; it is truncated or no GLB file")
    _, version, length = struct.unpack_from("<4sII", data)
    if version != 2:
        raise MeshFileError(f"is glTF version {version}, but only version 2 is known; convert it")
    if length > len(data):
        raise MeshFileError(
            f"its header promises {length} bytes, but the file has {len(data)}; "
            "it is truncated: export or copy it again"
        )
    chunks: list[tuple[int, bytes]] = []
    start = 12
    while start + 8 <= length:
        size, kind = struct.unpack_from("<II", data, start)
        if start + 8 + size > len(data):
            raise MeshFileError(
                f"chunk {len(chunks)} promises {size} bytes, but {len(data) - start - 8} follow; "
                "the file is truncated: export or copy it again"
            )
        chunks.append((kind, data[start + 8 : start + 8 + size]))
        start += 8 + size
    try:
        header = json.loads(chunks[0][1]) if chunks else None
    except (ValueError, RecursionError):
        header = None
    if not isinstance(header, dict):
        raise MeshFileError("its JSON part cannot be read; export the mesh again")
    return header, next((chunk for kind, chunk in chunks[1:] if kind == 0x004E4942), b"")


def _check_buffers(header: dict[str, Any], held: int) -> None:
    for index, buffer in enumerate(header.get("buffers", [])):
        uri = buffer.get("uri")
        if uri is not None:
            raise MeshFileError(
                f"buffer {index} lies in another file ({str(uri)[:40]!r}), and sherd reads one "
                "file only; export it as one self-contained GLB"
            )
        if index > 0 or not 0 <= int(buffer["byteLength"]) <= held:
            raise MeshFileError(
                f"buffer {index} promises {buffer['byteLength']} bytes, but {held} are there; "
                "the file is truncated: export or copy it again"
            )
    for index, view in enumerate(header.get("bufferViews", [])):
        end = int(view.get("byteOffset", 0)) + int(view["byteLength"])
        size = int(header["buffers"][_index(view["buffer"])]["byteLength"])
        if min(int(view.get("byteOffset", 0)), int(view["byteLength"])) < 0 or end > size:
            raise MeshFileError(
                f"bufferView {index} ends at byte {end} of a buffer of {size}; "
                "the file is damaged: export it again"
            )


def _check_accessor(header: dict[str, Any], index: int, accessor: dict[str, Any]) -> None:
    count, offset = int(accessor["count"]), int(accessor.get("byteOffset", 0))
    size = _COMPONENT_BYTES[accessor["componentType"]] * _COMPONENTS[accessor["type"]]
    if "sparse" in accessor or "bufferView" not in accessor:
        raise MeshFileError(
            f"accessor {index} is sparse or compressed, which sherd does not read; "
            "export it without compression"
        )
    view = header["bufferViews"][_index(accessor["bufferView"])]
    stride = int(view.get("byteStride", size))
    end = offset + stride * (count - 1) + size
    if count < 0 or offset < 0 or stride < size or (count and end > int(view["byteLength"])):
        raise MeshFileError(
            f"accessor {index} promises {count} elements, {end} bytes, but its view has "
            f"{view['byteLength']}; the file is damaged: export it again"
        )


def _only_triangles(header: dict[str, Any]) -> tuple[dict[str, Any], int]:
    """The header with triangles, positions, colors and nodes alone, and the number of corners."""
    kept: dict[str, Any] = {
        key: header[key]
        for key in ("asset", "scene", "scenes", "buffers", "bufferViews", "accessors")
        if key in header
    }
    required = set(header.get("extensionsRequired", []))
    if required & {"KHR_draco_mesh_compression", "EXT_meshopt_compression"}:
        raise MeshFileError("is compressed, which sherd does not read; export without compression")
    corners = 0
    kept["meshes"] = []
    for mesh in header.get("meshes", []):
        primitives = []
        for primitive in mesh["primitives"]:
            if (
                primitive.get("mode", 4) not in _TRIANGLES
                or "POSITION" not in primitive["attributes"]
            ):
                continue
            attributes = {
                key: header["accessors"][_index(value)] and value
                for key, value in primitive["attributes"].items()
                if key in ("POSITION", "COLOR_0")
            }
            clean = {"attributes": attributes, "mode": primitive.get("mode", 4)}
            source = header["accessors"][_index(attributes["POSITION"])]
            if "indices" in primitive:
                clean["indices"] = primitive["indices"]
                source = header["accessors"][_index(primitive["indices"])]
            corners += int(source["count"])
            primitives.append(clean)
        kept["meshes"].append({"primitives": primitives, "name": f"mesh {len(kept['meshes'])}"})
    placing = ("children", "mesh", "matrix", "translation", "rotation", "scale")
    kept["nodes"] = [
        {key: node[key] for key in placing if key in node} | {"name": f"node {index}"}
        for index, node in enumerate(header.get("nodes", []))
    ]
    return kept, corners


def _check_scene(header: dict[str, Any]) -> None:
    """Refuse nodes that contain themselves and scenes that multiply one mesh without end."""
    sizes = []
    for mesh in header["meshes"]:
        positions = [primitive["attributes"]["POSITION"] for primitive in mesh["primitives"]]
        sizes.append(sum(int(header["accessors"][entry]["count"]) for entry in positions))
    budget = _LARGEST_SCENE
    nodes = header["nodes"]
    for scene in header.get("scenes", []):
        stack = [(_index(node), 0) for node in scene.get("nodes", [])]
        while stack:
            index, depth = stack.pop()
            budget -= 1 + (sizes[_index(nodes[index]["mesh"])] if "mesh" in nodes[index] else 0)
            if depth > _DEEPEST_NODE or budget < 0:
                raise MeshFileError(
                    "its nodes contain each other or repeat a mesh without end; export it again"
                )
            stack.extend((_index(child), depth + 1) for child in nodes[index].get("children", []))


def _index(value: object) -> int:
    """A reference as a whole number, not below zero."""
    if not isinstance(value, int) or value < 0:
        raise ValueError(f"{value!r} is no index")
    return value
