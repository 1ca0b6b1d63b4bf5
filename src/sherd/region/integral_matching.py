"""Locating as the paper does: by the integral of descriptors over the part's interior."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sherd.arrays import Bools, Floats
from sherd.descriptors.field import Descriptor, DescriptorField, SpectralSurface
from sherd.descriptors.heat_kernel_signature import HeatKernel, automatic_times
from sherd.descriptors.shot import Shot
from sherd.descriptors.vocabulary import learn_vocabulary
from sherd.descriptors.wave_kernel_signature import WaveKernel
from sherd.energy.all_vertices import full_region
from sherd.energy.automatic import REGULARITIES, chosen_regularity
from sherd.energy.cleanup import clean_region, grow_region, raised_to_area
from sherd.energy.convergence import Convergence
from sherd.energy.exponential import exponential_regions
from sherd.energy.logistic import logistic_regions
from sherd.energy.mumford_shah import EnergyTerms, data_term
from sherd.energy.problem import EnergyWeights, RegionProblem, region_problem
from sherd.energy.subspace import subspace_region
from sherd.errors import OptionError
from sherd.mesh import topology
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import Stages
from sherd.region.found import Found
from sherd.region.weights import chosen_weights
from sherd.results.locate_options import SOLVERS, LocateOptions
from sherd.results.placement import Placement
from sherd.spectral.basis import EigenBasis
from sherd.spectral.geodesics import Geodesics
from sherd.spectral.sampling import farthest_point_sample
from sherd.surface.described import DescribedSurface

__all__ = ["InteriorQuestion", "ball_starts", "interior_question", "locate_by_integrals"]


# Heat kernels at times near 1e-3 of the area need about this many eigenpairs (Weyl: lambda_k is
# near 4 pi k / area, and exp(-lambda_k t) must be small).
DESCRIPTOR_BASIS = 300
HEAT_TIMES = 8
WAVE_ENERGIES = 16
# SHOT at one radius, the width of a limb; a cut spoils it less than beyond its whole radius.
SHOT_RADIUS = 0.07
# Least share of the part's area that is kept as interior: with less, the integral is noise. The
# vertices deepest inside are taken then.
LEAST_INTERIOR = 0.2
# Balls around farthest points: spaced below their own radius for any part above 5 % of the area.
START_COUNT = 24
# Candidates for lambda_r where the solver is not as fast as the subspace's.
FEW_REGULARITIES = (0.03, 0.1, 0.3)
# Two placements that share this much of one are the same.
SAME_PLACE = 0.5


@dataclass(frozen=True, eq=False)
class InteriorQuestion:
    """The energy for the part's interior, and the way back to the whole part.

    Attributes
    ----------
    problem
        The energy on the full shape.
    interior
        (n_part,) bool, the vertices of the part that were integrated.
    """

    problem: RegionProblem
    interior: Bools


@dataclass(frozen=True, eq=False)
class _Answer:
    membership: Floats
    phase_field: Floats
    energy: EnergyTerms
    status: Convergence


def interior_question(
    full: SpectralSurface,
    part: SpectralSurface,
    descriptor: Descriptor,
    *,
    vocabulary_size: int,
    weights: EnergyWeights,
    rng: np.random.Generator,
) -> InteriorQuestion:
    """Integrate soft words of a descriptor over the vertices of the part that the cut left alone.

    Numbers are standardized by their spread on the full shape, so that all weigh alike; the
    words are learned on the full shape.
    """
    full_field, part_field = descriptor.describe(full), descriptor.describe(part)
    center = full_field.values.mean(axis=0)
    # a constant number says nothing; any scale will do
    scale = np.maximum(full_field.values.std(axis=0), 1e-12 * (1 + np.abs(center)))
    standard_full = (full_field.values - center) / scale
    standard_part = (part_field.values - center) / scale
    words = learn_vocabulary(standard_full, min(vocabulary_size, full.mesh.vertex_count), rng=rng)
    interior = _interior(part_field, part)
    areas = part.mesh.vertex_areas * interior
    problem = region_problem(
        full.mesh,
        full_descriptors=words.histograms(standard_full),
        part_integral=words.histograms(standard_part).T @ areas,
        part_area=min(float(areas.sum()), full.mesh.area),
        weights=weights,
    )
    return InteriorQuestion(problem, interior)


def ball_starts(mesh: TriangleMesh, area: float, *, count: int = START_COUNT) -> Floats:
    """Geodesic balls of the given area around farthest points, (count, n) float 0 or 1."""
    used = mesh.used_vertices
    first = int(used[np.linalg.norm(mesh.vertices[used], axis=1).argmax()])
    _, distances = farthest_point_sample(Geodesics(mesh), min(count, len(used)), start=first)
    order = np.argsort(distances, axis=1, kind="stable")
    total = np.cumsum(mesh.vertex_areas[order], axis=1)
    starts = np.zeros_like(distances)
    np.put_along_axis(starts, order, (total <= area).astype(float), axis=1)
    return starts


def locate_by_integrals(
    described_full: DescribedSurface,
    described_part: DescribedSurface,
    options: LocateOptions,
    stages: Stages,
) -> Found:
    """Locate the part on the full shape; see :func:`sherd.locate`."""
    full, part = described_full.mesh, described_part.mesh
    with stages("eigenbasis"):
        size = max(options.basis_size, DESCRIPTOR_BASIS if options.descriptor != "shot" else 0)
        rich = described_full.basis(size)
        surfaces = (
            SpectralSurface(full, rich, full.length, described_full.cut_distance),
            SpectralSurface(
                part, described_part.basis(size), full.length, described_part.cut_distance
            ),
        )
        basis = rich.truncated(options.basis_size)
    with stages("descriptors"):
        question = interior_question(
            *surfaces,
            _descriptor(options, *surfaces),
            vocabulary_size=options.vocabulary_size or 1,
            weights=chosen_weights(options, basis, min(part.area, full.area)),
            rng=np.random.default_rng(options.seed),
        )
    with stages("region"):
        problem, answers = _answered(question.problem, full, basis, options)
        question = replace(question, problem=problem)
    with stages("growth"):
        geodesics = described_full.geodesics
        masks = [_whole(answer, question.problem, full, part.area, geodesics) for answer in answers]
    best, mask = answers[0], masks[0]
    shares = [float(full.vertex_areas[mask & other].sum()) for other in masks]
    others = tuple(
        Placement(mask=other, membership=answer.membership, score=_score(question, answer))
        for answer, other, shared in zip(answers, masks, shares, strict=True)
        if shared < SAME_PLACE * float(full.vertex_areas[mask].sum())
    )
    whole = raised_to_area(best.membership, full.vertex_areas, min(part.area, full.area))
    return Found(
        best=Placement(mask=mask, membership=whole, score=_score(question, best)),
        alternatives=others,
        phase_field=best.phase_field,
        energy=best.energy,
        convergence=best.status,
        weights=question.problem.weights,
    )


def _descriptor(options: LocateOptions, full: SpectralSurface, part: SpectralSurface) -> Descriptor:
    unit = full.length**2
    if options.descriptor == "shot":
        return Shot((SHOT_RADIUS,))
    if options.descriptor == "hks":
        times = automatic_times([full, part], HEAT_TIMES) / unit
        return HeatKernel(tuple(times.tolist()))
    if options.descriptor == "wks":
        highest = min(s.basis.eigenvalues[-1] for s in (full, part)) * unit
        # waves longer than the part see only its outline: 4 pi is the scale of lambda_1 * area
        lowest = 4 * np.pi * full.mesh.area / part.mesh.area
        return WaveKernel.between(min(lowest, highest / 4), highest, WAVE_ENERGIES)
    raise OptionError(f"descriptor {options.descriptor!r} is unknown")


def _interior(field: DescriptorField, part: SpectralSurface) -> Bools:
    areas, interior = part.mesh.vertex_areas, field.interior
    if areas[interior].sum() >= LEAST_INTERIOR * part.mesh.area:
        return interior
    order = np.argsort(-part.cut_distance, kind="stable")
    total = np.cumsum(areas[order])
    deepest = np.zeros(len(areas), dtype=bool)
    deepest[order[: int(np.searchsorted(total, LEAST_INTERIOR * total[-1])) + 1]] = True
    return deepest


def _answered(
    problem: RegionProblem, full: TriangleMesh, basis: EigenBasis, options: LocateOptions
) -> tuple[RegionProblem, list[_Answer]]:
    """The answers, best first; under the lambda_r of the best crisp region if it was left open."""
    many_starts = options.method in {"logistic", "exponential"}
    starts = ball_starts(full, problem.part_area) if many_starts else np.empty((0, 0))
    if options.regularity is not None:
        return problem, _solve(problem, basis, starts, options)
    found: list[list[_Answer]] = []

    def solve(candidate: RegionProblem) -> list[Floats]:
        found.append(_solve(candidate, basis, starts, options))
        return [answer.membership for answer in found[-1]]

    candidates = REGULARITIES if options.method == "subspace" else FEW_REGULARITIES
    choice = chosen_regularity(problem, solve, candidates=candidates)
    answers = found[candidates.index(choice.regularity)]
    answers.insert(0, answers.pop(choice.answer))
    return problem.with_weights(replace(problem.weights, regularity=choice.regularity)), answers


def _solve(
    problem: RegionProblem, basis: EigenBasis, starts: Floats, options: LocateOptions
) -> list[_Answer]:
    """Answers of least energy first; the convex methods have one."""
    if options.method == "subspace":
        answer = subspace_region(
            problem, basis, solver=options.solver or SOLVERS[0], iterations=options.iterations or 1
        )
        return [_Answer(answer.membership, answer.phase_field, answer.energy, answer.status)]
    if options.method == "full":
        whole = full_region(problem, iterations=options.iterations or 1)
        return [_Answer(whole.membership, whole.phase_field, whole.energy, whole.status)]
    if options.method == "logistic":
        return [
            _Answer(region.membership, region.phase_field, region.energy, region.status)
            for region in logistic_regions(problem, basis, starts)
        ]
    if options.method == "exponential":
        return [
            _Answer(region.membership, region.phase_field, region.energy, region.status)
            for region in exponential_regions(problem, basis, starts)
        ]
    raise OptionError(f"method {options.method!r} does not match integrals")


def _whole(
    answer: _Answer,
    problem: RegionProblem,
    full: TriangleMesh,
    part_area: float,
    geodesics: Geodesics,
) -> Bools:
    """Crisp region of the interior, grown back over the band that was left out."""
    adjacency = topology.adjacency(full.faces, full.vertex_count)
    areas = full.vertex_areas
    core = clean_region(answer.membership, areas, problem.part_area, adjacency=adjacency)
    distances = geodesics.distances_to_set(np.flatnonzero(core))
    return grow_region(core, distances, areas, min(part_area, full.area))


def _score(question: InteriorQuestion, answer: _Answer) -> float:
    """1 minus the relative residual of the descriptor integral, at least 0."""
    return max(0.0, 1.0 - float(np.sqrt(data_term(question.problem, answer.membership))))
