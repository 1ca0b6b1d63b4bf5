"""Pictures and curves of the paper's figures; matplotlib is imported only when one is drawn."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sherd.arrays import Floats
from sherd.drawing.colors import layer_colors
from sherd.drawing.exhibit import Layer
from sherd.errors import OptionError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import write_bytes

__all__ = ["check_plotting", "draw_curves", "draw_panels", "shape_image"]

Image = NDArray[np.uint8]

PANEL = (420, 320)
MARGIN = 0.04
# Okabe and Ito's colors, told apart by color-blind readers, with markers for print.
LINE_COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
MARKERS = ("o", "s", "^", "D", "v", "P")


def check_plotting() -> None:
    """Refuse early if matplotlib is missing.

    Raises
    ------
    OptionError
        If it is; the message says how to install it.
    """
    try:
        import matplotlib  # noqa: F401, PLC0415  optional
    except ImportError as error:
        raise OptionError(
            "the figures need matplotlib; install it with: pip install 'sherd[plots]'"
        ) from error


def shape_image(
    mesh: TriangleMesh,
    layer: Layer | None,
    rotation: Floats,
    *,
    size: tuple[int, int] = PANEL,
) -> Image:
    """A mesh seen through a camera rotation (3, 3), (height, width, 3) on white."""
    from sherd.drawing.raster_kernel import shaded_image  # noqa: PLC0415  numba loads on first use

    width, height = size
    placed = mesh.vertices @ rotation.T
    extent = np.ptp(placed, axis=0)[:2]
    pixels = float(np.min(np.array(size) * (1 - 2 * MARGIN) / extent))
    placed = (placed - (placed.min(axis=0) + placed.max(axis=0)) / 2) * pixels
    normals, faces = mesh.vertex_normals @ rotation.T, mesh.faces
    facing = mesh.winding
    if facing < 0:
        normals, faces = -normals, np.ascontiguousarray(faces[:, ::-1])
    image = shaded_image(
        placed * [1.0, -1.0, -1.0] + [width / 2, height / 2, 0.0],
        faces,
        normals=normals,
        colors=layer_colors(layer, mesh.vertex_count),
        width=width,
        height=height,
        two_sided=facing == 0,
    )
    opacity = image[..., 3:].astype(np.float64) / 255
    white: Image = np.round(opacity * image[..., :3] + (1 - opacity) * 255).astype(np.uint8)
    return white


def draw_panels(
    path: Path,
    images: Sequence[Sequence[Image]],
    *,
    titles: Sequence[str],
    row_names: Sequence[str] = (),
    heading: str,
) -> None:
    """Write a grid of images as PNG; `titles` head the columns, `row_names` the rows."""
    figure, axes = _figure(len(images), len(images[0]), (3.3, 2.7))
    for row, line in enumerate(images):
        for column, image in enumerate(line):
            axis = axes[row][column]
            axis.imshow(image)
            axis.set_xticks([])
            axis.set_yticks([])
            for spine in axis.spines.values():
                spine.set_visible(False)
            if row == 0:
                axis.set_title(titles[column], fontsize=10)
            if column == 0 and row_names:
                axis.set_ylabel(row_names[row], fontsize=10)
    _write(figure, path, heading)


def draw_curves(
    path: Path,
    series: Mapping[str, tuple[Sequence[float], Sequence[float]]],
    *,
    labels: tuple[str, str],
    heading: str,
    logarithmic: tuple[bool, bool] = (False, False),
    marks: Mapping[str, float] | None = None,
) -> None:
    """Write lines (x, y) by name as PNG; `marks` are vertical dashed lines at x by name."""
    figure, axes = _figure(1, 1, (6.4, 4.2))
    axis = axes[0][0]
    for number, (name, (x, y)) in enumerate(series.items()):
        style = {
            "color": LINE_COLORS[number % len(LINE_COLORS)],
            "marker": MARKERS[number % len(MARKERS)],
        }
        axis.plot(x, y, label=name, markersize=4, linewidth=1.4, **style)
    for name, place in (marks or {}).items():
        axis.axvline(place, color="#777777", linestyle="--", linewidth=1)
        axis.annotate(name, (place, 0.97), xycoords=("data", "axes fraction"), fontsize=9, va="top")
    axis.set_xlabel(labels[0])
    axis.set_ylabel(labels[1])
    axis.set_xscale("log" if logarithmic[0] else "linear")
    axis.set_yscale("log" if logarithmic[1] else "linear")
    axis.grid(visible=True, color="#dddddd", linewidth=0.6)
    if series:  # matplotlib warns of a legend without entries
        axis.legend(frameon=False, fontsize=9)
    _write(figure, path, heading)


def _figure(rows: int, columns: int, panel: tuple[float, float]) -> tuple[Any, Any]:
    from matplotlib.figure import Figure  # noqa: PLC0415  optional, without the pyplot state

    figure = Figure(figsize=(columns * panel[0], rows * panel[1] + 0.5), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False)


def _write(figure: Any, path: Path, heading: str) -> None:
    figure.suptitle(heading, fontsize=11)
    stream = io.BytesIO()
    # no date in the file, so that the same numbers give the same bytes
    figure.savefig(stream, format="png", dpi=110, metadata={"Software": None})
    write_bytes(path, stream.getvalue())
