"""The numbers of an exhibit, packed small for the page: quantized, differenced, deflated.

`viewer/src/decode.js` reads what is written here.
"""

from __future__ import annotations

import base64
import zlib
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sherd.arrays import Bools, Floats, Ints
from sherd.drawing.colors import (
    CATEGORY_COLORS,
    MASK_COLORS,
    NEUTRAL,
    UNKNOWN,
    color_table,
)
from sherd.drawing.exhibit import Exhibit, Layer, Partner
from sherd.drawing.picture import Staging
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.thinning import Thinned

__all__ = ["Block", "payload", "unpacked"]

# 16 bits resolve 1/65000 of the extent, a tenth of a pixel of the largest screens; the last code
# is NaN.
UNKNOWN_CODE = 65535
# A click on the full shape finds a part vertex whose partner is within this many edge lengths.
REACH_IN_EDGES = 2.5


class Block:
    """Arrays of unsigned integers one after the other, each as byte planes.

    Examples
    --------
    >>> block = Block()
    >>> entry = block.add(np.array([3, 4, 5]), 2)
    >>> unpacked(block.packed(), entry).tolist()
    [3, 4, 5]
    """

    def __init__(self) -> None:
        self._chunks: list[bytes] = []
        self._length = 0

    def add(self, values: NDArray[Any], width: int, *, delta: bool = True) -> dict[str, Any]:
        """Append `values` (any shape) as integers of `width` bytes; what to read them by.

        With `delta` neighbors are subtracted and signs folded in (zigzag), which deflates to half.
        """
        flat = np.ravel(values).astype(np.int64)
        if delta:
            bits = 8 * width
            steps = np.diff(flat, prepend=0)
            steps = (steps + (1 << (bits - 1))) % (1 << bits) - (1 << (bits - 1))  # wrap around
            flat = (steps << 1) ^ (steps >> 63)
        little = flat.astype(f"<u{width}").view(np.uint8).reshape(len(flat), width)
        entry = {"offset": self._length, "count": len(flat), "bytes": width, "delta": delta}
        self._chunks.append(np.ascontiguousarray(little.T).tobytes())
        self._length += width * len(flat)
        return entry

    def packed(self) -> str:
        """All arrays, deflated, as base64."""
        return base64.b64encode(zlib.compress(b"".join(self._chunks), 6)).decode("ascii")


def unpacked(packed: str, entry: dict[str, Any]) -> Ints:
    """Read one array of a :class:`Block` back, flat: the page's decoder in Python."""
    block = np.frombuffer(zlib.decompress(base64.b64decode(packed)), dtype=np.uint8)
    start, count, width = entry["offset"], entry["count"], entry["bytes"]
    planes = block[start : start + width * count].reshape(width, count).astype(np.int64)
    codes: Ints = (planes << (8 * np.arange(width))[:, None]).sum(axis=0)
    if not entry["delta"]:
        return codes
    steps = (codes >> 1) ^ -(codes & 1)
    values: Ints = np.cumsum(steps) % (1 << (8 * width))
    return values


def quantized(values: Floats, low: float, high: float) -> Ints:
    """Codes 0..65534 for values between `low` and `high`, 65535 for NaN."""
    finite = np.isfinite(values)
    share = (np.where(finite, values, low) - low) / max(high - low, np.finfo(float).tiny)
    codes = np.round(np.clip(share, 0, 1) * (UNKNOWN_CODE - 1)).astype(np.int64)
    codes[~finite] = UNKNOWN_CODE
    return codes


