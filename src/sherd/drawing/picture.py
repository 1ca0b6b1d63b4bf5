"""A picture of an exhibit without display or GPU: both shapes, shaded, with a color bar."""

from __future__ import annotations

import io
import os
from dataclasses import dataclass
from functools import partial

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from sherd.arrays import Floats
from sherd.drawing.alignment import rotation_to_full
from sherd.drawing.camera import View, best_view, upward
from sherd.drawing.color_bar import draw_legend
from sherd.drawing.colors import full_layer, layer_colors, part_layer
from sherd.drawing.exhibit import Exhibit, Layer
from sherd.errors import OptionError
from sherd.limits import require_memory, require_whole
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import write_bytes
from sherd.threads import side_by_side

__all__ = ["Staging", "picture", "png_bytes", "stage", "without_heading", "write_picture"]


INK = (28, 32, 38, 255)
GRAY = (104, 110, 120, 255)
AMBER = (168, 84, 0, 255)
# Half of a closed surface is hidden from anywhere; a view from behind is worth its space when
# less than this share of the region is seen.
LEAST_VISIBLE_SHARE = 0.3
# A part smaller than this share of the full shape's extent is drawn larger; the scale bars tell.
LEAST_EXTENT_SHARE = 0.55
# The bar of the scale is at most so long, in points.
SCALE_BAR = 120
# White around a shape, relative to its panel.
MARGIN = 0.05
# Rows of a picture 1,600 wide: for title and verdict, and free above the shapes.
HEADING, ABOVE = 70, 30
# Two shapes with words need 400 pixels; 10,000 are A3 across at 600 dots per inch.
WIDTHS = (400, 10_000)
# Three copies of a picture half as high as wide, 4 bytes a pixel, and a third more for a band of
# rays of each panel.
BYTES_PER_SQUARE = 8


@dataclass(frozen=True, eq=False)
class Staging:
    """How an exhibit is looked at; picture and page share it.

    Parameters
    ----------
    view
        Camera for the full shape.
    part_rotation
        (3, 3), applied to the part before the same camera looks at it.
    up
        (3,) direction of the full shape that points up.
    """

    view: View
    part_rotation: Floats
    up: Floats


def stage(exhibit: Exhibit) -> Staging:
    """Choose the camera so that the region is seen, and turn the part the same way."""
    up = upward(exhibit.full) if exhibit.up is None else np.array(exhibit.up, dtype=np.float64)
    up = up / np.linalg.norm(up)
    view = best_view(exhibit.full, np.asarray(exhibit.region), up)
    turn = np.eye(3) if exhibit.part_stands else rotation_to_full(exhibit)
    return Staging(view, turn, up)


