"""What one camera sees of a shape: its front, with ragged borders along every limb."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sherd.arrays import Floats
from sherd.shapes.fragment import Fragment, largest_piece

__all__ = ["seen_by_camera"]

# Cosine below which a scanner does not see a face, and how much deeper than the front, in edges,
# a face may lie to be seen.
GRAZING, DEPTH = 0.15, 3.0


def seen_by_camera(body: Fragment, rotation: Floats) -> Fragment:
    """The largest piece of what a far camera sees, by a depth buffer.

    `rotation` (3, 3) holds, in its columns, the right and the upward direction of the picture and
    the direction toward the camera.
    """
    mesh = body.mesh
    toward = rotation[:, 2]
    grid = np.array([(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.5, 0.5, 0), (0, 0.5, 0.5), (0.5, 0, 0.5)])
    weights = np.concatenate([grid, np.full((1, 3), 1 / 3)])
    corners = mesh.vertices[mesh.faces]
    samples = np.einsum("sk,mkx->smx", weights, corners)
    cells = np.floor(samples @ rotation[:, :2] / (0.75 * mesh.mean_edge_length)).astype(np.int64)
    cells -= cells.min(axis=(0, 1))
    key = cells[..., 0] * (cells[..., 1].max() + 1) + cells[..., 1]
    depth = samples @ toward
    front = np.full(int(key.max()) + 1, -np.inf)
    np.maximum.at(front, key.ravel(), depth.ravel())
    visible = depth[-1] > front[key[-1]] - DEPTH * mesh.mean_edge_length
    visible &= mesh.face_normals @ toward > GRAZING
    piece, kept = mesh.submesh(visible)
    return largest_piece(
        replace(body, mesh=piece, truth=body.truth[kept], present=body.present[kept])
    )
