"""A blob without any symmetry, described, and a piece of it whose nodes lie on its labels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
import trimesh

from sherd.arrays import Floats, Ints
from sherd.correspondence.labels.labeling import SAME_SCALE, Problem, labeling_problem
from sherd.correspondence.question import Question
from sherd.descriptors.tangent_frames import Compass
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.geodesics import Geodesics
from sherd.surface.described import DescribedSurface, Known
from sherd.surface.samples import NEAR, Samples
from sherd.surface.working import WorkingSurface

# Of so many labels those inside the piece are its nodes.
FIRST_LABELS = 300
# Rotations that similarities are given for.
SHIFTS = 16
OTHER_REFERENCE = np.array([-0.3, 0.2, 1.0])


@dataclass(frozen=True, eq=False)
class Planted:
    """A question whose answer is known.

    Attributes
    ----------
    question
        The blob, and a piece of its own mesh.
    kept
        (n',) vertex of the blob for each vertex of the piece.
    labels, rotations
        (k,) of each node.
    """

    question: Question
    kept: Ints
    labels: Ints
    rotations: Floats


@pytest.fixture(scope="session")
def blob() -> TriangleMesh:
    """2,562 vertices on area 1; three different axes, and bumps."""
    ball = trimesh.creation.icosphere(subdivisions=4)
    x, y, z = ball.vertices.T
    bumps = np.sin(8 * x + 2 * z) + np.sin(7 * y - 4 * x) + np.sin(9 * z + 3 * y)
    radius = 1 + 0.2 * x + 0.1 * y + 0.15 * z + 0.1 * y * z + 0.07 * bumps
    mesh = TriangleMesh(ball.vertices * [1.0, 1.3, 1.9] * radius[:, None], ball.faces, name="blob")
    return mesh.with_vertices(mesh.vertices / mesh.length)


@pytest.fixture(scope="session")
def full(blob: TriangleMesh) -> DescribedSurface:
    return DescribedSurface(WorkingSurface(blob, blob, None))


@pytest.fixture(scope="session")
def planted(blob: TriangleMesh, full: DescribedSurface) -> Planted:
    inside = (blob.vertices[blob.faces] @ [1.0, 0.3, 0.2] > -0.05).all(axis=1)
    piece, kept = blob.submesh(inside)
    new = np.full(blob.vertex_count, -1)
    new[kept] = np.arange(len(kept))
    at = new[full.dense.vertices[:FIRST_LABELS]]
    labels = np.flatnonzero(at >= 0)
    working = WorkingSurface(piece, piece, None)
    normals = full.normals[kept]
    plain = DescribedSurface(working, reference=OTHER_REFERENCE, known=Known(normals=normals))
    known = Known(normals=normals, sparse=samples_at(plain, at[labels]))
    part = DescribedSurface(working, reference=OTHER_REFERENCE, known=known)
    return Planted(
        Question(full, part, SAME_SCALE), kept, labels, true_rotations(full, part, labels)
    )


def samples_at(surface: DescribedSurface, vertices: Ints) -> Samples:
    distances = Geodesics(surface.mesh).distances_from(vertices)
    x_axes, z_axes = surface.frames(vertices)
    compass = Compass(surface.mesh, vertices, x_axes=x_axes, z_axes=z_axes, near=NEAR)
    return Samples.of(vertices, distances, compass.toward(vertices, distances))


def true_rotations(full: DescribedSurface, part: DescribedSurface, labels: Ints) -> Floats:
    """(k,) angle of a direction in the part's frame, less that of the same in the full shape's."""
    there, up = full.frames(full.dense.vertices[labels])
    here, _ = part.frames(part.sparse.vertices)
    along = np.einsum("kc,kc->k", here, there)
    across = np.einsum("kc,kc->k", np.cross(up, here), there)
    rotations: Floats = np.arctan2(across, along)
    return rotations


@pytest.fixture(scope="module")
def back(planted: Planted) -> Problem:
    """The nodes of the blob look like anything on the piece."""
    question = Question(planted.question.part, planted.question.full, planted.question.comparison)
    shape = (len(question.part.sparse), len(question.full.dense), SHIFTS)
    similarity = np.random.default_rng(3).uniform(0.0, 0.4, shape)
    return labeling_problem(question, similarity.astype(np.float32), np.random.default_rng(4))