def picture(
    exhibit: Exhibit,
    *,
    layer: str | None = None,
    width: int = 1600,
    transparent: bool = False,
    heading: bool = True,
    staging: Staging | None = None,
) -> Image.Image:
    """Full shape and part side by side with title, captions and color bar, RGBA.

    Parameters
    ----------
    layer
        Name of the coloring; the first one of the full shape when None.
    width
        In pixels; the height is about half of it.
    transparent
        No background instead of white.
    heading
        Whether the title stands above.
    staging
        A camera chosen before, for pictures that shall look alike.

    Raises
    ------
    OptionError
        If no layer has that name, the width is not within 400 and 10,000, or memory is short.

    Notes
    -----
    The same exhibit gives the same bytes. A second view from behind is added when the first one
    hides much of the region.
    """
    require_whole("width", width, *WIDTHS, "fewer do not hold two shapes, and more fill no page")
    require_memory(BYTES_PER_SQUARE * width**2, f"a picture {width} wide", "ask for a smaller one")
    panels = _panels(exhibit, layer, staging or stage(exhibit))
    unit = width / 1600
    size = (width // len(panels), round(0.40 * width))
    scale, part_scale = _scales(panels, size)
    scales = [part_scale if panel.role == exhibit.names[1] else scale for panel in panels]
    tallest = max(panel.extent[1] * pixels for panel, pixels in zip(panels, scales, strict=True))
    size = (size[0], min(size[1], round(tallest * (1 + 2 * MARGIN))))
    top, bottom = round((HEADING + ABOVE if heading else ABOVE) * unit), round(176 * unit)
    background = (255, 255, 255, 0 if transparent else 255)
    image = Image.new("RGBA", (width, top + size[1] + bottom), background)
    draw = ImageDraw.Draw(image)
    if heading:
        place = (round(40 * unit), round(30 * unit))
        draw.text(place, exhibit.title, fill=INK, font=_font(34 * unit))
        if exhibit.verdict is not None and not exhibit.verdict.trusted:
            below = (place[0], round(72 * unit))
            draw.text(below, exhibit.verdict.words, fill=AMBER, font=_font(26 * unit))
    rendered = side_by_side(
        partial(_rendered, panel, size, pixels)
        for panel, pixels in zip(panels, scales, strict=True)
    )
    for index, (panel, pixels) in enumerate(zip(panels, scales, strict=True)):
        image.alpha_composite(rendered[index], (index * size[0], top))
        middle = (index * size[0] + size[0] // 2, top + size[1] + round(24 * unit))
        _write_caption(draw, panel, middle=middle, unit=unit, room=size[0])
        _draw_scale_bar(draw, panel, pixels, middle=middle, unit=unit)
    box = (round(0.28 * width), top + size[1] + round(92 * unit), round(0.44 * width))
    shown = panels[0].layer or panels[-1].layer
    draw_legend(draw, shown, panels[-1].layer, box=box, unit=unit, inks=(INK, GRAY))
    return image


def write_picture(
    exhibit: Exhibit, path: str | os.PathLike[str], *, layer: str | None = None
) -> None:
    """Write :func:`picture` as PNG; the file appears complete or not at all.

    Raises
    ------
    OptionError
        If no layer has that name.
    OutputError
        If the file cannot be written.
    """
    write_bytes(path, png_bytes(picture(exhibit, layer=layer)))


def without_heading(image: Image.Image) -> Image.Image:
    """What :func:`picture` with a heading is without one."""
    top = round((HEADING + ABOVE) * image.width / 1600) - round(ABOVE * image.width / 1600)
    return image.crop((0, top, image.width, image.height))


def png_bytes(image: Image.Image) -> bytes:
    """Image as PNG, without alpha where everything is opaque."""
    stream = io.BytesIO()
    if image.getchannel("A").getextrema() == (255, 255):
        image = image.convert("RGB")
    image.save(stream, "PNG")  # to optimize takes seven times as long for 4 % of the size
    return stream.getvalue()


@dataclass(frozen=True, eq=False)
class _Panel:
    mesh: TriangleMesh
    layer: Layer | None
    rotation: Floats
    role: str

    @property
    def extent(self) -> Floats:
        """Width and height of the shape as seen, (2,) l."""
        size: Floats = np.ptp(self.mesh.vertices @ self.rotation.T, axis=0)[:2]
        return np.maximum(size, np.finfo(float).tiny)


def _panels(exhibit: Exhibit, layer: str | None, staging: Staging) -> list[_Panel]:
    full, part = _layers_named(exhibit, layer)
    panels = [_Panel(exhibit.full, full, staging.view.rotation, exhibit.names[0])]
    if staging.view.visible_share < LEAST_VISIBLE_SHARE:
        panels.append(_Panel(exhibit.full, full, staging.view.opposite.rotation, "From behind"))
    rotation = staging.view.rotation @ staging.part_rotation
    return [*panels, _Panel(exhibit.part, part, rotation, exhibit.names[1])]


def _layers_named(exhibit: Exhibit, name: str | None) -> tuple[Layer | None, Layer | None]:
    if name is None:
        layers = exhibit.full_layers or exhibit.part_layers
        if not layers:
            return None, None
        name = layers[0].name
    full, part = full_layer(exhibit, name), part_layer(exhibit, name)
    if full is None and part is None:
        names = [layer.name for layer in (*exhibit.full_layers, *exhibit.part_layers)]
        raise OptionError(f"layer is {name!r}, but there are only {names}")
    return full, part


def _scales(panels: list[_Panel], size: tuple[int, int]) -> tuple[float, float]:
    """Pixels per length of the full shape and of the part.

    Both are the same unless the part would be tiny beside the full shape, or would not fit.
    """
    room = np.array(size) * (1 - 2 * MARGIN)
    scale = min(float(np.min(room / panel.extent)) for panel in panels[:-1])
    fitting = float(np.min(room / panels[-1].extent))
    share = float(np.max(panels[-1].extent) / np.max(panels[0].extent))
    return scale, min(fitting, scale * max(1.0, LEAST_EXTENT_SHARE / share))


def _rendered(panel: _Panel, size: tuple[int, int], pixels: float) -> Image.Image:
    from sherd.drawing.raster_kernel import shaded_image  # noqa: PLC0415  numba loads on first use

    mesh = panel.mesh
    placed = mesh.vertices @ panel.rotation.T
    placed = (placed - (placed.min(axis=0) + placed.max(axis=0)) / 2) * pixels
    normals, faces = mesh.vertex_normals @ panel.rotation.T, mesh.faces
    facing = mesh.winding
    if facing < 0:
        normals, faces = -normals, np.ascontiguousarray(faces[:, ::-1])
    image = shaded_image(
        placed * [1.0, -1.0, -1.0] + [size[0] / 2, size[1] / 2, 0.0],
        faces,
        normals=normals,
        colors=layer_colors(panel.layer, mesh.vertex_count),
        width=size[0],
        height=size[1],
        two_sided=facing == 0,
    )
    return Image.fromarray(image)


def _write_caption(
    draw: ImageDraw.ImageDraw,
    panel: _Panel,
    *,
    middle: tuple[int, int],
    unit: float,
    room: int,
) -> None:
    draw.text(middle, panel.role, fill=INK, font=_font(24 * unit), anchor="mm")
    if panel.role == "From behind":
        return
    words = f", {panel.mesh.vertex_count:,} vertices"
    name, font = panel.mesh.name, _font(20 * unit)
    while len(name) > 9 and draw.textlength(name + words, font=font) > 0.94 * room:
        name = name[: len(name) // 2 - 2] + "..." + name[len(name) // 2 + 2 :]
    below = (middle[0], middle[1] + round(30 * unit))
    draw.text(below, name + words, fill=GRAY, font=font, anchor="mm")


def _draw_scale_bar(
    draw: ImageDraw.ImageDraw,
    panel: _Panel,
    pixels: float,
    *,
    middle: tuple[int, int],
    unit: float,
) -> None:
    """A bar of a round length in the file's unit, right of the panel's name."""
    length = round_length(SCALE_BAR * unit / pixels)
    half = draw.textlength(panel.role, font=_font(24 * unit)) / 2
    left, (center, height) = round(40 * unit), middle
    start, stop = center + half + left, center + half + left + length * pixels
    width = max(1, round(2 * unit))
    draw.line((start, height, stop, height), fill=GRAY, width=width)
    for end in (start, stop):
        draw.line((end, height - 5 * unit, end, height + 5 * unit), fill=GRAY, width=width)
    words = f"{length:.6g}"
    draw.text((stop + 10 * unit, height), words, fill=GRAY, font=_font(18 * unit), anchor="lm")


def round_length(longest: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is not above `longest`.

    Examples
    --------
    >>> round_length(0.037), round_length(50.0), round_length(7.0)
    (0.02, 50.0, 5.0)
    """
    power = 10.0 ** np.floor(np.log10(longest))
    return float(f"{max(n * power for n in (1, 2, 5) if n * power <= longest * (1 + 1e-9)):.6g}")


def _font(size: float) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(size=max(8.0, round(size)))
