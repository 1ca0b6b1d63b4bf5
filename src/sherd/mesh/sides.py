"""Which side of a surface is outside: refusing faces that disagree, turning all of them over."""

from __future__ import annotations

from sherd.errors import InvalidMeshError
from sherd.mesh import gluing
from sherd.mesh.repair import RepairReport
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["check_sides", "side_is_unclear", "turned_over"]

# Normals are averaged over dozens of faces, so some that point the other way do no harm.
MOST_DISAGREEING = 0.05
# Repair turns the smaller side over, so at most half of the area.
UNCLEAR = 0.4


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


def side_is_unclear(repaired: TriangleMesh, report: RepairReport) -> bool:
    """Whether so many faces of an open mesh were turned over that the majority says little.

    A closed mesh tells by its volume.
    """
    turned = sum(step.area_fraction for step in report.steps if step.name == "orient faces")
    return turned > UNCLEAR and len(repaired.boundary_vertices) > 0


def turned_over(mesh: TriangleMesh) -> TriangleMesh:
    """The same surface with all faces turned over: inside becomes outside."""
    return TriangleMesh(mesh.vertices, mesh.faces[:, ::-1], fields=mesh.fields, name=mesh.name)
