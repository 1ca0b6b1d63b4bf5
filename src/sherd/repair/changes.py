"""The repairs, each as a function from arrays to a Change; positions are never moved.

Vertices are taken over, joined, doubled or left out, so a change is new faces and, for each new
vertex, the old one that it stands for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.mesh import geometry, gluing

__all__ = [
    "STEPS",
    "WELD_TOLERANCE",
    "Change",
    "degenerate_faces",
    "drop_degenerate_faces",
    "drop_duplicate_faces",
    "drop_unreferenced_vertices",
    "duplicate_faces",
    "orient_faces",
    "split_nonmanifold_edges",
    "split_nonmanifold_vertices",
    "weld_seams",
]


# In units of sqrt(area). Single precision, in which STL and most PLY files are written, keeps
# 6e-8 of a coordinate; ten times that joins what was rounded apart, and the shortest edges of a
# mesh with a million vertices are still a thousand times longer.
WELD_TOLERANCE = 1e-6
# A triangle whose height is a few roundings of its own coordinates has no direction left.
_HEIGHT_ROUNDINGS = 8 * float(np.finfo(np.float64).eps)


@dataclass(frozen=True, eq=False)
class Change:
    """What one repair makes of a mesh with n vertices and m faces.

    Parameters
    ----------
    faces
        (m', 3) of the new mesh.
    origin
        (n',) old index of each new vertex.
    renumber
        (n,) new index of each old vertex, -1 if it is gone.
    count
        How many elements were concerned.
    concerned
        (m,) bool, old faces that were touched.
    sentence
        What was done, for the user; {face}, {edge} or {vertex} stands for the counted noun.
    """

    faces: Ints
    origin: Ints
    renumber: Ints
    count: int
    concerned: Bools
    sentence: str


def degenerate_faces(vertices: Floats, faces: Ints) -> Bools:
    """Faces (m,) that repeat a corner or whose height is lost in the rounding of coordinates."""
    first, second, third = faces.T
    repeated = (first == second) | (second == third) | (third == first)
    a, b, c = vertices[first], vertices[second], vertices[third]
    sides = (c - b, a - c, b - a)
    longest = np.maximum.reduce([geometry.lengths(side) for side in sides])
    extent = np.abs(vertices).max(axis=1)
    size = np.maximum.reduce([extent[corner] for corner in (first, second, third)])
    height = np.divide(
        geometry.lengths(geometry.cross(sides[2], c - a)),
        longest,
        out=np.zeros(len(faces)),
        where=longest > 0,
    )
    flat: Bools = repeated | (height <= _HEIGHT_ROUNDINGS * size)
    return flat


def duplicate_faces(vertices: Floats, faces: Ints) -> Bools:
    """Faces (m,) whose three corners lie where those of an earlier face do."""
    corners = np.sort(gluing.coincident_classes(vertices, 0.0)[faces], axis=1)
    order = np.lexsort((np.arange(len(faces)), corners[:, 2], corners[:, 1], corners[:, 0]))
    repeated = np.zeros(len(faces), dtype=bool)
    repeated[order[1:]] = (corners[order[1:]] == corners[order[:-1]]).all(axis=1)
    return repeated


def drop_degenerate_faces(vertices: Floats, faces: Ints) -> Change:
    """Leave out faces without area."""
    bad = degenerate_faces(vertices, faces)
    return _without(vertices, faces, bad, "left out {face} without area")


def drop_duplicate_faces(vertices: Floats, faces: Ints) -> Change:
    """Leave out faces that lie exactly on an earlier face, whichever way they are turned."""
    bad = duplicate_faces(vertices, faces)
    return _without(vertices, faces, bad, "left out {face} on top of another")


def weld_seams(vertices: Floats, faces: Ints) -> Change:
    """Join boundary edges that lie on each other within WELD_TOLERANCE * sqrt(area).

    Only whole edges are joined, so two sheets that touch in a point stay apart, and none is
    joined where an edge would get more than two faces.
    """
    origin = renumber = np.arange(len(vertices))
    concerned = np.zeros(len(faces), dtype=bool)
    rows = np.arange(len(faces))
    welded = faces
    while True:  # a joined edge may bring others together; each round leaves fewer vertices
        joined, touched = _joined_once(vertices[origin], welded)
        names, first, onto = np.unique(joined, return_index=True, return_inverse=True)
        if len(names) == len(origin):
            break
        order = np.argsort(first)  # new vertices in the order of the first old one of each
        rank = np.empty(len(first), dtype=np.int64)
        rank[order] = np.arange(len(first))
        onto = rank[onto.ravel()]
        concerned[rows[touched]] = True
        origin, renumber, welded = origin[first[order]], onto[renumber], onto[welded]
        # a joined corner moves by up to the tolerance, which may leave a thin face without area
        moved = np.flatnonzero((np.bincount(onto) > 1)[welded].any(axis=1))
        solid = np.ones(len(welded), dtype=bool)
        solid[moved] = ~degenerate_faces(vertices[origin], welded[moved])
        rows, welded = rows[solid], welded[solid]
    count = len(vertices) - len(origin)
    sentence = "joined {vertex} to others along coincident edges"
    return Change(welded, origin, renumber, count, concerned, sentence)


def _joined_once(vertices: Floats, faces: Ints) -> tuple[Ints, Bools]:
    """Label of each vertex (n,), equal for those to be joined, and the faces (m,) at the seams."""
    group, uses = gluing.edge_groups(faces)
    free = uses[group] == 1
    if not free.any():
        return np.arange(len(vertices)), np.zeros(len(faces), dtype=bool)
    tolerance = WELD_TOLERANCE * float(np.sqrt(geometry.face_areas(vertices, faces).sum()))
    classes = np.full(len(vertices), -1, dtype=np.int64)
    border = np.unique(np.concatenate([_starts(faces)[free], _ends(faces)[free]]))
    classes[border] = gluing.coincident_classes(vertices[border], tolerance)
    places = classes[faces]
    free &= (places != places[:, [1, 2, 0]]).ravel()
    # -1, the class of vertices off the border, takes part in no free edge
    pairs = _seam_pairs(vertices, faces, places, free)
    same = gluing.same_direction(places, pairs)
    starts, ends = _starts(faces)[pairs], _ends(faces)[pairs]
    joined = gluing.components(
        np.concatenate([starts[:, 0], ends[:, 0]]),
        np.concatenate(
            [np.where(same, starts[:, 1], ends[:, 1]), np.where(same, ends[:, 1], starts[:, 1])]
        ),
        len(vertices),
    )
    touched = np.zeros(len(faces), dtype=bool)
    touched[pairs.ravel() // 3] = True
    return joined, touched


def _seam_pairs(vertices: Floats, faces: Ints, places: Ints, free: Bools) -> Ints:
    """Pairs of `free` half-edges (3m,) that coincide and can be joined without crowding an edge."""
    seams = gluing.face_pairs(vertices, faces, places=places, among=free)
    if not len(seams):
        return seams
    joined = gluing.face_pairs(vertices, faces)
    both = np.vstack([joined, seams])
    removable = np.arange(len(both)) >= len(joined)
    # corners of joined faces may have the class -1, so places are told apart below zero, too
    names = np.where(places < 0, -1 - faces, places)
    kept = gluing.settled(names, both, removable)
    return kept[free[kept].all(axis=1)]


def split_nonmanifold_edges(vertices: Floats, faces: Ints) -> Change:
    """Separate sheets at edges with more than two faces; the smoothest continuations stay."""
    group, uses = gluing.edge_groups(faces)
    sentence = "separated the sheets at {edge} with more than two faces"
    bad = uses[group] > 2
    if not bad.any():
        return _unchanged(vertices, faces, sentence)
    crowded = np.zeros(len(vertices), dtype=bool)
    crowded[_starts(faces)[bad]] = True
    crowded[_ends(faces)[bad]] = True
    pairs = gluing.face_pairs(vertices, faces)
    pairs = gluing.settled(faces, pairs, np.ones(len(pairs), dtype=bool))
    change = _split(vertices, faces, pairs, crowded, sentence)
    return replace(change, count=int((uses > 2).sum()))


def split_nonmanifold_vertices(vertices: Floats, faces: Ints) -> Change:
    """Double vertices at which sheets touch in a point only."""
    group, uses = gluing.edge_groups(faces)
    pinched = np.ones(len(vertices), dtype=bool)
    bad = uses[group] > 2
    pinched[_starts(faces)[bad]] = False
    pinched[_ends(faces)[bad]] = False
    pairs = gluing.face_pairs(vertices, faces)
    sentence = "doubled {vertex} in which sheets touch"
    return _split(vertices, faces, pairs, pinched, sentence)


def orient_faces(vertices: Floats, faces: Ints) -> Change:
    """Turn faces so that neighbors agree, and closed sheets outward."""
    pairs = gluing.face_pairs(vertices, faces)
    flips, _, _ = gluing.orientation_flips(vertices, faces, pairs)
    turned = faces.copy()
    turned[flips] = faces[flips][:, [0, 2, 1]]
    everything = np.arange(len(vertices))
    sentence = "turned {face} to agree with the neighbors or outward"
    return Change(turned, everything, everything, int(flips.sum()), flips, sentence)


def drop_unreferenced_vertices(vertices: Floats, faces: Ints) -> Change:
    """Leave out vertices that belong to no face."""
    origin = _used(vertices, faces)
    renumber = np.full(len(vertices), -1, dtype=np.int64)
    renumber[origin] = np.arange(len(origin))
    none = np.zeros(len(faces), dtype=bool)
    count = len(vertices) - len(origin)
    sentence = "left out {vertex} on no face"
    return Change(renumber[faces], origin, renumber, count, none, sentence)


STEPS: dict[str, Callable[[Floats, Ints], Change]] = {
    "drop degenerate faces": drop_degenerate_faces,
    "drop duplicate faces": drop_duplicate_faces,
    "weld seams": weld_seams,
    "split non-manifold edges": split_nonmanifold_edges,
    "split non-manifold vertices": split_nonmanifold_vertices,
    "orient faces": orient_faces,
    "drop unreferenced vertices": drop_unreferenced_vertices,
}


def _starts(faces: Ints) -> Ints:
    return faces.ravel()


def _ends(faces: Ints) -> Ints:
    ends: Ints = faces[:, [1, 2, 0]].ravel()
    return ends


def _used(vertices: Floats, faces: Ints) -> Ints:
    """The vertices that belong to a face, ascending; faster than sorting corners."""
    used = np.zeros(len(vertices), dtype=bool)
    used[faces] = True
    return np.flatnonzero(used)


def _unchanged(vertices: Floats, faces: Ints, sentence: str) -> Change:
    return _without(vertices, faces, np.zeros(len(faces), dtype=bool), sentence)


def _without(vertices: Floats, faces: Ints, bad: Bools, sentence: str) -> Change:
    everything = np.arange(len(vertices))
    kept = faces[~bad] if bad.any() else faces
    return Change(kept, everything, everything, int(bad.sum()), bad, sentence)


def _split(vertices: Floats, faces: Ints, pairs: Ints, allowed: Bools, sentence: str) -> Change:
    """Give every fan but the largest at each `allowed` vertex (n,) a vertex of its own."""
    fan = gluing.fans(faces, pairs)
    if fan.max(initial=-1) + 1 == len(_used(vertices, faces)):  # one at each vertex
        return _unchanged(vertices, faces, sentence)
    _, first, sizes = np.unique(fan, return_index=True, return_counts=True)
    place = faces.ravel()[first]
    # at each vertex the fan with most corners keeps the number; of equals, the first
    order = np.lexsort((first, -sizes, place))
    keeper = np.ones(len(order), dtype=bool)
    keeper[order[1:]] = place[order[1:]] != place[order[:-1]]
    extra = np.flatnonzero(~keeper & allowed[place])
    number = place.copy()
    number[extra] = len(vertices) + np.arange(len(extra))
    split = number[fan].reshape(-1, 3)
    everything = np.arange(len(vertices))
    origin = np.concatenate([everything, place[extra]])
    concerned = (split != faces).any(axis=1)
    return Change(split, origin, everything, len(extra), concerned, sentence)
