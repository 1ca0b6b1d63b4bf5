"""A closed triangle mesh of a level set: surface nets on a regular grid."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from sherd.arrays import Bools, Floats, Ints

__all__ = ["surface_nets"]


# Side of the blocks that are skipped when the surface cannot reach them.
BLOCK = 4
_CORNERS = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), axis=-1).reshape(-1, 3)


def surface_nets(
    function: Callable[[Floats], Floats], lower: Floats, upper: Floats, *, spacing: float
) -> tuple[Floats, Ints]:
    """Vertices and faces of the level set `function = 0` in a box, outward where it grows.

    One vertex in each grid cell that the surface crosses, at the mean of the crossings of the
    cell's edges; one quadrilateral, cut along its shorter diagonal, for each grid edge crossed.

    Parameters
    ----------
    function
        (p, 3) points to (p,) values that change by at most the distance between points
        (a signed distance, or less steep), positive at the border of the box.
    lower, upper
        (3,) corners of the box, l.
    spacing
        Edge of a grid cell, l.

    References
    ----------
    Gibson, *Constrained elastic surface nets*, 1998.
    """
    shape = (np.ceil((upper - lower) / (BLOCK * spacing)).astype(int) + 1) * BLOCK
    values = _sampled(function, lower, shape, spacing)
    cells, number = _crossed_cells(values < 0)
    vertices = lower + spacing * _cell_vertices(values, cells)
    return vertices, _triangles(vertices, _quadrilaterals(values < 0, number))


def _sampled(
    function: Callable[[Floats], Floats], lower: Floats, shape: Ints, spacing: float
) -> Floats:
    """Values on the grid; far from the surface one value stands for its whole block."""
    blocks = shape // BLOCK
    corner = np.stack(np.meshgrid(*map(np.arange, blocks), indexing="ij"), axis=-1).reshape(-1, 3)
    middle = lower + spacing * (BLOCK * corner + 0.5 * (BLOCK - 1))
    coarse = function(middle)
    # half a block's diagonal, and one more cell for the edges that leave the block
    near = np.abs(coarse) <= spacing * (0.5 * BLOCK + 1) * np.sqrt(3)
    tiles = np.repeat(coarse[:, None], BLOCK**3, axis=1)
    offsets = np.stack(np.meshgrid(*[np.arange(BLOCK)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    points = lower + spacing * (BLOCK * corner[near][:, None] + offsets)
    tiles[near] = function(points.reshape(-1, 3)).reshape(-1, BLOCK**3)
    stacked = tiles.reshape(*blocks, BLOCK, BLOCK, BLOCK).transpose(0, 3, 1, 4, 2, 5)
    return stacked.reshape(tuple(shape))


def _crossed_cells(inside: Bools) -> tuple[Ints, Ints]:
    """Cells (v, 3) with corners on both sides, and the number of each cell (-1 elsewhere)."""
    size = np.array(inside.shape) - 1
    count = np.zeros(size, dtype=np.int8)
    for i, j, k in _CORNERS:
        count += inside[i : i + size[0], j : j + size[1], k : k + size[2]]
    mixed = (count > 0) & (count < 8)
    number = np.full(size, -1, dtype=np.int64)
    number[mixed] = np.arange(int(mixed.sum()))
    return np.argwhere(mixed), number


def _cell_vertices(values: Floats, cells: Ints) -> Floats:
    """Mean of the points where the edges of each cell cross the level, (v, 3) in grid units."""
    corner = {tuple(c): values[tuple((cells + c).T)] for c in _CORNERS}
    total, crossings = np.zeros((len(cells), 3)), np.zeros((len(cells), 1))
    for start, low in corner.items():
        for axis in range(3):
            if start[axis] == 1:
                continue
            end = tuple(1 if a == axis else c for a, c in enumerate(start))
            high = corner[end]
            crossed = (low < 0) != (high < 0)
            t = np.divide(low, low - high, out=np.zeros_like(low), where=crossed)
            point = np.tile(np.array(start, dtype=float), (len(cells), 1))
            point[:, axis] = t
            total[crossed] += point[crossed]
            crossings[crossed] += 1
    return cells + total / crossings


def _quadrilaterals(inside: Bools, number: Ints) -> Ints:
    """The four cells around each crossed grid edge, (q, 4), counterclockwise from outside."""
    faces = []
    for axis in range(3):
        second, third = (axis + 1) % 3, (axis + 2) % 3
        lead = np.moveaxis(inside, (axis, second, third), (0, 1, 2))
        cell = np.moveaxis(number, (axis, second, third), (0, 1, 2))
        low, high = lead[:-1, 1:-1, 1:-1], lead[1:, 1:-1, 1:-1]
        for leaving in (True, False):
            i, j, k = np.nonzero((low & ~high) if leaving else (~low & high))
            ring = [cell[i, j, k], cell[i, j + 1, k], cell[i, j + 1, k + 1], cell[i, j, k + 1]]
            faces.append(np.stack(ring if leaving else ring[::-1], axis=1))
    return np.concatenate(faces)


def _triangles(vertices: Floats, quadrilaterals: Ints) -> Ints:
    a, b, c, d = vertices[quadrilaterals].transpose(1, 0, 2)
    straight = np.linalg.norm(c - a, axis=1) <= np.linalg.norm(d - b, axis=1)
    first = np.where(straight[:, None], quadrilaterals[:, [0, 1, 2]], quadrilaterals[:, [0, 1, 3]])
    second = np.where(straight[:, None], quadrilaterals[:, [0, 2, 3]], quadrilaterals[:, [1, 2, 3]])
    return np.concatenate([first, second])
