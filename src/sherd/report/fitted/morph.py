"""A binary glTF (.glb) with a morph target: from the full shape as it was given to the fit."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Floats
from sherd.drawing.exhibit import Layer
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.glb import Buffer, glb_bytes, painted_mesh

__all__ = ["morph_glb"]


def morph_glb(full: TriangleMesh, positions: Floats, painted: Layer | None) -> bytes:
    """Scene with one node, "fit", which is the full shape at weight 0 and the fit at weight 1.

    The full shape is shifted so that both have the same center; otherwise, and as files always
    are, coordinates are those of the fit. Vertices keep their numbers.

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
    Khronos, *glTF 2.0 specification*: 3.7.2.2 (morph targets are displacements).
    """
    shift = positions.mean(axis=0) - full.vertices.mean(axis=0)
    start = full.with_vertices(full.vertices + shift)
    goal = full.with_vertices(positions)
    buffer = Buffer()
    mesh = painted_mesh(buffer, "fit", start, (), painted)
    steps = buffer.add_boxed((positions - start.vertices).astype(np.float32))
    turns = buffer.add(goal.vertex_normals - start.vertex_normals)
    mesh["primitives"][0]["targets"] = [{"POSITION": steps, "NORMAL": turns}]
    mesh["weights"] = [1.0]
    mesh["extras"] = {"targetNames": ["fit"]}
    return glb_bytes(buffer, [mesh], [{"name": "fit", "mesh": 0}])
