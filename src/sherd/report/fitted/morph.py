"""A binary glTF (.glb) with a morph target: from the full shape as it was given to the fit."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Floats
from sherd.drawing.exhibit import Layer
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.glb import Buffer, glb_bytes, painted_mesh

__all__ = ["morph_glb"]

# What PLY files call texture coordinates of vertices: Blender, MeshLab, others.
TEXTURE_FIELDS = (("s", "t"), ("texture_u", "texture_v"), ("u", "v"))


def morph_glb(full: TriangleMesh, positions: Floats, painted: Layer | None) -> bytes:
    """Scene with one node, "fit", which is the full shape at weight 0 and the fit at weight 1.

    The full shape is shifted so that both have the same center; otherwise, and as files always
    are, coordinates are those of the fit. Vertices keep their numbers, and texture coordinates that
    are fields of the full shape come along.

    Parameters
    ----------
    full
        The full shape; n vertices.
    positions
        (n, 3) of the fit.
    painted
        The layer whose colors are painted; neutral if None.

    Raises
    ------
    OptionError
        If coordinates are too large for single precision.

    References
    ----------
    Khronos, *glTF 2.0 specification*: 3.7.2.2 (morph targets are displacements), 3.8.3 (texture
    coordinates begin at the upper left; those of PLY files begin at the lower left).
    """
    shift = positions.mean(axis=0) - full.vertices.mean(axis=0)
    start = full.with_vertices(full.vertices + shift)
    goal = full.with_vertices(positions)
    buffer = Buffer()
    mesh = painted_mesh(buffer, "fit", start, (), painted)
    texture = _texture_coordinates(full)
    if texture is not None:
        mesh["primitives"][0]["attributes"]["TEXCOORD_0"] = buffer.add(texture)
    steps = buffer.add_boxed((positions - start.vertices).astype(np.float32))
    turns = buffer.add(goal.vertex_normals - start.vertex_normals)
    mesh["primitives"][0]["targets"] = [{"POSITION": steps, "NORMAL": turns}]
    mesh["weights"] = [1.0]
    mesh["extras"] = {"targetNames": ["fit"]}
    return glb_bytes(buffer, [mesh], [{"name": "fit", "mesh": 0}])


def _texture_coordinates(full: TriangleMesh) -> Floats | None:
    """(n, 2) as glTF counts them; None if the shape has none, or not for all vertices."""
    for across, up in TEXTURE_FIELDS:
        if across in full.fields and up in full.fields:
            found = np.column_stack([full.fields[across], 1.0 - full.fields[up]])
            return found if np.isfinite(found).all() else None
    return None
