"""A compiled rasterizer: triangles to pixels with a depth buffer and smooth shading, no GPU."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sherd.arrays import Bools, Floats, Ints
from sherd.compiled import compiled

__all__ = ["covered_faces", "shaded_image"]


# Pixels across a tile: large enough that looking at a tile costs little beside drawing in it.
TILE = 16
# Finding where a row of pixels crosses a face costs as much as testing so many of them.
WIDE = 8
# Rows of rays drawn together. A face is drawn in each of the bands that it meets, mostly one, and a
# whole panel would take 55 MB, an eighth of what a `locate` takes in all.
BAND = 16 * TILE
# A pixel on the edge of two faces is at least in one of them, whichever way it is rounded.
ROUNDING = -1e-9


def covered_faces(points: Floats, faces: Ints, *, width: int, height: int) -> NDArray[np.int32]:
    """Face seen at each pixel center, (height, width) int32, -1 where there is none.

    Parameters
    ----------
    points
        (n, 3): pixel column, pixel row, and depth that grows away from the viewer.
    faces
        (m, 3).
    width, height
        Of the image in pixels.
    """
    drawn = np.flatnonzero(_drawn_once(points, faces))
    nearest: NDArray[np.int32] = _nearest_faces(points, faces[drawn], width, height)
    seen = nearest >= 0
    nearest[seen] = drawn[nearest[seen]]
    return nearest


def shaded_image(
    points: Floats,
    faces: Ints,
    *,
    normals: Floats,
    colors: NDArray[np.uint8],
    width: int,
    height: int,
    samples: int = 3,
    two_sided: bool = False,
) -> NDArray[np.uint8]:
    """Shaded picture, (height, width, 4) RGBA, transparent where there is no surface.

    Parameters
    ----------
    points
        (n, 3): pixel column, pixel row, and depth that grows away from the viewer.
    faces
        (m, 3).
    normals
        (n, 3) unit vertex normals in the frame of the viewer: right, up, toward the viewer.
    colors
        (n, 3) sRGB.
    width, height
        Of the image in pixels.
    samples
        Each pixel is the mean of samples x samples rays.
    two_sided
        For faces that do not agree on what is outside: no side is drawn as the inside.
    """
    fine = points * np.array([samples, samples, 1.0])
    light = colors.astype(np.float64)
    image = np.zeros((height, width, 4), dtype=np.uint8)
    faces = faces[_drawn_once(fine, faces)]
    rows = fine[:, 1][faces]
    first, last = rows.min(axis=1), rows.max(axis=1)
    for top in range(0, height, BAND // samples):
        band = image[top : top + BAND // samples]
        low, high = top * samples, (top + len(band)) * samples
        met = faces[(first <= high) & (last >= low)]
        moved = fine - np.array([0.0, low, 0.0])
        nearest = _nearest_faces(moved, met, width * samples, high - low)
        _shade(band, nearest, moved, met, normals, light, samples, two_sided)
    return image


def _drawn_once(points: Floats, faces: Ints) -> Bools:
    """(m,) bool, False for large faces that are drawn already; thousands would cost much."""
    drawn = np.ones(len(faces), dtype=bool)
    large = np.flatnonzero(_large_faces(points, faces))
    if len(large):
        corners = points[faces[large]].reshape(-1, 3)
        places = np.unique(corners, axis=0, return_inverse=True)[1].reshape(-1, 3)
        first = np.unique(np.sort(places, axis=1), axis=0, return_index=True)[1]
        drawn[large] = False
        drawn[large[first]] = True
    return drawn


@compiled()
def _large_faces(points, faces):
    """(m,) bool, whether the box around a face is larger than a tile."""
    large = np.zeros(len(faces), np.bool_)
    for face in range(len(faces)):
        a, b, c = _corners(points, faces, face)
        wide = max(a[0], b[0], c[0]) - min(a[0], b[0], c[0])
        high = max(a[1], b[1], c[1]) - min(a[1], b[1], c[1])
        large[face] = wide * high > TILE * TILE
    return large


@compiled()
def _nearest_faces(points, faces, width, height):
    depth = np.full((height, width), np.inf)
    nearest = np.full((height, width), -1, dtype=np.int32)
    # farthest depth in each tile: a face behind it cannot be seen there, so that thousands of
    # faces as large as the picture are drawn about as fast as thousands of small ones
    farthest = np.full((height // TILE + 1, width // TILE + 1), np.inf)
    for face in range(len(faces)):
        a, b, c = _corners(points, faces, face)
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if area == 0.0:
            continue
        left = max(0, int(np.ceil(min(a[0], b[0], c[0]) - 0.5)))
        right = min(width - 1, int(np.floor(max(a[0], b[0], c[0]) - 0.5)))
        top = max(0, int(np.ceil(min(a[1], b[1], c[1]) - 0.5)))
        bottom = min(height - 1, int(np.floor(max(a[1], b[1], c[1]) - 0.5)))
        if right < left or bottom < top:
            continue
        if (right - left + 1) * (bottom - top + 1) <= TILE * TILE:
            box = (left, right, top, bottom)
            _draw(depth, nearest, face, (a, b, c), area, box)
            continue
        front = min(a[2], b[2], c[2])
        across = ((b[2] - a[2]) * (c[1] - a[1]) - (c[2] - a[2]) * (b[1] - a[1])) / area
        down = ((c[2] - a[2]) * (b[0] - a[0]) - (b[2] - a[2]) * (c[0] - a[0])) / area
        reach = 0.5 * TILE * (abs(across) + abs(down))
        for i in range(top // TILE, bottom // TILE + 1):
            low, high = _across(a, b, c, float(i * TILE), float((i + 1) * TILE))
            for j in range(max(left, int(low)) // TILE, min(right, int(high)) // TILE + 1):
                x, y = (j + 0.5) * TILE - a[0], (i + 0.5) * TILE - a[1]
                if max(front, a[2] + across * x + down * y - reach) >= farthest[i, j]:
                    continue
                box = (
                    max(left, j * TILE),
                    min(right, j * TILE + TILE - 1),
                    max(top, i * TILE),
                    min(bottom, i * TILE + TILE - 1),
                )
                if _draw(depth, nearest, face, (a, b, c), area, box):
                    rows, columns = slice(i * TILE, (i + 1) * TILE), slice(j * TILE, (j + 1) * TILE)
                    farthest[i, j] = depth[rows, columns].max()
    return nearest


@compiled()
def _corners(points, faces, face):
    """As tuples of numbers: rows of an array, looked up at every pixel, take four times as long."""
    i, j, k = faces[face, 0], faces[face, 1], faces[face, 2]
    a = (points[i, 0], points[i, 1], points[i, 2])
    b = (points[j, 0], points[j, 1], points[j, 2])
    c = (points[k, 0], points[k, 1], points[k, 2])
    return a, b, c


@compiled()
def _across(a, b, c, top, bottom):
    """Least and largest column of a triangle between two rows; of long slivers it is little."""
    low, high = np.inf, -np.inf
    for p, q in ((a, b), (b, c), (c, a)):
        if max(p[1], q[1]) < top or min(p[1], q[1]) > bottom:
            continue
        rise = q[1] - p[1]
        start, end = 0.0, 1.0
        if rise != 0.0:
            enter, leave = (top - p[1]) / rise, (bottom - p[1]) / rise
            start, end = max(0.0, min(enter, leave)), min(1.0, max(enter, leave))
        for share in (start, end):
            column = p[0] + share * (q[0] - p[0])
            low, high = min(low, column), max(high, column)
    if low > high:  # the rows pass between its corners
        return 0.0, -1.0
    return max(low, 0.0), min(max(high, -1.0), 1e9)


@compiled()
def _draw(depth, nearest, face, corners, area, box):
    """Draw one face within the pixels (left, right, top, bottom); whether any is new."""
    a, b, c = corners
    left, right, top, bottom = box
    drawn = False
    # barycentric coordinates and depth along a row: affine in the column
    u_step, v_step = (b[1] - c[1]) / area, (c[1] - a[1]) / area
    z_step = u_step * (a[2] - c[2]) + v_step * (b[2] - c[2])
    for row in range(top, bottom + 1):
        y = row + 0.5
        u_start = (b[0] * (c[1] - y) - (b[1] - y) * c[0]) / area
        v_start = (c[0] * (a[1] - y) - (c[1] - y) * a[0]) / area
        z_start = c[2] + u_start * (a[2] - c[2]) + v_start * (b[2] - c[2])
        first, last = left, right
        if right - left >= WIDE:
            low, high = _across(a, b, c, y, y)
            first, last = max(left, int(low) - 1), min(right, int(high) + 1)
        for column in range(first, last + 1):
            x = column + 0.5
            u, v = u_start + u_step * x, v_start + v_step * x
            if u < ROUNDING or v < ROUNDING or 1.0 - u - v < ROUNDING:
                continue
            z = z_start + z_step * x
            if z < depth[row, column]:
                depth[row, column] = z
                nearest[row, column] = face
                drawn = True
    return drawn


@compiled()
def _shade(image, nearest, points, faces, normals, colors, samples, two_sided):
    height, width = image.shape[0], image.shape[1]
    for row in range(height):
        for column in range(width):
            red = green = blue = 0.0
            hits = 0
            for i in range(row * samples, (row + 1) * samples):
                for j in range(column * samples, (column + 1) * samples):
                    face = nearest[i, j]
                    if face < 0:
                        continue
                    r, g, b = _ray(
                        face, j + 0.5, i + 0.5, points, faces, normals, colors, two_sided
                    )
                    red, green, blue = red + r, green + g, blue + b
                    hits += 1
            if hits:
                image[row, column, 0] = int(min(255.0, red / hits) + 0.5)
                image[row, column, 1] = int(min(255.0, green / hits) + 0.5)
                image[row, column, 2] = int(min(255.0, blue / hits) + 0.5)
                image[row, column, 3] = int(255.0 * hits / (samples * samples) + 0.5)


@compiled()
def _ray(face, x, y, points, faces, normals, colors, two_sided):
    """Color of one ray. The viewer's shader says the same in the same numbers.

    Light is wrapped around the form (half Lambert), so that no side is black and colors stay
    readable; a weak highlight and darker rims give depth. The inside of a shell is grayer.
    """
    i, j, k = faces[face, 0], faces[face, 1], faces[face, 2]
    a, b, c = _corners(points, faces, face)
    area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    u = ((b[0] - x) * (c[1] - y) - (b[1] - y) * (c[0] - x)) / area
    v = ((c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x)) / area
    w = 1.0 - u - v
    nx = u * normals[i, 0] + v * normals[j, 0] + w * normals[k, 0]
    ny = u * normals[i, 1] + v * normals[j, 1] + w * normals[k, 1]
    nz = u * normals[i, 2] + v * normals[j, 2] + w * normals[k, 2]
    length = max(np.sqrt(nx * nx + ny * ny + nz * nz), 1e-12)
    inside = area > 0.0  # rows grow downward, so a counterclockwise face has negative area
    sign = -1.0 if inside else 1.0
    if two_sided:
        inside, sign = False, -1.0 if nz < 0.0 else 1.0
    nx, ny, nz = sign * nx / length, sign * ny / length, max(0.0, sign * nz / length)
    key = max(0.0, 0.5 + 0.5 * (-0.42 * nx + 0.62 * ny + 0.66 * nz))
    shade = 0.48 + 0.60 * key * key
    shade *= 0.82 + 0.18 * nz
    half = max(0.0, -0.23 * nx + 0.34 * ny + 0.91 * nz)
    gloss = 16.0 * half**24
    red = u * colors[i, 0] + v * colors[j, 0] + w * colors[k, 0]
    green = u * colors[i, 1] + v * colors[j, 1] + w * colors[k, 1]
    blue = u * colors[i, 2] + v * colors[j, 2] + w * colors[k, 2]
    if inside:
        gray = 0.3 * red + 0.6 * green + 0.1 * blue
        red, green, blue = (
            0.35 * red + 0.4 * gray,
            0.35 * green + 0.4 * gray,
            0.35 * blue + 0.4 * gray,
        )
        gloss = 0.0
    return red * shade + gloss, green * shade + gloss, blue * shade + gloss
