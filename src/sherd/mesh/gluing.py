"""Which faces belong together at an edge: pairs, fans, sheets and orientation, on arrays.

A half-edge is a directed side of a face, numbered 3 * face + side; corner 3 * face + side is
where it starts. `faces` is (m, 3) int64 without repeated indices.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import cKDTree

from sherd.arrays import Bools, Floats, Ints
from sherd.mesh import geometry

__all__ = [
    "coincident_classes",
    "components",
    "edge_groups",
    "end_corners",
    "face_pairs",
    "fans",
    "orientation_flips",
    "same_direction",
    "settled",
]


# More sheets at one edge come from damaged files, and the pairs to compare grow with the square.
_MOST_SHEETS = 16


def end_corners(half_edges: Ints) -> Ints:
    """Corner at which each half-edge ends; it starts at the corner of its own number."""
    ends: Ints = half_edges - half_edges % 3 + (half_edges + 1) % 3
    return ends


def edge_groups(faces: Ints) -> tuple[Ints, Ints]:
    """Edge of each half-edge (3m,), and the number of half-edges of each edge (e,)."""
    order, first = _by_edge(*_sides(faces))
    uses = np.diff(np.append(first, len(order)))
    group = np.empty(len(order), dtype=np.int64)
    group[order] = np.repeat(np.arange(len(first)), uses)
    return group, uses.astype(np.int64)


def _sides(faces: Ints) -> tuple[Ints, Ints]:
    """Where each half-edge starts and ends, (3m,) each."""
    return faces.ravel(), faces[:, [1, 2, 0]].ravel()


def _by_edge(start: Ints, end: Ints) -> tuple[Ints, Ints]:
    """Half-edges (h,) sorted by edge and number, and the place (e,) at which each edge begins."""
    lowest = min(int(start.min(initial=0)), 0)  # places of seams may be below zero
    start, end = start - lowest, end - lowest
    size, count = len(start), int(max(start.max(initial=0), end.max(initial=0))) + 1
    key = np.minimum(start, end) * count + np.maximum(start, end)
    if count * count * size < np.iinfo(np.int64).max:
        # edge and number in one whole number: sorting values is twice as fast as sorting places
        key *= max(size, 1)
        key += np.arange(size)
        key.sort()
        edge = key // max(size, 1)
        order = key - edge * size
    else:
        order = np.argsort(key, kind="stable")
        edge = key[order]
    first = np.ones(size, dtype=bool)
    np.not_equal(edge[1:], edge[:-1], out=first[1:])
    return order, np.flatnonzero(first)


def same_direction(faces: Ints, pairs: Ints) -> Bools:
    """Pairs of half-edges (p, 2) that run the same way: their faces are oriented differently."""
    flat = faces.ravel()
    same: Bools = flat[pairs[:, 0]] == flat[pairs[:, 1]]
    return same


def face_pairs(
    vertices: Floats, faces: Ints, *, places: Ints | None = None, among: Bools | None = None
) -> Ints:
    """Pairs of half-edges (p, 2) at which two faces continue each other.

    Where more than two faces meet at an edge, the two that continue each other most smoothly
    become a pair, then the next two: crossing sheets stay sheets, and a fin comes off.

    Parameters
    ----------
    vertices, faces
        (n, 3) and (m, 3).
    places
        (m, 3) what tells corners apart; the vertex indices if None.
    among
        (3m,) half-edges to look at; all if None.
    """
    places = faces if places is None else places
    start, end = _sides(places)
    half = np.arange(len(start)) if among is None else np.flatnonzero(among)
    order, first = _by_edge(start[half], end[half])
    half, uses = half[order], np.diff(np.append(first, len(order)))
    two = first[uses == 2]
    simple = np.stack([half[two], half[two + 1]], axis=1)
    crowded = (uses > 2) & (uses <= _MOST_SHEETS)
    if crowded.any():
        group = np.repeat(np.arange(len(first)), uses)
        chosen = crowded[group]
        normals = geometry.face_normals(vertices, faces)
        smooth = _smoothest(normals, places, half[chosen], group[chosen])
        simple = np.vstack([simple, smooth])
    pairs: Ints = simple
    return pairs


def _smoothest(normals: Floats, places: Ints, half: Ints, group: Ints) -> Ints:
    """Pair half-edges (sorted by group) greedily by the smoothness of the continuation."""
    candidates = _pairs_within(half, group)
    smooth = np.einsum("pc,pc->p", normals[candidates[:, 0] // 3], normals[candidates[:, 1] // 3])
    smooth = np.where(same_direction(places, candidates), -smooth, smooth)
    return _greedy(candidates, smooth)


def _pairs_within(half: Ints, group: Ints) -> Ints:
    starts = np.flatnonzero(np.concatenate([[True], group[1:] != group[:-1]]))
    sizes = np.diff(np.append(starts, len(half)))
    pieces = []
    for size in np.unique(sizes):
        rows = half[starts[sizes == size][:, None] + np.arange(size)]
        first, second = np.triu_indices(size, 1)
        pieces.append(np.stack([rows[:, first].ravel(), rows[:, second].ravel()], axis=1))
    pairs: Ints = np.vstack(pieces)
    return pairs


def _greedy(candidates: Ints, score: Floats) -> Ints:
    """Best pair first, each half-edge once."""
    chosen = []
    used: set[int] = set()
    order = np.lexsort((candidates[:, 1], candidates[:, 0], -score))
    for first, second in candidates[order].tolist():
        if first not in used and second not in used:
            used.update((first, second))
            chosen.append((first, second))
    return np.array(chosen, dtype=np.int64).reshape(-1, 2)


def fans(faces: Ints, pairs: Ints) -> Ints:
    """Fan of each corner (3m,): corners at one vertex whose faces are joined by `pairs`."""
    same = same_direction(faces, pairs)
    start, end = pairs, end_corners(pairs)
    joined_start = np.where(same, start[:, 1], end[:, 1])
    joined_end = np.where(same, end[:, 1], start[:, 1])
    rows = np.concatenate([start[:, 0], end[:, 0]])
    columns = np.concatenate([joined_start, joined_end])
    return components(rows, columns, faces.size)


def settled(faces: Ints, pairs: Ints, removable: Bools) -> Ints:
    """Pairs without those that would leave an edge with more than two faces.

    Sheets may hang together around both ends of an edge where they also meet: as corners they
    are told apart, as vertices they are not. There the `removable` (p,) pairs at the edge go,
    and if that is not enough all those of its faces beyond the second.
    """
    while True:
        fan = fans(faces, pairs).reshape(-1, 3)
        group, uses = edge_groups(fan)
        crowded = uses[group] > 2
        gone = removable & crowded[pairs].any(axis=1)
        if not gone.any():
            gone = removable & _beyond_second(group, crowded)[pairs // 3].any(axis=1)
        if not gone.any():
            return pairs
        pairs, removable = pairs[~gone], removable[~gone]


def _beyond_second(group: Ints, crowded: Bools) -> Bools:
    """Faces (m,) that are neither first nor second at a crowded edge."""
    half = np.flatnonzero(crowded)
    half = half[np.argsort(group[half], kind="stable")]
    starts = np.flatnonzero(np.concatenate([[True], np.diff(group[half]) != 0]))
    rank = np.arange(len(half)) - np.repeat(starts, np.diff(np.append(starts, len(half))))
    beyond = np.zeros(len(group) // 3, dtype=bool)
    beyond[half[rank >= 2] // 3] = True
    return beyond


def coincident_classes(vertices: Floats, tolerance: float) -> Ints:
    """Class (n,) of each vertex, equal for vertices within `tolerance` (l), numbered as found."""
    rounded = vertices + 0.0  # -0.0 becomes 0.0
    order = np.lexsort(rounded.T)
    differs = np.any(rounded[order[1:]] != rounded[order[:-1]], axis=1)
    classes = np.empty(len(vertices), dtype=np.int64)
    classes[order] = np.concatenate([[0], np.cumsum(differs)])
    if tolerance > 0 and len(vertices) > 1:
        places = rounded[order[np.concatenate([[True], differs])]]
        close = cKDTree(places).query_pairs(tolerance, output_type="ndarray").astype(np.int64)
        classes = components(close[:, 0], close[:, 1], len(places))[classes]
    return classes


def orientation_flips(vertices: Floats, faces: Ints, pairs: Ints) -> tuple[Bools, Ints, Bools]:
    """Faces to turn so that each sheet is oriented consistently, and outward where it is closed.

    In each sheet the smaller area turns. A closed sheet of negative volume turns as a whole,
    unless it lies in the box of the largest closed sheet, where it may be a cavity.

    Returns
    -------
    flips : (m,) bool
    sheets : (m,) int
        Sheet of each face.
    one_sided : (m,) bool
        Faces of sheets without two sides, such as a Moebius strip; they are left alone.
    """
    sheets, upright, one_sided = _sheets(faces, pairs)
    flips = np.zeros(len(faces), dtype=bool)
    if not upright.all():
        areas = geometry.face_areas(vertices, faces)
        balance = np.bincount(sheets, np.where(upright, areas, -areas))
        flips = (upright != (balance >= 0)[sheets]) & ~one_sided
    return flips ^ _inward(vertices, faces, pairs, (flips, sheets, one_sided)), sheets, one_sided


def _sheets(faces: Ints, pairs: Ints) -> tuple[Ints, Bools, Bools]:
    """Sheet (m,) of each face, whether it is turned as the first one is, and has no two sides."""
    count = len(faces)
    first, second = pairs[:, 0] // 3, pairs[:, 1] // 3
    turned = same_direction(faces, pairs)
    if not turned.any():  # as most files are; half the work
        sheets = components(first, second, count)
        return sheets, np.ones(count, dtype=bool), np.zeros(count, dtype=bool)
    cross = np.where(turned, count, 0)
    # every face appears as it is and turned over: a sheet without two sides joins both
    labels = components(
        np.concatenate([first, first + count]),
        np.concatenate([second + cross, second + count - cross]),
        2 * count,
    )
    sheet_key = np.minimum(labels[:count], labels[count:])
    _, sheets = np.unique(sheet_key, return_inverse=True)
    return sheets, labels[:count] == sheet_key, labels[:count] == labels[count:]


def _inward(
    vertices: Floats, faces: Ints, pairs: Ints, oriented: tuple[Bools, Ints, Bools]
) -> Bools:
    """Faces of closed sheets that enclose a negative volume once `flips` are applied."""
    flips, sheets, one_sided = oriented
    free = np.ones(faces.size, dtype=bool)
    free[pairs.ravel()] = False
    count = int(sheets.max()) + 1
    closed = np.ones(count, dtype=bool)
    closed[sheets[np.flatnonzero(free) // 3]] = False
    closed[sheets[one_sided]] = False
    corners = vertices[faces]
    # seen from the sheet itself: from afar, large volumes cancel and leave rounding errors
    _, first = np.unique(sheets, return_index=True)
    spokes = corners - corners[first, 0][sheets][:, None, :]
    volumes = np.einsum("mc,mc->m", spokes[:, 0], geometry.cross(spokes[:, 1], spokes[:, 2]))
    volume = np.bincount(sheets, np.where(flips, -volumes, volumes))
    inward = closed & (volume < 0)
    if inward.any() and count > 1:
        low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
        np.minimum.at(low, sheets, corners.min(axis=1))
        np.maximum.at(high, sheets, corners.max(axis=1))
        largest = int(np.argmax(np.where(closed, np.abs(volume), -1.0)))
        inside = ((low > low[largest]) & (high < high[largest])).all(axis=1)
        inward &= ~inside
    result: Bools = inward[sheets]
    return result


def components(rows: Ints, columns: Ints, count: int) -> Ints:
    """Component of each of `count` nodes, where `rows` and `columns` (p,) are joined."""
    graph = sparse.coo_array((np.ones(len(rows), dtype=bool), (rows, columns)), (count, count))
    _, labels = csgraph.connected_components(graph.tocsr(), directed=False)
    return labels.astype(np.int64)
