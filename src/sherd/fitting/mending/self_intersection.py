"""Faces of a mesh that pierce other faces of it.

No library that may be used does this: CGAL and what wraps it is GPL, MeshLib is not free, Open3D
tests all pairs (and found false ones, its issue 5117), manifold3d takes only closed manifolds,
FCL and embree test one body against another. The test is five signs, so it is our own.
"""

from __future__ import annotations

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.threads import over_rows

__all__ = ["intersecting_faces", "intersecting_pairs", "marked_faces"]

# Width of a strip in mean heights of faces: narrower ones hold more faces twice.
STRIP = 4.0


def intersecting_pairs(vertices: Floats, faces: Ints) -> Ints:
    """Pairs (k, 2) of faces that pierce each other, the lower number first, in ascending order.

    Neighbors count where the edge opposite to a shared corner goes through the other face; faces
    with a common edge, and faces that only touch or lie in one plane, do not.

    Parameters
    ----------
    vertices, faces
        (n, 3) l and (m, 3).

    Notes
    -----
    Boxes are swept along the longest axis in strips of another one: near linear for even meshes,
    5 ms for 20,000 faces.
    """
    from sherd.fitting.mending.self_intersection_kernel import (  # noqa: PLC0415 - numba
        count_pierced,
        write_pierced,
    )

    if not len(faces):
        return np.empty((0, 2), dtype=np.int64)
    axis = int(np.argmax(np.ptp(vertices, axis=0)))
    turned = np.ascontiguousarray(np.roll(vertices, -axis, axis=1))
    corners = turned[faces]
    low, high = corners.min(axis=1), corners.max(axis=1)
    entries, strips = _in_strips(low[:, :2], high[:, 1])
    # in the order of the sweep, so that memory is read from front to back
    boxes = (np.ascontiguousarray(corner[entries].T) for corner in (low, high))
    swept = (turned, np.ascontiguousarray(faces[entries]), *boxes, strips)
    counts = np.zeros(len(entries), dtype=np.int64)
    over_rows(count_pierced, len(entries), *swept, counts)
    ends = np.cumsum(counts)
    pairs = np.empty((int(ends[-1]), 2), dtype=np.int64)
    over_rows(write_pierced, len(entries), *swept, ends, pairs)
    pairs = np.sort(entries[pairs], axis=1)
    sorted_pairs: Ints = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    return sorted_pairs


def _in_strips(low: Floats, top: Floats) -> tuple[Ints, Ints]:
    """Faces (e,), once for each strip that they reach into, by strip and first coordinate.

    `low` (m, 2) are the least coordinates of the faces, `top` (m,) the largest second ones. Also
    (2, e), that strip and the first one of the face.
    """
    bottom = low[:, 1]
    # so there are a quarter more entries than faces, however long some faces are
    height = max(STRIP * float((top - bottom).mean()), float(np.ptp(bottom)) / len(low), 1e-300)
    first = ((bottom - bottom.min()) / height).astype(np.int64)
    last = ((top - bottom.min()) / height).astype(np.int64)
    reach = last - first + 1
    faces = np.repeat(np.arange(len(low)), reach)
    strip = np.arange(len(faces)) - np.repeat(np.cumsum(reach) - reach, reach) + first[faces]
    order = np.lexsort((low[faces, 0], strip))
    entries: Ints = faces[order]
    return entries, np.stack([strip[order], first[entries]])


def intersecting_faces(vertices: Floats, faces: Ints) -> Bools:
    """Whether each face (m,) pierces another or is pierced; see :func:`intersecting_pairs`."""
    return marked_faces(intersecting_pairs(vertices, faces), len(faces))


def marked_faces(pairs: Ints, count: int) -> Bools:
    """Whether each of so many faces (count,) is in one of the pairs (k, 2)."""
    marked = np.zeros(count, dtype=bool)
    marked[pairs.ravel()] = True
    return marked
