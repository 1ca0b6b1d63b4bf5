"""Locating by votes: soft matches of the part's samples, drawn as a Mumford-Shah region."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from sherd.arrays import Bools, Floats, Ints, Singles
from sherd.descriptors.rotation_shot import mirrored_spectra, similarity
from sherd.energy.cleanup import clean_region
from sherd.energy.logistic import LogisticOptions, LogisticRegion, logistic_regions
from sherd.energy.problem import EnergyWeights, RegionProblem, region_problem
from sherd.mesh import topology
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import Stages
from sherd.region.found import Found
from sherd.region.soft_match import CAPACITY_WIDTH, MatchGeometry, soft_match, spread
from sherd.region.weights import chosen_weights
from sherd.results.locate_options import LocateOptions
from sherd.results.placement import Placement
from sherd.spectral.basis import EigenBasis
from sherd.surface.described import LEAST_TRUST, RADII, DescribedSurface
from sherd.surface.samples import Samples
from sherd.threads import begun

__all__ = ["locate_by_voting"]

# The data term asks for the whole area of each of this many groups of samples: as many as there
# are body parts to tell apart, and few enough to keep the products small.
GROUP_COUNT = 32
# An alternative that shares this much of the best region's votes is the same placement.
SAME_PLACE = 0.5
# One start costs little, so the rounds may take as long as small parts with long borders need.
FINAL = LogisticOptions(search_evaluations=20, survivors=1, round_evaluations=100)
# Alternatives are sketches: one round instead of three.
SKETCH = LogisticOptions(search_evaluations=20, survivors=1, crispness=(0.02,))


@dataclass(frozen=True, eq=False)
class Similarities:
    """Similarity of each sample with each candidate, as it is and mirrored, (q, c) float32 each."""

    direct: Singles
    mirrored: Singles


@dataclass(frozen=True, eq=False)
class VotedPlace:
    """Where the samples voted.

    Attributes
    ----------
    votes
        (n,) density of the part's area by votes, about 1 inside and 0 outside.
    group_votes
        (n, g) the same by groups of samples.
    group_areas
        (g,) share of each group in the full shape's area.
    score
        Mean similarity at the votes, at most 1.
    """

    votes: Floats
    group_votes: Floats
    group_areas: Floats
    score: float


def locate_by_voting(
    full: DescribedSurface, part: DescribedSurface, options: LocateOptions, stages: Stages
) -> Found:
    """Locate `part` on `full`; see :func:`sherd.locate`."""
    mesh = full.mesh
    fraction = min(part.mesh.area, mesh.area)
    with stages("samples"):
        samples = part.sparse
    with stages("descriptors"):
        candidates = full.spread.vertices
        similarities = _compared(full, part)
    with stages("eigenbasis"):
        basis = full.basis(options.basis_size)
    poll = _Poll(
        mesh,
        basis.eigenvectors.astype(np.float32),
        candidates,
        _geometry(mesh, basis, part, candidates, fraction),
        _groups(samples),
    )
    with stages("votes"):
        place = poll.vote(similarities.direct)
    weights = chosen_weights(options, basis, fraction)
    drawing = _Drawing(
        basis,
        _problem(mesh, place, fraction, weights),
        topology.adjacency(mesh.faces, mesh.vertex_count),
    )
    twin = begun(lambda: _Sketch.of(poll.vote(similarities.mirrored), drawing, mirrored=True))
    with stages("region"):
        best, mask = drawing.region(place, FINAL)
    with stages("alternatives"):
        sketches = []
        if mesh.vertex_areas[~mask].sum() >= fraction:  # while another core is at the twin
            elsewhere = poll.vote(similarities.direct, forbidden=mask)
            sketches.append(_Sketch.of(elsewhere, drawing, mirrored=False))
        sketches.insert(0, twin())
        others = _alternatives(sketches, mask, mesh.vertex_areas)
    return Found(
        best=Placement(mask=mask, membership=best.membership, score=place.score),
        alternatives=others,
        phase_field=best.phase_field,
        energy=best.energy,
        convergence=best.status,
        weights=weights,
    )


def _compared(full: DescribedSurface, part: DescribedSurface) -> Similarities:
    """Rotation-searched SHOT of the samples against the candidates.

    Radii that reach over the cut count less.
    """
    seen, axes = full.spread.spectra, full.spread.axes
    sought = axes.project(part.trusted_spectra(part.sparse.vertices))
    return Similarities(similarity(seen, sought), similarity(seen, mirrored_spectra(sought)))


def _geometry(
    mesh: TriangleMesh,
    basis: EigenBasis,
    part: DescribedSurface,
    candidates: Ints,
    part_fraction: float,
) -> MatchGeometry:
    """Gather what soft matching needs; `mesh` and `basis` are of the full shape."""
    samples = part.sparse
    depth = part.cut_distance[samples.vertices]
    areas = np.bincount(samples.cells, part.mesh.vertex_areas, minlength=len(samples))
    _, nearest = cKDTree(mesh.vertices[candidates]).query(mesh.vertices)
    return MatchGeometry(
        sample_areas=areas / areas.sum(),
        trust=np.clip(depth / RADII[1], LEAST_TRUST, 1.0),
        sample_distances=np.asarray(samples.between, dtype=np.float64),
        areas=np.bincount(nearest, mesh.vertex_areas, len(candidates)) / mesh.area,
        part_fraction=part_fraction,
        eigenvalues=basis.eigenvalues,
        eigenvectors=basis.eigenvectors[candidates].astype(np.float32),
    )


def _groups(samples: Samples) -> Ints:
    """Group (q,) of each sample: the nearest of those that lie farthest apart."""
    centers = samples.farthest_first[:GROUP_COUNT]
    nearest: Ints = np.argmin(samples.between[centers], axis=0)
    return nearest


@dataclass(frozen=True, eq=False)
class _Poll:
    """Lets every sample vote, and counts the votes on all vertices."""

    full: TriangleMesh
    eigenvectors: Singles
    candidates: Ints
    geometry: MatchGeometry
    groups: Ints

    def vote(self, similarities: Singles, *, forbidden: Bools | None = None) -> VotedPlace:
        """The place of most votes; `forbidden` (n,) are vertices that get none."""
        geometry = self.geometry
        closed = None if forbidden is None else forbidden[self.candidates]
        probability = soft_match(similarities, geometry, forbidden=closed)
        agreement = np.einsum("qn,qn->q", probability, similarities)
        groups = self.groups
        shares = np.zeros((groups.max() + 1, len(groups)))
        shares[groups, np.arange(len(groups))] = geometry.sample_areas * geometry.part_fraction
        mass = shares.astype(np.float32) @ probability
        spread_out = spread(mass, geometry, CAPACITY_WIDTH, onto=self.eigenvectors)
        density = spread_out.astype(np.float64)
        # what the clipping of the truncated heat kernel added is taken off again, by group
        total = np.maximum(density @ self.full.vertex_areas / self.full.area, 1e-30)
        density *= (shares.sum(axis=1) / total)[:, None]
        return VotedPlace(
            votes=density.sum(axis=0),
            group_votes=density.T,
            group_areas=shares.sum(axis=1),
            score=float(agreement @ geometry.sample_areas),
        )


def _problem(
    mesh: TriangleMesh, place: VotedPlace, part_area: float, weights: EnergyWeights
) -> RegionProblem:
    """Which region has the votes of each group.

    The data term of the paper asks that each group of samples finds its whole area inside;
    the votes themselves are the evidence at each vertex.
    """
    return region_problem(
        mesh,
        full_descriptors=place.group_votes,
        part_integral=place.group_areas,
        part_area=part_area,
        weights=weights,
        evidence=_evidence(place),
    )


def _evidence(place: VotedPlace) -> Floats:
    return np.minimum(place.votes, 1.0) - 0.5


@dataclass(frozen=True, eq=False)
class _Drawing:
    """Draws the region of least energy for given votes; what they have in common is kept."""

    basis: EigenBasis
    problem: RegionProblem
    adjacency: sparse.csr_array

    def region(self, place: VotedPlace, effort: LogisticOptions) -> tuple[LogisticRegion, Bools]:
        """The logistic membership and its crisp form (n,) bool; see :func:`_problem`."""
        problem = self.problem.with_descriptors(place.group_votes, place.group_areas)
        problem = problem.with_evidence(_evidence(place))
        start = np.clip(place.votes, 0.0, 1.0)
        region = logistic_regions(problem, self.basis, start[None], options=effort)[0]
        areas, area = problem.vertex_areas, problem.part_area
        return region, clean_region(region.membership, areas, area, adjacency=self.adjacency)


@dataclass(frozen=True, eq=False)
class _Sketch:
    """Another place, drawn with less effort: its score, its membership and its mask."""

    score: float
    membership: Floats
    mask: Bools
    mirrored: bool

    @classmethod
    def of(cls, place: VotedPlace, drawing: _Drawing, *, mirrored: bool) -> _Sketch:
        region, mask = drawing.region(place, SKETCH)
        return cls(place.score, region.membership, mask, mirrored)


def _alternatives(sketches: list[_Sketch], mask: Bools, areas: Floats) -> tuple[Placement, ...]:
    """Those of the sketches that are other places than the best region, best first."""
    found = [
        Placement(
            mask=sketch.mask,
            membership=sketch.membership,
            score=sketch.score,
            mirrored=sketch.mirrored,
        )
        for sketch in sketches
        if areas[mask & sketch.mask].sum() < SAME_PLACE * areas[mask].sum()
    ]
    return tuple(sorted(found, key=lambda placement: -placement.score))
