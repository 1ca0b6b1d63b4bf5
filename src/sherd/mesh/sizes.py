"""How large a part may be: one rule for every question."""

from __future__ import annotations

import numpy as np

from sherd.errors import InfeasibleError
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["LARGEST_PART", "SMALLEST_PART", "check_sizes"]

# In area. A part is not larger than the whole, but skin stretches with the pose, by some percent
# over a body, and individuals differ: of bodies brought to the same height, areas by a fifth. What
# is larger still has another unit, or the two are swapped.
LARGEST_PART = 1.3
# In area: a part 3e-5 of the length of the full shape lies between the vertices of any mesh.
SMALLEST_PART = 1e-9


def check_sizes(full: TriangleMesh, part: TriangleMesh, *, largest_scale: float = 1.0) -> None:
    """Refuse a part that cannot lie on the full shape by its size.

    Parameters
    ----------
    full, part
        In their own units.
    largest_scale
        How many times the part may be shrunk; above 1 where its scale is unknown.

    Raises
    ------
    InfeasibleError
        If a shape has no area, or the part is more than 1.3 times as large as the full shape, or
        a dot on it.
    """
    for mesh in (full, part):
        if not (np.isfinite(mesh.area) and mesh.area > 0):
            raise InfeasibleError(
                f"{mesh.name}: the surface has area {mesh.area}, so nothing can be matched; "
                "its faces are degenerate or its coordinates too small"
            )
    ratio = part.area / full.area
    if ratio > LARGEST_PART * largest_scale**2:
        raise InfeasibleError(
            f"{part.name} has {ratio:.4g} times the area of {full.name}, but a part is at most "
            f"{LARGEST_PART} times as large as the full shape; are the two swapped, or in "
            "different units?"
        )
    if ratio < SMALLEST_PART:
        raise InfeasibleError(
            f"{part.name} has {ratio:.2g} times the area of {full.name}, too "
            "little to be found there; are the two in different units?"
        )
