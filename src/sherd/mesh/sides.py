"""Which side of a surface is outside: refusing faces that disagree, turning all of them over."""

from __future__ import annotations

import numpy as np

from sherd.errors import InvalidMeshError
from sherd.mesh import gluing
from sherd.mesh.geometry import face_cross
from sherd.mesh.topology import half_edges
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["bulge", "check_sides", "turned_over"]

# Normals are averaged over dozens of faces, so some that point the other way do no harm.
MOST_DISAGREEING = 0.05


def check_sides(mesh: TriangleMesh) -> None:
    """Refuse a mesh whose faces do not agree with their neighbors on what is outside.

    Raises
    ------
    InvalidMeshError
        If at more than 5 % of the inner edges the two faces are turned against each other.
    """
    pairs = gluing.face_pairs(mesh.vertices, mesh.faces)
    wrong = int(gluing.same_direction(mesh.faces, pairs).sum())
    if wrong > MOST_DISAGREEING * len(pairs):
        raise InvalidMeshError(
            f"{mesh.name}: at {100 * wrong / len(pairs):.0f} % of the edges the two faces do not "
            "agree on which side is outside; make them agree first: sherd.repair(mesh)"
        )


def bulge(mesh: TriangleMesh) -> float:
    """How much the surface bulges toward the side its faces look to; negative if they look inward.

    The isoperimetric quotient `36 pi V^2 / A^3` with the sign of V, the volume that the surface
    encloses once each piece of its border is joined to that piece's center: 1 for a ball, 0 for a
    flat patch. About 0.1 for half an animal. Most bodies are seen from outside, so a clearly
    negative value suggests that the mesh is inside out; a bowl seen from inside has it too.
    """
    halves = half_edges(mesh.faces)
    key, twin = halves @ [mesh.vertex_count, 1], halves @ [1, mesh.vertex_count]
    border = halves[~np.isin(key, twin)]
    piece = gluing.components(border[:, 0], border[:, 1], mesh.vertex_count)[border[:, 0]]
    places = mesh.vertices - mesh.vertices.mean(axis=0)
    count = np.bincount(piece)
    total = [np.bincount(piece, places[border[:, 0], axis]) for axis in range(3)]
    centers = np.stack(total, axis=1)[piece] / count[piece][:, None]
    # the caps run along the border the other way than the faces
    closed = np.concatenate([places, centers])
    tips = mesh.vertex_count + np.arange(len(border))
    faces = np.concatenate([mesh.faces, np.column_stack([border[:, ::-1], tips])])
    cross = face_cross(closed, faces)
    volume = float(np.einsum("ij,ij->", closed[faces[:, 0]], cross)) / 6.0
    area = 0.5 * float(np.linalg.norm(cross, axis=1).sum())
    return float(np.sign(volume) * 36.0 * np.pi * volume**2 / area**3)


def turned_over(mesh: TriangleMesh) -> TriangleMesh:
    """The same surface with all faces turned over: inside becomes outside."""
    return TriangleMesh(mesh.vertices, mesh.faces[:, ::-1], fields=mesh.fields, name=mesh.name)
