"""Locating by votes: soft matches of the part's samples, drawn as a Mumford-Shah region."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Bools, Floats, Ints, Singles
from sherd.descriptors.rotation_shot import (
    mirrored_spectra,
    rotation_spectra,
    similarity,
    weighted_spectra,
)
from sherd.descriptors.tangent_frames import smoothed_normals, tangent_axes
from sherd.energy.cleanup import clean_region
from sherd.energy.logistic import LogisticOptions, LogisticRegion, logistic_regions
from sherd.energy.problem import EnergyWeights, region_problem
from sherd.mesh import topology
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import Stages
from sherd.region.options import LocateOptions
from sherd.region.part_samples import PartSamples, sample_part
from sherd.region.region import Found, Placement
from sherd.region.soft_match import CAPACITY_WIDTH, MatchGeometry, soft_match, spread
from sherd.region.weights import chosen_weights
from sherd.spectral.basis import EigenBasis, eigenbasis
from sherd.spectral.sampling import farthest_point_sample_euclidean
from sherd.template import AXIS_WIDTH, RADII

__all__ = ["locate_by_voting"]


# A neighborhood reaching far over the cut still says something about the near side.
LEAST_TRUST = 0.15
# The data term asks for the whole area of each of this many groups of samples: as many as there
# are body parts to tell apart, and few enough to keep the products small.
GROUP_COUNT = 32


# Candidates lie 0.013 apart, a third of the smallest radius, so that one of them sees nearly what
# the best vertex would see.
CANDIDATE_COUNT = 6000
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
    full: TriangleMesh, part: TriangleMesh, options: LocateOptions, stages: Stages
) -> Found:
    """Locate `part` on `full`, which has area 1; see :func:`sherd.locate`."""
    fraction = min(part.area, full.area)
    with stages("eigenbasis"):
        basis = eigenbasis(full, options.basis_size)
    with stages("samples"):
        samples = sample_part(part, 1.0)
        candidates = _candidates(full)
    with stages("descriptors"):
        similarities = _compared(full, part, samples, candidates)
    poll = _Poll(full, basis, candidates, _geometry(full, basis, samples, candidates, fraction))
    with stages("votes"):
        place = poll.vote(similarities.direct)
    with stages("region"):
        drawing = _Drawing(full, basis, fraction, chosen_weights(options, basis, fraction))
        best, mask = drawing.region(place, FINAL)
    with stages("alternatives"):
        others = _alternatives(similarities, poll, mask, drawing)
    return Found(
        membership=best.membership,
        mask=mask,
        phase_field=best.phase_field,
        score=place.score,
        energy=best.energy,
        status=best.status,
        alternatives=others,
        weights=drawing.weights,
    )


def _candidates(full: TriangleMesh) -> Ints:
    """Vertices spread evenly over the full shape, all of them if they are few."""
    used = np.unique(full.faces)
    if len(used) <= CANDIDATE_COUNT:
        return used
    points = full.vertices[used]
    start = int(np.linalg.norm(points - points.mean(axis=0), axis=1).argmax())
    return used[farthest_point_sample_euclidean(points, CANDIDATE_COUNT, start=start)]


def _compared(
    full: TriangleMesh, part: TriangleMesh, samples: PartSamples, candidates: Ints
) -> Similarities:
    """Rotation-searched SHOT of the samples against the candidates.

    `full` has area 1 and `part` the same unit. Radii that reach over the cut count less.
    """
    full_spectra = _spectra(full, candidates)
    trust = np.clip(samples.cut_distance[samples.vertices, None] / np.array(RADII), LEAST_TRUST, 1)
    part_spectra = weighted_spectra(_spectra(part, samples.vertices), trust)
    return Similarities(
        similarity(full_spectra, part_spectra),
        similarity(full_spectra, mirrored_spectra(part_spectra)),
    )


def _geometry(
    full: TriangleMesh,
    basis: EigenBasis,
    samples: PartSamples,
    candidates: Ints,
    part_fraction: float,
) -> MatchGeometry:
    """Gather what soft matching needs; `full` and `basis` at area 1."""
    depth = samples.cut_distance[samples.vertices]
    _, nearest = cKDTree(full.vertices[candidates]).query(full.vertices)
    return MatchGeometry(
        sample_areas=samples.areas,
        trust=np.clip(depth / RADII[1], LEAST_TRUST, 1.0),
        sample_distances=samples.distances,
        areas=np.bincount(nearest, full.vertex_areas, len(candidates)) / full.area,
        part_fraction=part_fraction,
        eigenvalues=basis.eigenvalues,
        eigenvectors=basis.eigenvectors[candidates].astype(np.float32),
    )


@dataclass(frozen=True, eq=False)
class _Poll:
    """Lets every sample vote, and counts the votes on all vertices."""

    full: TriangleMesh
    basis: EigenBasis
    candidates: Ints
    geometry: MatchGeometry

    def vote(self, similarities: Singles, *, forbidden: Bools | None = None) -> VotedPlace:
        """The place of most votes; `forbidden` (n,) are vertices that get none."""
        geometry = self.geometry
        closed = None if forbidden is None else forbidden[self.candidates]
        probability = soft_match(similarities, geometry, forbidden=closed)
        agreement = np.einsum("qn,qn->q", probability, similarities)
        groups = _groups(geometry)
        shares = np.zeros((groups.max() + 1, len(groups)))
        shares[groups, np.arange(len(groups))] = geometry.sample_areas * geometry.part_fraction
        mass = shares.astype(np.float32) @ probability
        onto = self.basis.eigenvectors.astype(np.float32)
        density = spread(mass, geometry, CAPACITY_WIDTH, onto=onto).astype(np.float64)
        # what the clipping of the truncated heat kernel added is taken off again, by group
        total = np.maximum(density @ self.full.vertex_areas / self.full.area, 1e-30)
        density *= (shares.sum(axis=1) / total)[:, None]
        return VotedPlace(
            votes=density.sum(axis=0),
            group_votes=density.T,
            group_areas=shares.sum(axis=1),
            score=float(agreement @ geometry.sample_areas),
        )


def _alternatives(
    similarities: Similarities, poll: _Poll, mask: Bools, drawing: _Drawing
) -> tuple[Placement, ...]:
    """The mirrored twin and the best place outside the best region, if they are other places."""
    areas = poll.full.vertex_areas
    candidates = [("mirrored twin", poll.vote(similarities.mirrored), True)]
    if areas[~mask].sum() >= drawing.part_area:
        candidates.append(("elsewhere", poll.vote(similarities.direct, forbidden=mask), False))
    found = []
    for name, place, mirrored in candidates:
        region, outline = drawing.region(place, SKETCH)
        if areas[mask & outline].sum() < SAME_PLACE * areas[mask].sum():
            found.append(Placement(name, region.membership, outline, place.score, mirrored))
    return tuple(sorted(found, key=lambda placement: -placement.score))


@dataclass(frozen=True, eq=False)
class _Drawing:
    """Draws the region of least energy for given votes."""

    full: TriangleMesh
    basis: EigenBasis
    part_area: float
    weights: EnergyWeights

    def region(self, place: VotedPlace, effort: LogisticOptions) -> tuple[LogisticRegion, Bools]:
        """The logistic membership and its crisp form (n,) bool.

        The data term of the paper asks that each group of samples finds its whole area inside;
        the votes themselves are the evidence at each vertex.
        """
        problem = region_problem(
            self.full,
            full_descriptors=place.group_votes,
            part_integral=place.group_areas,
            part_area=self.part_area,
            weights=self.weights,
            evidence=np.minimum(place.votes, 1.0) - 0.5,
        )
        start = np.clip(place.votes, 0.0, 1.0)
        region = logistic_regions(problem, self.basis, start[None], options=effort)[0]
        adjacency = topology.adjacency(self.full.faces, self.full.vertex_count)
        areas = self.full.vertex_areas
        mask = clean_region(region.membership, areas, self.part_area, adjacency=adjacency)
        return region, mask


def _spectra(mesh: TriangleMesh, vertices: Ints) -> Singles:
    normals = smoothed_normals(mesh, AXIS_WIDTH)
    axes = normals[vertices]
    return rotation_spectra(
        mesh.vertices,
        normals,
        mesh.vertex_areas,
        vertices,
        x_axes=tangent_axes(axes, np.tile([1.0, 0.3, 0.2], (len(vertices), 1))),
        z_axes=axes,
        radii=RADII,
    )


def _groups(geometry: MatchGeometry) -> Ints:
    """Group of each sample: the nearest of the first samples, which lie farthest apart."""
    count = min(GROUP_COUNT, len(geometry.sample_areas))
    nearest: Ints = np.argmin(geometry.sample_distances[:count], axis=0)
    return nearest
