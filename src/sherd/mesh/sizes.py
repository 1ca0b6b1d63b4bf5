"""How large a part may be: one rule for every question."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sherd.errors import InfeasibleError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.mesh.units import unit_proposal

__all__ = ["LARGEST_PART", "SMALLEST_PART", "check_areas", "check_sizes", "most_of_one_scale"]

# In area. A part is not larger than the whole, but skin stretches with the pose, by some percent
# over a body, and individuals differ: of bodies brought to the same height, areas by a fifth. What
# is larger still has another unit, or the two are swapped.
LARGEST_PART = 1.3
# In area: the smallest neighborhood that is compared is four times as wide as a part of a hundredth
# of the length. A full shape in millimeters and a part in meters are farther apart still.
SMALLEST_PART = 1e-4


def check_areas(*meshes: TriangleMesh) -> None:
    """Refuse shapes without area.

    Raises
    ------
    InfeasibleError
        If a shape has no area, or one that is not finite.
    """
    for mesh in meshes:
        if not (np.isfinite(mesh.area) and mesh.area > 0):
            raise InfeasibleError(
                f"{mesh.name}: the surface has area {mesh.area}, so nothing can be matched; "
                "its faces are degenerate or its coordinates too small"
            )


def check_sizes(
    full: TriangleMesh,
    part: TriangleMesh,
    *,
    factor: float = 1.0,
    options: bool = False,
) -> None:
    """Refuse a part that cannot lie on the full shape by its size.

    Parameters
    ----------
    full, part
        In their own units.
    factor
        What lengths of the part are multiplied by.
    options
        Whether the question has options for scale and units, which the message then proposes.

    Raises
    ------
    InfeasibleError
        If a shape has no area, or the part is more than 1.3 times as large as the full shape, or
        a dot on it. The message names units that would explain it.
    """
    check_areas(full, part)
    ratio = part.area * factor**2 / full.area
    if SMALLEST_PART <= ratio <= LARGEST_PART:
        return
    said = f"{part.name} has {ratio:.4g} times the area of {full.name}"
    if factor != 1.0:
        said += f" once its lengths are multiplied by {factor:.6g}"
    if ratio > 1:
        said += (
            f", but a part is at most {LARGEST_PART} times as large as the full shape; are the two "
            "swapped, or in different units?"
        )
    else:
        said += ", too little to be found there; are the two in different units?"
    proposal = unit_proposal(np.sqrt(ratio), options=options) if factor == 1.0 else ""
    raise InfeasibleError(f"{said} T{proposal[1:]}" if proposal else said)


def most_of_one_scale(areas: Sequence[float]) -> tuple[int, ...]:
    """The most of some shapes of which none is a dot beside another one; by number, in order.

    If there are several such choices, that of the largest shapes.

    Examples
    --------
    >>> most_of_one_scale([2.0, 3e6, 1.0])
    (0, 2)
    """
    falling = sorted(range(len(areas)), key=lambda number: -areas[number])
    best: list[int] = []
    for first, number in enumerate(falling):
        here = [each for each in falling[first:] if areas[each] > SMALLEST_PART * areas[number]]
        best = max(best, here, key=len)
    return tuple(sorted(best))
