"""Colors that keep their meaning for color-blind readers, in print and on a dark page.

Color maps are interpolated in Oklab, where equal steps look equal, and their lightness runs one
way (there and back for "balance"), so that a gray print still orders the values.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from sherd.arrays import Bytes, Floats
from sherd.drawing.exhibit import Exhibit, Layer
from sherd.errors import OptionError
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = [
    "CATEGORY_COLORS",
    "MASK_COLORS",
    "NEUTRAL",
    "UNKNOWN",
    "color_table",
    "correspondence_layer",
    "full_layer",
    "layer_colors",
    "linear_from_srgb",
    "part_layer",
]


NEUTRAL = (205, 208, 214)  # a shape without a layer
UNKNOWN = (122, 128, 138)  # NaN, unmatched
MASK_COLORS = ((205, 208, 214), (226, 117, 29))  # outside, inside
# Okabe and Ito, *Color universal design*, 2008: eight hues that color-blind people tell apart.
CATEGORY_COLORS = (
    (230, 159, 0), (86, 180, 233), (0, 158, 115), (240, 228, 66),
    (0, 114, 178), (213, 94, 0), (204, 121, 167), (90, 90, 90),
)  # fmt: skip
CONTROL_POINTS = {
    "ember": ("#dfe0e2", "#f3d9b6", "#f2b470", "#e5852f", "#c8570f"),
    "lagoon": ("#20265c", "#2b5288", "#2c7f92", "#4aa985", "#98cb6d", "#f3e563"),
    "dusk": ("#35155a", "#6b3f98", "#a57bc0", "#d0bddb", "#ececec"),
    "balance": ("#17458f", "#5b93cc", "#b5d0e6", "#f0efeb", "#f1c092", "#db7f33", "#93400b"),
}
TABLE_SIZE = 256

# Ottosson, *A perceptual color space for image processing*, 2020: linear RGB -> cone response
# -> Oklab.
_CONES = np.array(
    [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
)
_OKLAB = np.array(
    [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
)


def srgb_from_oklab(oklab: Floats) -> Bytes:
    """(n, 3) Oklab to sRGB in 0..255, clipped to what a screen shows."""
    linear = np.linalg.solve(_OKLAB, oklab.T) ** 3
    linear = np.clip(np.linalg.solve(_CONES, linear).T, 0, 1)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.round(255 * encoded).astype(np.uint8)


def oklab_from_srgb(rgb: NDArray[np.generic]) -> Floats:
    """(n, 3) sRGB in 0..255 to Oklab."""
    oklab: Floats = np.cbrt(linear_from_srgb(rgb) @ _CONES.T) @ _OKLAB.T
    return oklab


def linear_from_srgb(rgb: NDArray[np.generic]) -> Floats:
    """Amounts of light in [0, 1], (n, 3), of sRGB in 0..255."""
    encoded = np.asarray(rgb, dtype=np.float64) / 255
    linear: Floats = np.where(
        encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4
    )
    return linear


@cache
def color_table(name: str) -> Bytes:
    """All 256 colors of a color map, (256, 3) sRGB.

    Raises
    ------
    OptionError
        If there is no color map of that name.

    Examples
    --------
    >>> color_table("lagoon").shape
    (256, 3)
    """
    if name not in CONTROL_POINTS:
        raise OptionError(f"color map is {name!r}, but must be one of {tuple(CONTROL_POINTS)}")
    points = np.array([tuple(bytes.fromhex(code[1:])) for code in CONTROL_POINTS[name]])
    oklab = oklab_from_srgb(points)
    places = np.linspace(0, len(points) - 1, TABLE_SIZE)
    smooth = [np.interp(places, np.arange(len(points)), oklab[:, axis]) for axis in range(3)]
    table = srgb_from_oklab(np.stack(smooth, axis=1))
    table.flags.writeable = False
    return table


def layer_colors(layer: Layer | None, count: int) -> Bytes:
    """Colors of a layer, (n, 3) sRGB; neutral for `count` vertices when there is no layer."""
    if layer is None:
        return np.full((count, 3), NEUTRAL, dtype=np.uint8)
    if layer.kind == "color":
        return np.asarray(layer.values, dtype=np.uint8)
    if layer.kind == "mask":
        masked: Bytes = np.array(MASK_COLORS, dtype=np.uint8)[layer.values.astype(np.int64)]
        return masked
    if layer.kind == "category":
        palette = np.array(layer.palette or CATEGORY_COLORS, dtype=np.uint8)
        chosen: Bytes = palette[layer.values % len(palette)]
        chosen[layer.values < 0] = UNKNOWN
        return chosen
    low, high = layer.limits
    finite = np.isfinite(layer.values)
    share = np.clip((np.where(finite, layer.values, low) - low) / (high - low), 0, 1)
    colors: Bytes = color_table(layer.color_map)[
        np.round(share * (TABLE_SIZE - 1)).astype(np.int64)
    ]
    colors[~finite] = UNKNOWN
    return colors


def correspondence_layer(full: TriangleMesh, *, name: str = "correspondence") -> Layer:
    """Smooth color for each place of the full shape, which the part shows through its partner.

    Lightness changes along the longest extent, blue to yellow along the second and green to
    red along the third, so that readers who cannot tell red from green lose the least.
    """
    low = full.vertices.min(axis=0)
    extent = full.vertices.max(axis=0) - low
    order = np.argsort(-extent, kind="stable")
    place = (full.vertices - low) / max(float(extent.max()), np.finfo(float).tiny)
    place -= 0.5 * extent / max(float(extent.max()), np.finfo(float).tiny)
    share = place / np.maximum(2 * np.abs(place).max(axis=0), np.finfo(float).tiny)  # -0.5 .. 0.5
    oklab = np.stack(
        [
            0.70 + 0.32 * share[:, order[0]],
            -0.26 * share[:, order[2]],
            0.06 - 0.34 * share[:, order[1]],
        ],
        axis=1,
    )
    return Layer(
        name,
        srgb_from_oklab(oklab),
        kind="color",
        description="Corresponding points have the same color; gray points have no partner.",
        carried=True,
    )


def full_layer(exhibit: Exhibit, name: str) -> Layer | None:
    """Layer that the full shape shows under `name`; carried colors are gray outside the region."""
    layer = next((layer for layer in exhibit.full_layers if layer.name == name), None)
    if layer is None or layer.kind != "color" or not layer.carried or exhibit.partner is None:
        return layer
    inside = np.asarray(exhibit.region)[:, None]
    return replace(layer, values=np.where(inside, layer.values, UNKNOWN))


def part_layer(exhibit: Exhibit, name: str) -> Layer | None:
    """Layer that the part shows under `name`: its own, or what its partner carries over."""
    for layer in exhibit.part_layers:
        if layer.name == name:
            return layer
    source = next((layer for layer in exhibit.full_layers if layer.name == name), None)
    if source is None or not source.carried or exhibit.partner is None:
        return None
    carried = exhibit.partner.carry(exhibit.full, source.values)
    if source.kind == "color":
        colors = np.where(np.isfinite(carried), carried, UNKNOWN)
        return Layer(name, np.round(colors), kind="color", description=source.description)
    if source.kind == "scalar":
        return Layer(
            name, carried, range=source.limits, unit=source.unit, color_map=source.color_map
        )
    nearest = source.values[exhibit.partner.points.nearest_vertices(exhibit.full)]
    if source.kind == "mask":
        return Layer(name, nearest & exhibit.partner.known, kind="mask")
    return Layer(
        name, np.where(exhibit.partner.known, nearest, -1), kind="category", labels=source.labels
    )
