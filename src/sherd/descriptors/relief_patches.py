"""Relief patches: what the skin around a point looks like, as far as it is there, turned freely.

SHOT describes how normals turn, which changes where a joint bends, and near a cut it sees half of a
neighborhood. Bumps and hollows stay on the skin in every pose. So they are drawn in polar
coordinates around a point, as on a map, and two such patches are compared where both are seen, in
all rotations at once: the cuts of both may go through them anywhere. A mirrored patch is another
one.

Two *pictures* each of a fine and a wider relief are drawn: of Gaussian curvature, which bending
leaves as it is, and of mean curvature, which has a slope where the other one is flat. They are
ranks, as a nose or a hoof has more relief than all the rest.

References
----------
Schmidt, Grimm, Wyvill, *Interactive decal compositing with discrete exponential maps*, 2006: the
coordinates of a vertex are those of the neighbor it is reached from, by the shortest way along
edges, and the edge between them, laid flat in the tangent plane there. Padfield, *Masked object
registration in the Fourier domain*, 2012, section 2: correlation of what both masks show, which is
computed here shift by shift.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np

from sherd.arrays import Floats, Ints, Singles, blocks_of_rows
from sherd.descriptors.relief import relief_and_bulge
from sherd.mesh.topology import adjacency
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.optical_flow import ranks
from sherd.threads import one_blas_thread, over_rows, side_by_side

__all__ = [
    "SHIFTS",
    "ReliefPatches",
    "patch_similarity",
    "patch_similarity_in_pairs",
    "relief_patches",
    "relief_pictures",
    "similarity_anywhere",
]

# Widths of bumps, in sqrt(area) of the larger piece: little more than the edges of a mesh of 10,000
# vertices, and twice that. On pairs of a horse's pieces the right label came first for a few nodes
# in a hundred more than by one width of 0.018, 0.02 or 0.025, and by three widths for no more.
WIDTHS = (0.014, 0.03)
# The patch reaches as far as the largest neighborhood of SHOT, in rings of the size of a bump. With
# 0.14 the right label came first for more nodes of a man's and a horse's pieces (0.39 and 0.26
# instead of 0.35 and 0.24), but of wrong places more are more alike than mirrored, too: the chance
# to tell a right answer from a wrong one by that (58 each, six puzzles) was 0.93 instead of 0.96.
RADIUS, RINGS = 0.10, 5
# As many as rotations that labels are told apart by.
SHIFTS = 16
# Nearer to the cut than this the angles of faces that are gone are missing in the average.
CUT = 0.02
# Two patches are compared where they have a sixth of a whole one in common, and less of it proves
# less: where nothing is alike correlations scatter by the root of what is seen. But near a cut
# right labels have less in common, too, and by the fourth root they come first more often than by
# the second.
LEAST_COMMON = 0.15
# Patches that are compared at a time: their products stay in the cache of a core.
BLOCK = 512
# Of patches without relief, as of a plane, whose correlation would be that of their noise.
LEAST_SPREAD = 1e-4


@dataclass(frozen=True, eq=False)
class ReliefPatches:
    """The skin around q points.

    Attributes
    ----------
    means
        (q, 4, r, 16) float32 means of the pictures in each cell; 0 where nothing is seen.
    seen
        (q, r, 16) float32 in [0, 1], how much is seen of each cell.
    """

    means: Singles
    seen: Singles

    def __len__(self) -> int:
        return len(self.seen)

    def __getitem__(self, rows: Ints | slice) -> ReliefPatches:
        return ReliefPatches(self.means[rows], self.seen[rows])

    def mirrored(self) -> ReliefPatches:
        """Those of the mirror image: sectors run the other way around."""
        return ReliefPatches(self.means[..., ::-1], self.seen[..., ::-1])


# each question asks for those of both of its surfaces, for the labels and for every answer
@lru_cache(maxsize=4)
def relief_pictures(mesh: TriangleMesh) -> Floats:
    """(4, n) ranks of relief and bulge of each of `WIDTHS`, from -1/2 to 1/2."""
    everywhere = np.ones(mesh.vertex_count, dtype=bool)
    pictures = [each for width in WIDTHS for each in relief_and_bulge(mesh, width)]
    return np.array([ranks(each, everywhere) for each in pictures])


def relief_patches(
    mesh: TriangleMesh,
    normals: Floats,
    cut_distance: Floats,
    queries: Ints,
    *,
    x_axes: Floats,
) -> ReliefPatches:
    """Patches around some vertices of a mesh in units of sqrt(area).

    Parameters
    ----------
    mesh
        The surface.
    normals
        (n, 3) smoothed unit normals.
    cut_distance
        (n,) distance to the cut; what is nearer than `CUT` counts less, and what is at it nothing.
    queries
        (q,) vertices.
    x_axes
        (q, 3) unit tangent axis of each query; turning it turns the sectors and nothing else.
    """
    from sherd.descriptors.polar_kernel import polar_means  # loads slowly  # noqa: PLC0415

    graph = adjacency(mesh.faces, mesh.vertex_count)
    pictures = relief_pictures(mesh)
    means = np.zeros((len(queries), len(pictures), RINGS, SHIFTS))
    areas = np.zeros((len(queries), RINGS, SHIFTS))
    width = RADIUS / RINGS
    over_rows(
        polar_means, len(queries), graph.indptr.astype(np.int64), graph.indices.astype(np.int64),
        np.ascontiguousarray(mesh.vertices), np.ascontiguousarray(normals), queries,
        np.ascontiguousarray(x_axes), np.ascontiguousarray(normals[queries]), width,
        pictures, mesh.vertex_areas * np.clip(cut_distance / CUT, 0.0, 1.0), means, areas,
    )  # fmt: skip
    flat = np.pi * RADIUS**2 * _shares()
    # half of a cell says what is in it, and where skin curves cells are smaller than in a plane
    seen = np.minimum(areas / (0.5 * flat), 1.0)
    return ReliefPatches(means.astype(np.float32), seen.astype(np.float32))


@one_blas_thread()  # shifts are side by side already; products this small are far slower on two
def patch_similarity(
    full: ReliefPatches, part: ReliefPatches, cells: Ints, cell_count: int
) -> Singles:
    """Best similarity (q, cells, 16) of each patch of the part with the patches of each cell.

    The correlation of both where both are seen, times the fourth root of how much that is.
    Entry (i, l, s) compares at rotation `2 pi s / 16`, as :func:`pooled_similarity` does. 0 where
    too little is seen of both, and of cells (m,) that hold no patch.
    """
    order = np.argsort(cells, kind="stable")
    there, cells = _Moments.of(full[order]), cells[order]
    blocks = [
        (rows, *np.unique(cells[rows], return_index=True, return_counts=True))
        for rows in blocks_of_rows(len(order), BLOCK)
    ]

    def best(own: _Moments) -> Singles:
        found = np.zeros((len(part), cell_count), dtype=np.float32)
        for rows, held, first, count in blocks:
            alike = _correlation(own, there[rows], _of_all)
            # several times faster than a reduction over runs of three
            for place in range(count.max()):
                one = alike[:, first + np.minimum(place, count - 1)]
                found[:, held] = np.maximum(found[:, held], one)
        return found

    return np.stack(_in_all_rotations(part, best), axis=2)


def patch_similarity_in_pairs(full: ReliefPatches, part: ReliefPatches) -> Singles:
    """Best similarity (p,) in any rotation of each patch with the one in its row of the other.

    As :func:`patch_similarity`, but of p pairs only; at least 0.
    """
    there = _Moments.of(full)

    alike = _in_all_rotations(part, lambda own: _correlation(own, there, _of_rows))
    best: Singles = np.maximum(np.max(alike, axis=0), np.float32(0.0))
    return best


@one_blas_thread()
def similarity_anywhere(full: ReliefPatches, part: ReliefPatches) -> tuple[Singles, Singles]:
    """Best similarity (q,) of each patch of the part with any patch, and with any one reversed.

    As :func:`patch_similarity`, in any rotation. Reversed, bumps are hollows: what is then as alike
    is so by accident.
    """
    there = _Moments.of(full)

    def best(own: _Moments) -> Singles:
        found = np.zeros((2, len(part)), dtype=np.float32)
        for rows in blocks_of_rows(len(full), BLOCK):
            alike = _correlation(own, there[rows], _of_all)
            found = np.maximum(found, [alike.max(axis=1), -alike.min(axis=1)])
        return found

    alike, reverse = np.max(_in_all_rotations(part, best), axis=0)
    return alike, reverse


@dataclass(frozen=True, eq=False)
class _Moments:
    """Of patches, their cells in one row.

    Roots of the shares (q, d) that are seen of a whole patch, times pictures (q, c, d), and times
    the sum of their squares (q, d): the product of those of two patches is what both see.
    """

    seen: Singles
    first: Singles
    second: Singles

    def __getitem__(self, rows: slice) -> _Moments:
        return _Moments(self.seen[rows], self.first[rows], self.second[rows])

    @classmethod
    def of(cls, patches: ReliefPatches, shift: int = 0) -> _Moments:
        """Of patches that are turned by `shift` sectors."""
        seen = np.roll(patches.seen * np.sqrt(_shares()).astype(np.float32), shift, axis=2)
        means = np.roll(patches.means, shift, axis=3)
        weighted = means * seen[:, None]
        rows = len(patches)
        return cls(
            seen.reshape(rows, -1),
            weighted.reshape(*means.shape[:2], -1),
            (weighted * means).sum(axis=1).reshape(rows, -1),
        )


def _in_all_rotations(
    part: ReliefPatches, compared: Callable[[_Moments], Singles]
) -> list[Singles]:
    """What is found of a part when others are turned by 0 to 15 sectors: it is turned back by them.

    It has far fewer patches than what it is compared with.
    """

    def turned(shift: int) -> Singles:
        return compared(_Moments.of(part, -shift))

    return side_by_side(partial(turned, shift) for shift in range(SHIFTS))


def _of_all(part: Singles, full: Singles) -> Singles:
    """(q, m) products of each row of (q, d) with each of (m, d)."""
    found: Singles = part @ full.T
    return found


def _of_rows(part: Singles, full: Singles) -> Singles:
    """(p,) products of rows of (p, d) with the same rows of the other."""
    found: Singles = np.einsum("pd,pd->p", part, full)
    return found


def _correlation(
    part: _Moments, full: _Moments, products: Callable[[Singles, Singles], Singles]
) -> Singles:
    """(q, m) or (p,) correlation of patches with others, over what both see.

    All pictures are one, each less its mean over what both see; `products` says which are compared.
    """
    common = products(part.seen, full.seen)
    of_means, of_own, of_other = (np.zeros_like(common) for _ in range(3))
    for k in range(part.first.shape[1]):
        own_mean = products(part.first[:, k], full.seen)
        other_mean = products(part.seen, full.first[:, k])
        of_means += own_mean * other_mean
        of_own += np.square(own_mean)
        of_other += np.square(other_mean)
    least = np.maximum(common, LEAST_SPREAD)
    product = products(_flat(part.first), _flat(full.first)) - of_means / least
    own = products(part.second, full.seen) - of_own / least
    other = products(part.seen, full.second) - of_other / least
    spread = np.sqrt(np.maximum(own, LEAST_SPREAD) * np.maximum(other, LEAST_SPREAD))
    # the fourth root
    alike = product / spread * np.sqrt(np.sqrt(np.minimum(common, 1.0)))
    found: Singles = np.where(common > LEAST_COMMON, alike, np.float32(0.0))
    return found


def _flat(pictures: Singles) -> Singles:
    """(q, c d) of (q, c, d): all pictures are one."""
    return pictures.reshape(len(pictures), -1)


def _shares() -> Floats:
    """(r, 1) share of each cell of a ring of the whole patch."""
    edges = np.arange(RINGS + 1) ** 2
    shares: Floats = np.diff(edges)[:, None] / (RINGS**2 * SHIFTS)
    return shares
