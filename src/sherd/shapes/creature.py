"""A procedural animal: one smooth surface, posed by its skeleton, at any resolution."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.errors import OptionError, SherdError
from sherd.mesh import topology
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes.round_cones import RoundCones, softmin_weights
from sherd.shapes.skeleton import (
    BONES,
    FLESH,
    LANDMARKS,
    POSES,
    SEGMENTS,
    bone_frames,
    rest_joints,
)
from sherd.shapes.surface_nets import surface_nets
from sherd.spectral.evening import evened, flipped_to_delaunay
from sherd.spectral.subdivision import split_edges

__all__ = ["creature", "landmarks"]


SMALLEST, LARGEST = 5_000, 1_000_000
# Two cones of one limb swell by log 2 of this at their joint: 5 % of the thinnest leg's radius.
# Trunk and head are made of cones side by side, whose seams need more.
LIMB_MELT, BODY_MELT = 0.003, 0.016
# Limbs meet the trunk, and ears the head, in a seam rounded over a few of these.
SEAM_MELT = 0.020
# Width of the handover from bone to bone at a joint: about as wide as the limbs are thick: a
# limb of radius r that bends by an angle over the length s strains its skin by r * angle / s.
SKIN_WIDTH = 0.060
# The grid resolves the thinnest part (ear tip, diameter 0.044) from about 5,000 vertices on. More
# than this many start from a mesh of a quarter or less, which costs less than a finer grid and
# still has two vertices to each radius, so that new vertices fall on the right side of a limb.
LARGEST_GRID = 40_000
# Vertices times squared spacing, which hardly depends on the spacing; only a first guess.
FIRST_GUESS = 2.79
COUNT_TOLERANCE = 0.01
MAX_ATTEMPTS = 32
# Irrational steps of the grid along the axes, so that no two attempts are alike.
SHIFTS = np.sqrt([2.0, 3.0, 5.0])
# Individuals differ by up to this share in the length and girth of head, neck, trunk, legs, tail.
VARIATION = 0.15
EVENING_ROUNDS = 6


def creature(
    vertex_count: int = 10_000, *, pose: str = "stand", individual: int = 0
) -> TriangleMesh:
    """A four-legged animal with head, ears and tail: closed, manifold, genus 0, outward oriented.

    The skin is one smooth surface and each pose one smooth deformation of space, so meshes of
    any size sample the same animal. All poses of one size and individual share vertices and
    faces by number: vertex i of one pose is vertex i of every other.

    Parameters
    ----------
    vertex_count
        Wanted number of vertices, 5,000 to 1,000,000; met within 2 %, the same for all poses.
    pose
        One of "stand", "walk", "gallop", "graze", "sit", "turn".
    individual
        Seed of the proportions, from 0 on; 0 is the animal of the documentation. Individuals
        have meshes of their own: their numbering is unrelated.

    Returns
    -------
    TriangleMesh
        With the field `segment`, the part of the body as a number: an index into
        :data:`sherd.shapes.skeleton.SEGMENTS`.

    Raises
    ------
    OptionError
        If an option is out of range.

    Notes
    -----
    Poses are near-isometric: 95 % of the edges of individual 0 keep their length within 10 %,
    93 % of others'. The same options give the same bits on the same machine. 10,000 vertices
    take about 2 s, 1,000,000 about 40 s and 1.3 GB; another pose of the same size costs only
    the skinning.
    """
    _check(vertex_count, pose, individual)
    vertices, faces, segment = _standing(vertex_count, individual)
    if pose != "stand":
        vertices = _posed(vertices, pose, individual)
    return TriangleMesh(vertices, faces, fields={"segment": segment}, name=f"creature-{pose}")


def landmarks(mesh: TriangleMesh, *, individual: int = 0) -> dict[str, int]:
    """Vertices of a standing creature by name: nose, tail_tip, left_front_hoof and so on.

    The numbers hold for every pose of the same size and individual.
    """
    bone = _bone_weights(mesh.vertices, individual).argmax(axis=1)
    names = [item.name for item in BONES]
    found = {}
    for name, (carrier, direction) in LANDMARKS.items():
        there = np.flatnonzero(bone == names.index(carrier))
        height = mesh.vertices[there] @ np.array(direction)
        found[name] = int(there[height.argmax()])
    return found


def _check(vertex_count: int, pose: str, individual: int) -> None:
    if not SMALLEST <= vertex_count <= LARGEST:
        raise OptionError(f"vertex_count is {vertex_count}, but {SMALLEST}..{LARGEST} is needed")
    if pose not in POSES:
        raise OptionError(f"pose is {pose!r}, but one of {', '.join(POSES)} is needed")
    if individual < 0:
        raise OptionError(f"individual is {individual}, but a seed from 0 on is needed")


@lru_cache(maxsize=4)
def _standing(vertex_count: int, individual: int) -> tuple[Floats, Ints, Floats]:
    body, _ = _body(individual)
    levels = 0
    # a closed surface of genus 0 with V vertices has 3 V - 6 edges, which become vertices
    base_count = float(vertex_count)
    while base_count > LARGEST_GRID:
        base_count = (base_count + 6) / 4
        levels += 1
    vertices, faces = _extracted(body, int(base_count))
    for _ in range(levels):
        faces, parents = split_edges(faces, len(vertices))
        vertices = np.concatenate([vertices, vertices[parents].mean(axis=1)])
        vertices = body.projected(evened(vertices, faces, steps=1), steps=2)
        faces = flipped_to_delaunay(vertices, faces)
    bone = _bone_weights(vertices, individual).argmax(axis=1)
    segment_of_bone = np.array([SEGMENTS.index(item.segment) for item in BONES], dtype=float)
    segment = segment_of_bone[bone]
    for array in (vertices, faces, segment):
        array.flags.writeable = False
    return vertices, faces, segment


def _extracted(body: RoundCones, count: int) -> tuple[Floats, Ints]:
    """A mesh of the body with `count` vertices within 1 %, its triangles evened out."""
    lower, upper = body.bounds()
    spacing = float(np.sqrt(FIRST_GUESS / count))
    for attempt in range(MAX_ATTEMPTS):
        # another place of the grid each time: a cell that two sheets share is a matter of chance
        shift = spacing * (2 + np.modf(attempt * SHIFTS)[0])
        vertices, faces = surface_nets(
            lambda points: body.value_and_gradient(points)[0],
            lower - shift,
            upper + 2 * spacing,
            spacing=spacing,
        )
        vertices, faces = _without_spikes(vertices, faces)
        if abs(len(vertices) - count) > COUNT_TOLERANCE * count:
            spacing *= float(np.sqrt(len(vertices) / count))
        elif _is_sphere(faces, len(vertices)):
            break
    else:
        raise SherdError(f"no clean surface of the animal with {count} vertices; ask for more")
    # averaging once in all directions takes out the tangles of cells that two sheets share
    neighbors = topology.adjacency(faces, len(vertices))
    vertices = body.projected(neighbors @ vertices / neighbors.sum(axis=1)[:, None])
    for _ in range(EVENING_ROUNDS):
        faces = flipped_to_delaunay(vertices, faces)
        vertices = body.projected(evened(vertices, faces, steps=2), steps=2)
    return vertices, flipped_to_delaunay(vertices, faces)


def _is_sphere(faces: Ints, count: int) -> bool:
    """Closed, without a non-manifold edge, in one piece and of genus 0."""
    edges, uses = topology.unique_edges(faces)
    one_piece = not topology.component_labels(faces, count).any()
    return bool((uses == 2).all()) and one_piece and count - len(edges) + len(faces) == 2


def _without_spikes(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """Without vertices of three faces: such a tip becomes the one face below it."""
    while True:
        valence = np.bincount(faces.ravel(), minlength=len(vertices))
        # one tip at a time per neighborhood: neighbors of a taken tip wait for the next round
        edges, _ = topology.unique_edges(faces)
        tip = valence == 3
        tip[edges[tip[edges].all(axis=1), 1]] = False
        if not tip.any():
            return vertices, faces
        at_tip = tip[faces]
        rows = np.flatnonzero(at_tip.any(axis=1))
        column = at_tip[rows].argmax(axis=1)[:, None]
        ring = np.take_along_axis(faces[rows], (column + np.array([0, 1, 2])) % 3, axis=1)
        ring = ring[np.argsort(ring[:, 0], kind="stable")].reshape(-1, 3, 3)
        # the faces at the tip are (tip, a, b), (tip, b, c), (tip, c, a) in some order
        second = np.where((ring[:, 1, 1] == ring[:, 0, 2]), ring[:, 1, 2], ring[:, 2, 2])
        below = np.stack([ring[:, 0, 1], ring[:, 0, 2], second], axis=1)
        faces = np.concatenate([np.delete(faces, rows, axis=0), below])
        kept, faces = topology.renumbered(faces)
        vertices = vertices[kept]


@lru_cache(maxsize=8)
def _body(individual: int) -> tuple[RoundCones, Ints]:
    """The round cones of the standing animal, and the bone that carries each."""
    length, girth = _proportions(individual)
    joints, vectors = rest_joints(length)
    names = [bone.name for bone in BONES]
    carriers = [names.index(item[0]) for item in FLESH]
    scale = length[carriers][:, None]
    begin, end = (np.array([item[place] for item in FLESH]) * scale for place in (1, 2))
    radii = np.array([bone.radii for bone in BONES] + [item[3] for item in FLESH])
    bone = np.concatenate([np.arange(len(BONES)), carriers]).astype(np.int64)
    melting = [bone.segment if "ear" not in bone.name else bone.name for bone in BONES]
    groups = list(dict.fromkeys(melting))
    cones = RoundCones(
        np.concatenate([joints, joints[carriers] + begin]),
        np.concatenate([vectors, end - begin]),
        radii * girth[bone][:, None],
        np.array([groups.index(melting[row]) for row in bone]),
        np.array([BODY_MELT if name in ("trunk", "head") else LIMB_MELT for name in groups]),
        SEAM_MELT,
    )
    return cones, bone


def _proportions(individual: int) -> tuple[Floats, Floats]:
    """Length and girth of each bone relative to the table; left and right legs alike."""
    kinds = [bone.segment.removeprefix("left_").removeprefix("right_") for bone in BONES]
    groups = list(dict.fromkeys(kinds))
    factors = np.ones((len(groups), 2))
    if individual > 0:
        rng = np.random.default_rng(individual)
        factors = rng.uniform(1 - VARIATION, 1 + VARIATION, size=factors.shape)
    rows = factors[[groups.index(kind) for kind in kinds]]
    return rows[:, 0], rows[:, 1]


def _bone_weights(points: Floats, individual: int) -> Floats:
    """How much each bone moves each point, (p, b), rows sum to 1; smooth in space."""
    cones, bone = _body(individual)
    weights = np.zeros((len(points), len(BONES)))
    for begin in range(0, len(points), 8192):
        block = slice(begin, begin + 8192)
        shares, _ = softmin_weights(cones.distances(points[block])[0], SKIN_WIDTH)
        for cone, carrier in enumerate(bone):
            weights[block, carrier] += shares[:, cone]
    return weights


def _posed(vertices: Floats, pose: str, individual: int) -> Floats:
    """Linear blend skinning: each vertex follows the bones by its weights."""
    rotations, shifts = bone_frames(_body(individual)[0].starts[: len(BONES)], pose)
    posed = np.empty_like(vertices)
    for begin in range(0, len(vertices), 65536):
        block = slice(begin, begin + 65536)
        weights = _bone_weights(vertices[block], individual)
        matrix = np.einsum("pb,bij->pij", weights, rotations)
        shift = np.einsum("pb,bi->pi", weights, shifts)
        posed[block] = np.einsum("pij,pj->pi", matrix, vertices[block]) + shift
    return posed
