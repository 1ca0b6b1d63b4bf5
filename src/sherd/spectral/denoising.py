"""How noisy the vertices of scans are, and the same surfaces with less noise.

What is laid on a whole keeps all that it has in common with that, and is averaged as little as its
noise allows. Pieces that are compared with each other are all averaged over one width, as bumps
that one has lost and the other one has are not alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import cg

from sherd.arrays import Floats
from sherd.mesh.topology import adjacency
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.operators import graph_laplacian, positive_stiffness, stiffness

__all__ = ["AlikeSmooth", "denoised", "noise_level", "smoothed_alike"]


# Mean curvature flow for a time of 5 sigma^2 averages over 3 sigma around each vertex. With noise
# of 0.2 and of 0.4 of the vertex spacing, twice as much and half as much gave larger errors.
TIME = 5.0
# Flows shorter than this share of the squared spacing hardly move anything. The curvature of coarse
# clean meshes alone asks for up to 0.02; those are left as they are.
SHORTEST = 0.03
# The median of |x| of a normal distribution with deviation 1.
MEDIAN = 0.6745

# Noise in the spacing of vertices, in the mean over the vertices of all pieces that are compared,
# or of one that has a tenth of these, from which on they are averaged. Curvature looks like noise,
# too: on clean pieces of 70 puzzles of 17 animals and people the mean is 0.053 at most, of one that
# has a tenth of the vertices 0.058, and of smaller ones up to 0.23. With noise of 0.0005 of the
# whole, a twentieth of the spacing, the mean is 0.056 to 0.073.
NOISY, ONE_NOISY = 0.06, 0.0775
TELLING = 0.1
# The finest bumps that are compared, in sqrt(area) of the largest piece, and their mean curvature,
# 1 / length, whose deviation is 2 on pieces of a wolf, 5 and 6 of a man and a horse, 8 of a cat.
# What is averaged away of them, and the noise that is left, are least together; see `_width`.
BUMP, BULGE = 0.02, 5.0
# One implicit step leaves much of the finest noise, whose curvature is largest: reliefs of a wolf
# with noise of 0.0015, a third of the spacing, agree with clean ones by 0.60 after one step, by
# 0.74 after three and by 0.76 after six.
STEPS = 3
# No vertex moves farther than the width, or than noise moved it. Long edges of a machine part would
# draw the corners between them to their other ends.
LARGEST_NOISE = 4.0
# Weight of edges opposite angles of 6 degrees and less. Cuts leave slivers, whose cotangents would
# be up to 10^7, and no step could be solved.
LARGEST_WEIGHT = 10.0


@dataclass(frozen=True, eq=False)
class AlikeSmooth:
    """Pieces averaged over one width, or as they were.

    Attributes
    ----------
    meshes
        With as many vertices each as before.
    noise
        Standard deviation of each, in their unit of length.
    noisy
        Whether that is so much of the spacing of its vertices that it harms.
    width
        Deviation of the Gaussian that they are averaged with, in that unit; 0 where they are clean.
    """

    meshes: tuple[TriangleMesh, ...]
    noise: tuple[float, ...]
    noisy: tuple[bool, ...]
    width: float

    @property
    def notices(self) -> tuple[tuple[str, ...], ...]:
        """What a user should know of each."""
        if self.width == 0.0:
            return ((),) * len(self.meshes)
        done = f"averaged over {self.width:.2g} before it is compared"
        return tuple(
            (f"its vertices are noisy (by about {noise:.2g}), so it is {done}",)
            if noisy
            else (f"others are noisy, so it is {done} as they are",)
            for noise, noisy in zip(self.noise, self.noisy, strict=True)
        )


def noise_level(mesh: TriangleMesh) -> float:
    """Standard deviation of independent noise of the vertices, in the mesh's unit.

    `d = (I - A)^2 v`, A the mean over neighbors, is zero where curvature changes evenly. Noise of
    deviation s in each coordinate gives its normal part the deviation `s |B_i|`, B_i the row of
    `(I - A)^2`; the median over the vertices that are no neighbors of the border tells s.
    """
    count = mesh.vertex_count
    graph = adjacency(mesh.faces, count)
    degree = np.asarray(graph.sum(axis=1)).ravel()
    mean = sparse.diags_array(1.0 / np.maximum(degree, 1.0)) @ graph
    once = sparse.eye_array(count) - mean
    twice = (once @ once).tocsr()
    border = np.zeros(count)
    border[mesh.boundary_vertices] = 1.0
    inside = (degree > 0) & (border + graph @ border == 0)
    if not inside.any():
        return 0.0
    off = ((twice @ mesh.vertices) * mesh.vertex_normals).sum(axis=1)[inside]
    gain = np.sqrt(np.asarray(twice.multiply(twice).sum(axis=1)).ravel()[inside])
    return float(np.median(np.abs(off) / gain) / MEDIAN)


def denoised(mesh: TriangleMesh) -> TriangleMesh:
    """The mesh after a time of mean curvature flow that its own noise asks for; often itself.

    References
    ----------
    Desbrun, Meyer, Schroeder, Barr, *Implicit fairing of irregular meshes using diffusion and
    curvature flow*, 1999, equation 9. The border stays where it is: it would shrink.
    """
    used = mesh.used_vertices
    square = mesh.area / len(used)  # of the spacing
    time = TIME * noise_level(mesh) ** 2
    if time < SHORTEST * square:
        return mesh
    free = np.zeros(mesh.vertex_count)
    free[used] = 1.0
    free[mesh.boundary_vertices] = 0.0
    areas = np.maximum(mesh.vertex_areas, 1e-12 * square)
    weak = stiffness(mesh.vertices, mesh.faces)
    return mesh.with_vertices(_flowed(mesh.vertices, weak, areas, free, time))


def smoothed_alike(meshes: Sequence[TriangleMesh], unit: float) -> AlikeSmooth:
    """Pieces that are compared with each other, all averaged over one width if they are noisy.

    Parameters
    ----------
    meshes
        In one unit of length.
    unit
        What sqrt(area) of the largest is in that unit.

    Notes
    -----
    Mean curvature flow inside, from a border that flows along itself alone, as a piece would shrink
    with it. A border that stayed as rough as it is would be seen from far, since curvature is
    averaged over up to 0.14, and all of a ragged edge is in the angles beside it: reliefs of a wolf
    with noise of 0.0007 agree with clean ones by 0.59 then, and by 0.94 if it flows. Two noisy
    scans of one surface have reliefs alike by 0.97 afterwards, instead of 0.6 (cat, horse; 0.0007,
    a twelfth of the spacing).

    References
    ----------
    Desbrun, Meyer, Schroeder, Barr, *Implicit fairing of irregular meshes using diffusion and
    curvature flow*, 1999, equation 9.
    """
    counts = np.array([len(mesh.used_vertices) for mesh in meshes])
    spacing = np.sqrt([mesh.area / count for mesh, count in zip(meshes, counts, strict=True)])
    noise = np.array([noise_level(mesh) for mesh in meshes])
    shares = noise / spacing
    # as long as any piece has so many; of more than ten alike ones none may
    telling = counts >= min(TELLING * counts.sum(), counts.max())
    if counts @ shares < NOISY * counts.sum() and shares[telling].max() < ONE_NOISY:
        return AlikeSmooth(tuple(meshes), tuple(noise.tolist()), (False,) * len(meshes), 0.0)
    width = max(map(_width, (noise / unit)[telling], (spacing / unit)[telling])) * unit
    most = np.maximum(width, LARGEST_NOISE * noise)
    smooth = tuple(_averaged_over(*each, width) for each in zip(meshes, most, strict=True))
    return AlikeSmooth(smooth, tuple(noise.tolist()), tuple((shares >= NOISY).tolist()), width)


def _width(noise: float, spacing: float) -> float:
    """Deviation of the Gaussian that bumps are seen best through.

    White noise of deviation n on vertices of spacing h leaves mean curvature with the variance
    `n^2 h^2 / (8 pi w^6)` behind a Gaussian of width w, the integral of `(k^2 / 2)^2 exp(-w^2 k^2)`
    over all waves k; and of bumps of width b and curvature B the Gaussian takes `B w^2 / (2 b^2)`.
    The sum of the squares is least at `w^10 = 6 / (8 pi) (n h b^2 / B)^2`.
    """
    return float((6 / (8 * np.pi)) ** 0.1 * (noise * spacing * BUMP**2 / BULGE) ** 0.2)


def _averaged_over(mesh: TriangleMesh, most: float, width: float) -> TriangleMesh:
    """The mesh averaged over a width, no vertex of which moves farther than `most`."""
    time = 0.5 * width**2 / STEPS
    smooth = mesh
    for _ in range(STEPS):
        smooth = _flowed_inside(_flowed_along_the_border(smooth, time), time)
    moved = smooth.vertices - mesh.vertices
    lengths = np.linalg.norm(moved, axis=1, keepdims=True)
    return mesh.with_vertices(
        mesh.vertices + moved * np.minimum(1.0, most / np.maximum(lengths, most))
    )


def _flowed_inside(mesh: TriangleMesh, time: float) -> TriangleMesh:
    """One step of mean curvature flow; the border stays."""
    free = np.ones(mesh.vertex_count)
    free[mesh.boundary_vertices] = 0.0
    areas = np.maximum(mesh.vertex_areas, 1e-12 * mesh.area / mesh.vertex_count)
    weak = positive_stiffness(mesh.vertices, mesh.faces, most=LARGEST_WEIGHT)
    return mesh.with_vertices(_flowed(mesh.vertices, weak, areas, free, time))


def _flowed_along_the_border(mesh: TriangleMesh, time: float) -> TriangleMesh:
    """One step of the border by itself, as curves in space; all else stays."""
    first, second = mesh.boundary_edges.T
    lengths = np.linalg.norm(mesh.vertices[first] - mesh.vertices[second], axis=1)
    lengths = np.maximum(lengths, mesh.mean_edge_length / LARGEST_WEIGHT)
    count = mesh.vertex_count
    half = sparse.coo_array((1.0 / lengths, (first, second)), shape=(count, count)).tocsr()
    masses = 0.5 * (
        np.bincount(first, lengths, minlength=count) + np.bincount(second, lengths, minlength=count)
    )
    free = (masses > 0).astype(np.float64)
    held = np.where(masses > 0, masses, 1.0)
    laplacian = graph_laplacian(half + half.T)
    return mesh.with_vertices(_flowed(mesh.vertices, laplacian, held, free, time))


def _flowed(
    points: Floats, laplacian: sparse.csr_array, masses: Floats, free: Floats, time: float
) -> Floats:
    """Points (n, 3) after `(M + t L) x = M x0`; those that are not free stay."""
    inner = sparse.diags_array(free)
    flow = time * laplacian
    system = (sparse.diags_array(masses) + inner @ flow @ inner).tocsr()
    # one step from where the vertices are, so that fixed ones pull their neighbors to themselves
    force = -free[:, None] * (flow @ points)
    jacobi = sparse.diags_array(1.0 / system.diagonal())
    step = [cg(system, column, rtol=1e-4, maxiter=200, M=jacobi)[0] for column in force.T]
    moved: Floats = points + np.stack(step, axis=1)
    return moved
