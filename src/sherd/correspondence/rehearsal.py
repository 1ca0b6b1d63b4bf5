"""A placement with little to do, which calls the compiled loops of the later stages of a match."""

from __future__ import annotations

import numpy as np

from sherd.correspondence.labels.labeling import SAME_SCALE, Labeling
from sherd.correspondence.question import Question
from sherd.correspondence.working_placement import Queries, rough_placement_from_labeling
from sherd.descriptors.principal_spectra import AXIS_COUNT, PrincipalAxes
from sherd.descriptors.rotation_kernel import FREQUENCIES
from sherd.descriptors.shot_kernel import BINS
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.subdivision import split_edges
from sherd.surface.described import NO_CUT, RADII, DescribedSurface, Known
from sherd.surface.samples import Samples
from sherd.surface.working import WorkingSurface

__all__ = ["rehearsed_placement"]

OCTAHEDRON = (
    (0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5),
)  # fmt: skip
# 258 vertices, each tenth of them a sample: enough for every loop to have neighbors.
LEVELS, STEP = 3, 10


def rehearsed_placement() -> TriangleMesh:
    """Lay a ball on itself; returns the ball.

    What earlier stages would compute is made up, so that none of their loops is compiled.
    """
    ball = _ball()
    count = ball.vertex_count
    vertices = np.arange(0, count, STEP)
    gaps = np.linalg.norm(ball.vertices[vertices][:, None] - ball.vertices[None], axis=2)
    samples = Samples.of(
        vertices,
        gaps.astype(np.float32),
        np.zeros((len(vertices), len(vertices)), dtype=np.float32),
    )
    spectra = np.zeros((FREQUENCIES, count, 2 * AXIS_COUNT), dtype=np.float32)
    axes = np.zeros((FREQUENCIES, len(RADII) * BINS, AXIS_COUNT), dtype=np.float32)
    surface = DescribedSurface(
        WorkingSurface(ball, ball, None),
        known=Known(
            normals=np.array(ball.vertex_normals),
            cut_distance=np.full(count, NO_CUT),
            dense=samples,
            sparse=samples,
            axes=PrincipalAxes(axes),
            spectra=spectra,
        ),
    )
    nothing = np.zeros(len(vertices))
    rough_placement_from_labeling(
        Question(surface, surface, SAME_SCALE),
        Labeling(np.arange(len(vertices)), nothing, nothing, 0.0),
        Queries(np.arange(count), spectra, spectra),
    )
    return ball


def _ball() -> TriangleMesh:
    vertices = np.concatenate([np.eye(3), -np.eye(3)])
    faces = np.array(OCTAHEDRON, dtype=np.int64)
    for _ in range(LEVELS):
        faces, parents = split_edges(faces, len(vertices))
        middle = vertices[parents].sum(axis=1)
        middle /= np.linalg.norm(middle, axis=1, keepdims=True)
        vertices = np.concatenate([vertices, middle])
    ball = TriangleMesh(vertices, faces, name="ball")
    return ball.with_vertices(ball.vertices / ball.length)
