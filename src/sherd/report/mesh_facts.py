"""Facts that every result file states about its meshes."""

from __future__ import annotations

from typing import Any

from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["mesh_facts"]


def mesh_facts(mesh: TriangleMesh, notices: tuple[str, ...] = ()) -> dict[str, Any]:
    """Name, size and area of a mesh, and what was adapted while reading it."""
    return {
        "name": mesh.name,
        "vertices": mesh.vertex_count,
        "faces": mesh.face_count,
        "area": mesh.area,
        "notices": list(notices),
    }
