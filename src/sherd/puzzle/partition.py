"""The partition of the full shape: each vertex to one piece or to the gap, by minimum cuts.

    E(u) = sum_i integral u_i f_i + (omega / 2) sum_i Per(u_i),    u_i in {0, 1}, sum_i u_i = 1

is the multi-phase Mumford-Shah energy for memberships that jump between 0 and 1, i = 0 being the
gap. With s_i the distance to the border of piece i's image, positive inside, the misfits are

    f_i = clip(1/2 - s_i / (2 delta), 0, 1)      f_0 = clip(1/2 + max_i s_i / (2 delta), 0, 1)

so a vertex is given to the piece that covers it most deeply, a strip that two claim is cut along
its middle, a crack that is narrow beside its length goes to both sides, and a real gap keeps its
border. Solved by expansions (Boykov, Veksler, Zabih, *Fast approximate energy minimization via
graph cuts*, 2001, section 5), each a minimum cut; the energy is at most twice the least.
Perimeters of a multi-phase Mumford-Shah model as in Chan and Vese, *A multiphase level set
framework*, 2002; that one phase is the gap follows Litany, Rodola, Bronstein, Bronstein, Cremers,
*Non-rigid puzzles*, 2016, section 4.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import cKDTree

from sherd.arrays import Bools, Floats, Ints
from sherd.correspondence.shared.region_cut import seam_lengths
from sherd.mesh.geometry import edge_graph
from sherd.mesh.minimum_cut import minimum_cut
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = [
    "GAP",
    "Partition",
    "border_depth",
]

GAP = -1
# Two vertex spacings of a 10,000-vertex mesh: as far as borders of right placements are off.
DELTA = 0.02
# Price of border length: a crack narrower than 2 sqrt(delta omega), 0.02, is closed.
OMEGA = 0.005
# Share of the rim of a gap that has borders of pieces within DELTA, below which it is a lapse. Of
# 36 puzzles of animated animals the twelve gaps where a piece is missing or was refused have 0.79
# and more; of 61 others that one piece surrounds 54 have none, and none of the rest below 0.36.
LEAST_END = 0.25
# All labels are expanded so often; later sweeps hardly change a vertex.
SWEEPS = 2


class Partition:
    """Gives every vertex of one full shape to one of several pieces or to the gap.

    Parameters
    ----------
    mesh
        The full shape itself, at unit scale.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        self._mesh = mesh
        self._seams = seam_lengths(mesh)
        self._paths = edge_graph(mesh.vertices, mesh.edges)

    def labels(self, regions: Sequence[Bools]) -> Ints:
        """The piece (n,) of each vertex, -1 for the gap, from the regions (n,) of the pieces."""
        count = self._mesh.vertex_count
        if not regions:
            return np.full(count, GAP, dtype=np.int64)
        depth = np.array([border_depth(self._paths, mask, DELTA) for mask in regions])
        misfit = np.clip(0.5 - depth / (2 * DELTA), 0.0, 1.0)
        gap = np.clip(0.5 + depth.max(axis=0) / (2 * DELTA), 0.0, 1.0)
        # the gap comes last here, so that numbers of pieces stay
        misfit = np.concatenate([misfit, gap[None, :]])
        labels: Ints = misfit.argmin(axis=0)
        for _ in range(SWEEPS):
            before = labels
            for label in range(len(misfit)):
                labels = self._expanded(labels, label, misfit)
            if np.array_equal(before, labels):
                break
        return np.where(labels == len(regions), GAP, labels)

    def without_cracks(self, labels: Ints, width: float) -> Ints:
        """The labels (n,) with cracks in the gap given to the nearer of the two pieces at them.

        A crack is where the gap has no room for a disk as wide as `width`, and two pieces are so
        near that a path between them is no longer than that. The slit in a single piece stays, and
        so does the border of a gap that is wide, where two pieces meet at it. What is left where
        three cracks meet goes too: a gap between pieces that is no wider on average, which is its
        area over half the length of its rim.

        Parameters
        ----------
        labels
            As :meth:`labels` gives them.
        width
            At unit scale; borders of two pieces that are farther apart are of different cuts.
        """
        gap = labels == GAP
        pieces = np.unique(labels[~gap])
        if len(pieces) < 2 or not gap.any():
            return labels
        half = 0.5 * float(self._paths.data.mean())
        wide = border_depth(self._paths, gap, width) > 0.5 * width
        # what disks around the vertices deep inside cover, up to the spacing of vertices
        wide = border_depth(self._paths, wide, width) > -(0.5 * width + half)
        away = np.array(
            [
                csgraph.dijkstra(
                    self._paths,
                    directed=False,
                    indices=np.flatnonzero(labels == piece),
                    min_only=True,
                    limit=width + 2 * half,
                )
                for piece in pieces
            ]
        )
        # borders run half way between vertices
        across = np.partition(away, 1, axis=0)[:2].sum(axis=0) - 2 * half
        crack = gap & ~wide & (across <= width)
        return self._without_narrow_gaps(
            np.where(crack, pieces[away.argmin(axis=0)], labels), width
        )

    def without_lapses(self, labels: Ints, ends: Floats) -> Ints:
        """The labels (n,) with those gaps given to the pieces at them where no piece ends.

        A piece ends at its border only. Where the gap begins and no border is near, the image of a
        piece does not reach what belongs to it: the tip of a toe.

        Parameters
        ----------
        labels
            As :meth:`labels` gives them.
        ends
            (p, 3) points on the borders of all pieces.
        """
        if not len(ends):
            return labels
        middle = self._mesh.vertices[self._mesh.edges].mean(axis=1)
        tree = cKDTree(ends)

        def is_lapse(rim: Ints) -> bool:
            away, _ = tree.query(middle[rim], distance_upper_bound=DELTA)
            length = self._seams[rim]
            return float(length @ np.isfinite(away)) < LEAST_END * float(length.sum())

        return self._without_gaps(labels, lambda _, rim: is_lapse(rim))

    def core(self, region: Bools, margin: float) -> Bools:
        """The vertices (n,) of a region that lie deeper inside than a margin."""
        inside: Bools = region & (border_depth(self._paths, region, 2 * margin) > margin)
        return inside

    def grown(self, region: Bools, margin: float) -> Bools:
        """A region (n,) and the vertices that are no farther from it than a margin."""
        reached: Bools = region | (border_depth(self._paths, region, 2 * margin) > -margin)
        return reached

    def touching(self, labels: Ints) -> dict[tuple[int, int], float]:
        """Length of the border between each two pieces that have one, at unit scale."""
        first, second = np.sort(labels[self._mesh.edges], axis=1).T
        between = (first != second) & (first != GAP)
        found: dict[tuple[int, int], float] = {}
        for one, other, length in zip(
            first[between].tolist(),
            second[between].tolist(),
            self._seams[between].tolist(),
            strict=True,
        ):
            found[one, other] = found.get((one, other), 0.0) + length
        return found

    def gaps(self, labels: Ints) -> list[Ints]:
        """The vertices of each connected part of the gap, largest area first."""
        rows = np.flatnonzero(labels == GAP)
        number, part = csgraph.connected_components(self._paths[rows][:, rows], directed=False)
        found = [rows[part == k] for k in range(number)]
        areas = self._mesh.vertex_areas
        return sorted(found, key=lambda some: -float(areas[some].sum()))

    def deepest(self, vertices: Ints) -> int:
        """The one of the vertices that is farthest from all others."""
        mask = np.zeros(self._mesh.vertex_count, dtype=bool)
        mask[vertices] = True
        depth = border_depth(self._paths, mask, np.inf)
        return int(vertices[depth[vertices].argmax()])

    def _without_narrow_gaps(self, labels: Ints, width: float) -> Ints:
        """The labels (n,) with gaps between pieces given to them that are narrower on average."""
        areas = self._mesh.vertex_areas

        def is_narrow(gap: Ints, rim: Ints) -> bool:
            beside = np.unique(labels[self._mesh.edges[rim]])
            wide = 2 * float(areas[gap].sum()) > width * float(self._seams[rim].sum())
            return not wide and len(beside[beside != GAP]) > 1

        return self._without_gaps(labels, is_narrow)

    def _without_gaps(self, labels: Ints, is_none: Callable[[Ints, Ints], bool]) -> Ints:
        """The labels (n,) with some gaps given to the nearest pieces.

        Whether a gap is none is asked of its vertices and the rows of edges along its rim.
        """
        first, second = self._mesh.edges.T
        nearest = self._nearest_pieces(labels)
        filled = labels.copy()
        for gap in self.gaps(labels):
            inside = np.zeros(len(labels), dtype=bool)
            inside[gap] = True
            rim = np.flatnonzero(inside[first] != inside[second])
            if len(rim) and is_none(gap, rim):
                filled[gap] = nearest[gap]
        return filled

    def _nearest_pieces(self, labels: Ints) -> Ints:
        """The label (n,) of the vertex nearest to each that is in no gap."""
        placed = np.flatnonzero(labels != GAP)
        if not len(placed):
            return labels
        _, _, sources = csgraph.dijkstra(
            self._paths,
            directed=False,
            indices=placed,
            min_only=True,
            return_predecessors=True,
        )
        return np.where(sources >= 0, labels[sources], GAP)

    def _expanded(self, labels: Ints, label: int, misfit: Floats) -> Ints:
        """The labels (n,) of least energy where each vertex keeps its own or takes `label`."""
        active = np.flatnonzero((misfit[label] < 1.0) & (labels != label))
        if not len(active):
            return labels
        number = np.full(len(labels), -1, dtype=np.int64)
        number[active] = np.arange(len(active))
        areas = self._mesh.vertex_areas[active]
        keep = areas * misfit[labels[active], active]
        take = areas * misfit[label, active]
        first, second = self._mesh.edges.T
        seams = OMEGA * self._seams
        differ = labels[first] != labels[second]
        # one end cannot change
        for here, there in ((first, second), (second, first)):
            some = (number[here] >= 0) & (number[there] < 0)
            at, other = number[here[some]], labels[there[some]]
            np.add.at(keep, at, np.where(differ[some], seams[some], 0.0))
            np.add.at(take, at, np.where(other == label, 0.0, seams[some]))
        both = (number[first] >= 0) & (number[second] >= 0)
        here, there = number[first[both]], number[second[both]]
        same = np.where(differ[both], seams[both], 0.0)  # both keep
        # E(keep, take) = E(take, keep) = seam, E(take, take) = 0
        np.add.at(take, here, seams[both] - same)
        np.add.at(take, there, -seams[both])
        price = 2 * seams[both] - same
        taken = minimum_cut(take - keep, (here, there), price, np.zeros_like(price))
        result = labels.copy()
        result[active[taken]] = label
        return result


def border_depth(paths: sparse.csr_array, mask: Bools, reach: float) -> Floats:
    """Distance (n,) to the border of a mask, positive inside, at most `reach` either way.

    Parameters
    ----------
    paths
        (n, n) lengths of edges.
    mask
        (n,) bool. Its border runs half way between vertices inside and outside.
    """
    half = 0.5 * float(paths.data.mean()) if len(paths.data) else 0.0
    depth = np.full(len(mask), reach)
    if mask.all() or not mask.any():
        return depth if mask.all() else -depth
    for side, sign in ((mask, -1.0), (~mask, 1.0)):
        away = csgraph.dijkstra(
            paths,
            directed=False,
            indices=np.flatnonzero(side),
            min_only=True,
            limit=reach + half,
        )
        depth[~side] = sign * np.clip(away[~side] - half, 0.0, reach)
    return depth
