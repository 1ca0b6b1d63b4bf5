"""The quantities of a result, shown alike in every report: colors, range and one sentence each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from sherd.arrays import Floats
from sherd.drawing.exhibit import Layer
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.files import property_name

__all__ = [
    "error_layer",
    "file_layers",
    "known_layer",
    "located_part_layers",
    "own_fields",
    "stored_layers",
]

FROM_FILE = " (from the file)"
# An error above this is wrong at a glance, so the color bar reaches at least that far.
ERROR_RANGE = 0.05

_KNOWN: dict[str, dict[str, Any]] = {
    "membership": {
        "range": (0.0, 1.0),
        "color_map": "ember",
        "description": "How much each point of the full shape belongs to the part's place.",
    },
    "region": {"kind": "mask", "description": "The place, cut to the part's area."},
    "phase field": {
        "range": (0.0, 1.0),
        "color_map": "dusk",
        "description": "Near 0 where the place has its boundary, 1 elsewhere.",
    },
    "confidence": {
        "range": (0.0, 1.0),
        "color_map": "lagoon",
        "description": "Chance that the answer is within 0.05 sqrt(area) of the truth.",
    },
    "matched": {"kind": "mask", "description": "Has a partner."},
    "shared": {"kind": "mask", "description": "The other shape has this place too."},
    "seen": {"kind": "mask", "description": "Lies on the scan; elsewhere the pose is a guess."},
    "chance": {
        "range": (0.0, 1.0),
        "color_map": "lagoon",
        "description": "That the fit is near the truth there; see result.json for how near.",
    },
    "strain": {
        "range": (0.0, 0.3),
        "color_map": "ember",
        "description": "How far edges differ from the full shape's, bending and size aside.",
    },
    "size": {
        "range": (0.5, 1.5),
        "color_map": "balance",
        "description": "How many times larger the full shape was made.",
    },
    "distortion": {
        "range": (-0.3, 0.3),
        "color_map": "balance",
        "description": "Logarithm of mapped over original edge length: 0 keeps lengths.",
    },
    "orientation": {
        "range": (0.0, 1.0),
        "color_map": "dusk",
        "description": "Share of the triangles around a point that are not turned over by the map.",
    },
}


def known_layer(name: str, values: ArrayLike) -> Layer:
    """Layer of a quantity that sherd computes; `name` is one of the keys above."""
    return Layer(name, np.asarray(values), **_KNOWN[name])


def error_layer(errors: Floats) -> Layer:
    """Distance of each answer to the ground truth, (n_part,) in sqrt(area of the full shape)."""
    known = errors[np.isfinite(errors)]
    worst = float(np.quantile(known, 0.99)) if len(known) else 0.0
    return Layer(
        "error",
        errors,
        range=(0.0, max(ERROR_RANGE, worst)),
        color_map="ember",
        description="Distance to the ground truth in sqrt(area of the full shape).",
    )


def located_part_layers(part: TriangleMesh) -> tuple[Layer, ...]:
    """All of a located part belongs to its place, so it has the colors of the place."""
    everywhere = np.ones(part.vertex_count)
    return known_layer("membership", everywhere), known_layer("region", everywhere)


def file_layers(fields: Mapping[str, Floats], *, carried: bool = False) -> tuple[Layer, ...]:
    """Layers of the numbers (n,) that came with a user's mesh; `carried` as in `Layer`."""
    return tuple(
        Layer(f"{name}{FROM_FILE}", values, carried=carried)
        for name, values in fields.items()
        if values.ndim == 1 and np.isfinite(values).any()
    )


def own_fields(fields: Mapping[str, Floats]) -> dict[str, Floats]:
    """Those vertex properties of a PLY file that sherd wrote which came with the user's mesh."""
    suffix = "_" + property_name(FROM_FILE)
    return {
        name.removesuffix(suffix): values
        for name, values in fields.items()
        if name.endswith(suffix)
    }


def stored_layers(fields: Mapping[str, Floats], *, carried: bool = False) -> tuple[Layer, ...]:
    """Layers from the vertex properties of a PLY file that sherd wrote, in their order.

    A name that sherd does not know is shown with the colors of a user's field.
    """
    names = {property_name(name): name for name in _KNOWN}
    suffix = property_name(FROM_FILE)
    layers = []
    for stored, values in fields.items():
        if stored in ("quality", "color") or values.ndim != 1:
            continue
        if stored in names:
            layers.append(known_layer(names[stored], values))
        elif stored == "error":
            layers.append(error_layer(values))
        else:
            shown = stored.removesuffix(f"_{suffix}") + FROM_FILE
            layers.append(Layer(shown, values, carried=carried))
    return tuple(layers)