def payload(thinned: Thinned, staging: Staging) -> tuple[dict[str, Any], str]:
    """Everything the page draws: a description for JSON, and the packed arrays as base64."""
    exhibit, block = thinned.exhibit, Block()
    full = _shape(block, exhibit.full, (thinned.full_numbers, thinned.full_owners), np.eye(3))
    if exhibit.full_before is not None:
        full["before"] = _box(block, exhibit.full_before)
    part_counting = _part_numbers(thinned), thinned.part_owners
    part = _shape(block, exhibit.part, part_counting, staging.part_rotation)
    best: dict[str, Any] = {
        "name": "Best placement",
        "description": "",
        "score": _finite(exhibit.score),
        "layers": [],
        "partLayers": [],
        "partner": _partner(block, exhibit, exhibit.partner),
        "region": _region(block, exhibit.region),
    }
    others = [
        {
            "name": place.name,
            "description": place.description,
            "score": _finite(place.score),
            "layers": [_layer(block, layer) for layer in place.full_layers],
            "partLayers": [_layer(block, layer) for layer in place.part_layers],
            "partner": _partner(block, exhibit, place.partner),
            "region": _region(block, place.region),
        }
        for place in exhibit.alternatives
    ]
    meta = {
        "shapes": {"full": full, "part": part},
        "names": dict(zip(("full", "part"), exhibit.names, strict=True)),
        "camera": {"up": staging.up.tolist(), "toward": staging.view.rotation[2].tolist()},
        "layers": {
            "full": [_layer(block, layer) for layer in exhibit.full_layers],
            "part": [_layer(block, layer) for layer in exhibit.part_layers],
        },
        "placements": [best, *others],
        "scoreName": exhibit.score_name,
        "anchors": np.asarray(exhibit.anchors).tolist(),
        "verdict": None if exhibit.verdict is None else asdict(exhibit.verdict),
        "command": exhibit.command,
        "takesHints": exhibit.takes_hints,
        "overlaid": exhibit.overlaid,
        "landmarks": [[int(part), int(full)] for part, full in exhibit.landmarks],
        "ignored": [int(vertex) for vertex in exhibit.ignored],
        "colors": {
            "neutral": NEUTRAL,
            "unknown": UNKNOWN,
            "mask": MASK_COLORS,
            "category": _palette(exhibit),
        },
        "tables": {
            name: block.add(color_table(name), 1, delta=False) for name in sorted(_maps(exhibit))
        },
    }
    return meta, block.packed()


def _shape(
    block: Block,
    mesh: TriangleMesh,
    counting: tuple[Ints | None, Ints | None],
    rotation: Floats,
) -> dict[str, Any]:
    numbers, owners = counting
    return {
        "name": mesh.name,
        "shown": mesh.vertex_count,
        **_box(block, mesh.vertices),
        "faces": block.add(mesh.faces, 4),
        "numbers": None if numbers is None else block.add(numbers, 4),
        "owners": None if owners is None else block.add(owners, 4),
        "orientation": mesh.winding,
        "rotation": rotation.ravel().tolist(),
    }


def _box(block: Block, vertices: Floats) -> dict[str, Any]:
    """Positions (n, 3), and the box that their codes are shares of."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    extent = float((high - low).max()) or 1.0
    columns = [
        block.add(quantized(vertices[:, axis], low[axis], low[axis] + extent), 2)
        for axis in range(3)
    ]
    return {"low": low.tolist(), "high": high.tolist(), "extent": extent, "positions": columns}


def _part_numbers(thinned: Thinned) -> Ints | None:
    own = thinned.exhibit.part_numbers
    if own is None or thinned.part_numbers is None:
        return thinned.part_numbers if own is None else own
    return own[thinned.part_numbers]


def _layer(block: Block, layer: Layer) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "name": layer.name,
        "kind": layer.kind,
        "limits": layer.limits,
        "unit": layer.unit,
        "colorMap": layer.color_map,
        "description": layer.description,
        "labels": layer.labels,
        "carried": layer.carried,
    }
    if layer.kind == "scalar":
        finite = layer.values[np.isfinite(layer.values)]
        low, high = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0)
        high = high if high > low else low + 1.0
        entry |= {
            "low": low,
            "high": high,
            "values": block.add(quantized(layer.values, low, high), 2),
        }
    elif layer.kind == "category":
        entry["values"] = block.add(np.maximum(layer.values, -1) + 1, 4)
    else:
        entry["values"] = block.add(layer.values, 1, delta=False)
    return entry


def _partner(block: Block, exhibit: Exhibit, partner: Partner | None) -> dict[str, Any] | None:
    if partner is None:
        return None
    weights = np.round(partner.points.barycentric * 65535)
    reach = REACH_IN_EDGES * max(exhibit.full.mean_edge_length, exhibit.part.mean_edge_length)
    return {
        "faces": block.add(partner.points.faces, 4),
        "first": block.add(weights[:, 0], 2, delta=False),
        "second": block.add(weights[:, 1], 2, delta=False),
        "matched": block.add(partner.known, 1, delta=False),
        "confidence": block.add(quantized(np.asarray(partner.confidence), 0.0, 1.0), 2),
        "reach": reach,
    }


def _region(block: Block, region: Bools | None) -> dict[str, Any] | None:
    return None if region is None else block.add(region, 1, delta=False)


def _palette(exhibit: Exhibit) -> tuple[tuple[int, int, int], ...]:
    layers = (*exhibit.full_layers, *exhibit.part_layers)
    return next((layer.palette for layer in layers if layer.palette), CATEGORY_COLORS)


def _maps(exhibit: Exhibit) -> set[str]:
    layers = [*exhibit.full_layers, *exhibit.part_layers]
    layers += [layer for p in exhibit.alternatives for layer in (*p.full_layers, *p.part_layers)]
    return {layer.color_map for layer in layers if layer.kind == "scalar"}


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
