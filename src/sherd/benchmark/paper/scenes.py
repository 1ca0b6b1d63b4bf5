"""Shapes and parts of the founding paper's experiments: an animal, its head, tail and a leg."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.descriptors.field import Descriptor, SpectralSurface
from sherd.descriptors.heat_kernel_signature import HeatKernel, automatic_times
from sherd.descriptors.shot import Shot
from sherd.descriptors.wave_kernel_signature import WaveKernel
from sherd.drawing.camera import upward
from sherd.energy.cleanup import clean_region, grow_region
from sherd.energy.problem import EnergyWeights, RegionProblem
from sherd.errors import InfeasibleError, OptionError
from sherd.files.mesh_files import read_mesh
from sherd.mesh import topology
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.region.integral_matching import interior_question
from sherd.shapes.creature import creature, landmarks
from sherd.spectral.basis import eigenbasis
from sherd.spectral.geodesics import Geodesics
from sherd.spectral.sampling import decimate, farthest_point_sample

__all__ = [
    "DESCRIPTOR_NAMES",
    "Case",
    "Scene",
    "ball_case",
    "case_problem",
    "creature_scene",
    "extremity_cases",
    "file_scene",
    "named_descriptor",
    "overlap_with_truth",
    "random_cases",
    "whole_region",
]


# Eigenpairs for the descriptors: heat kernels at times near 1e-3 of the area need them.
RICH_BASIS = 300
# The body parts of figure 5 as shares of the animal's area.
PART_SHARES = {"head": 0.10, "tail": 0.05, "leg": 0.08}
# The ball in which head and tail of an unknown animal are told apart by their area.
THICKNESS_RADIUS = 0.25
HEAT_TIMES, WAVE_ENERGIES, SHOT_RADIUS = 8, 16, 0.07
WORDS = 64
DESCRIPTOR_NAMES = ("HKS", "WKS", "SHOT")
# Paper section 6 asks for the right lambda_r; this is the middle of the plateau that the
# parameter study finds (docs/paper.md).
DEFAULT_REGULARITY = 0.1


@dataclass(frozen=True, eq=False)
class Scene:
    """A full shape, and the pose that parts are cut from.

    Attributes
    ----------
    full
        Where parts are sought.
    posed
        The same faces in another pose, or `full` itself.
    surface
        `full` with its first eigenpairs.
    geodesics, posed_geodesics
        Of the two.
    seeds
        Vertex at the end of each body part, by name, with the vertex of its mirror twin or None.
    """

    full: TriangleMesh
    posed: TriangleMesh
    surface: SpectralSurface
    geodesics: Geodesics
    posed_geodesics: Geodesics
    seeds: dict[str, tuple[int, int | None]]


@dataclass(frozen=True, eq=False)
class Case:
    """A part with the true region.

    Attributes
    ----------
    name
        Of the body part.
    surface
        The part with its eigenpairs and distances to the cut.
    kept
        (n_part,) vertex of the full shape of each vertex of the part.
    truth
        (n,) bool.
    twin
        (n,) bool, the mirror image of the truth, which intrinsic descriptors cannot tell from it.
    """

    name: str
    surface: SpectralSurface
    kept: Ints
    truth: Bools
    twin: Bools


def creature_scene(vertex_count: int, *, pose: str = "walk", individual: int = 0) -> Scene:
    """The generated animal; below 5,000 vertices it is a decimated one with 5,000."""
    size = max(vertex_count, 5000)
    full, posed = (creature(size, pose=name, individual=individual) for name in ("stand", pose))
    marks = landmarks(full, individual=individual)
    if vertex_count < size:
        full, points = decimate(full, vertex_count)
        moved = points.positions(posed)
        marks = {
            name: int(np.linalg.norm(moved - posed.vertices[mark], axis=1).argmin())
            for name, mark in marks.items()
        }
        posed = full.with_vertices(moved)
    seeds = {
        "head": (marks["nose"], None),
        "tail": (marks["tail_tip"], None),
        "leg": (marks["left_front_hoof"], marks["right_front_hoof"]),
    }
    return _scene(full, posed, seeds)


def file_scene(path: Path, *, posed: Path | None = None) -> Scene:
    """An animal from a file; its head, tail and a leg are found by rules of thumb.

    The extremities are the farthest points. The four lowest are hooves, and of the others the
    one with the larger neighborhood is the head.

    Raises
    ------
    OptionError
        If the other pose does not have the same faces.
    """
    full = read_mesh(path)
    other = full if posed is None else read_mesh(posed)
    if not np.array_equal(full.faces, other.faces):
        raise OptionError(f"{posed} does not have the faces of {path}")
    return _scene(full, other, _found_seeds(full))


def extremity_cases(scene: Scene) -> list[Case]:
    """Head, tail and a leg, cut by geodesic balls from the other pose."""
    return [
        ball_case(scene, name, seed, PART_SHARES[name], twin=twin)
        for name, (seed, twin) in scene.seeds.items()
    ]


def random_cases(scene: Scene, count: int, *, rng: np.random.Generator) -> list[Case]:
    """Geodesic balls around random vertices, 6 to 25 % of the area each."""
    found: list[Case] = []
    while len(found) < count:
        seed = int(rng.integers(scene.full.vertex_count))
        share = float(rng.uniform(0.06, 0.25))
        found.append(ball_case(scene, f"ball {len(found) + 1}", seed, share))
    return found


def ball_case(scene: Scene, name: str, seed: int, share: float, *, twin: int | None = None) -> Case:
    """The geodesic ball with this share of the area around a vertex of the other pose.

    Raises
    ------
    InfeasibleError
        If the ball holds no face.
    """
    mask = _ball(scene, seed, share)
    faces = mask[scene.posed.faces].all(axis=1)
    if not faces.any():
        raise InfeasibleError(f"the ball around vertex {seed} holds no face; enlarge its share")
    mesh, kept = scene.posed.submesh(faces)
    truth = np.zeros(scene.full.vertex_count, dtype=bool)
    truth[kept] = True
    unit = scene.full.length
    cut = Geodesics(mesh).distances_to_set(mesh.boundary_vertices) / unit
    surface = SpectralSurface(mesh, eigenbasis(mesh, RICH_BASIS), unit, cut)
    twin_mask = truth if twin is None else _ball(scene, twin, share)
    return Case(name, surface, kept, truth, twin_mask)


def named_descriptor(name: str, scene: Scene, case: Case) -> Descriptor:
    """HKS, WKS or SHOT with scales that suit both shapes.

    Raises
    ------
    OptionError
        If the name is none of these.
    """
    unit = scene.full.area
    if name == "HKS":
        times = automatic_times([scene.surface, case.surface], HEAT_TIMES) / unit
        return HeatKernel(tuple(times.tolist()))
    if name == "SHOT":
        return Shot((SHOT_RADIUS,))
    if name == "WKS":
        bases = (scene.surface.basis, case.surface.basis)
        highest = min(float(basis.eigenvalues[-1]) for basis in bases) * unit
        # waves that reach no farther than half of the part's area lies from its cut, see WaveKernel
        order = np.argsort(case.surface.cut_distance, kind="stable")
        total = np.cumsum(case.surface.mesh.vertex_areas[order])
        deep = case.surface.cut_distance[order[int(np.searchsorted(total, 0.5 * total[-1]))]]
        lowest = 2 * np.pi**2 / max(float(deep), 1e-6) ** 2
        return WaveKernel.between(min(lowest, highest / 4), highest, WAVE_ENERGIES)
    raise OptionError(f"descriptor {name!r} is unknown; choose one of {DESCRIPTOR_NAMES}")


def case_problem(
    scene: Scene,
    case: Case,
    *,
    descriptor: str = "HKS",
    words: int = WORDS,
    regularity: float = DEFAULT_REGULARITY,
) -> RegionProblem:
    """The energy for the interior of a part under a vocabulary of descriptors."""
    return interior_question(
        scene.surface,
        case.surface,
        named_descriptor(descriptor, scene, case),
        vocabulary_size=words,
        weights=EnergyWeights(regularity=regularity),
        rng=np.random.default_rng(0),
    ).problem


def whole_region(scene: Scene, case: Case, problem: RegionProblem, membership: Floats) -> Bools:
    """Crisp region of the interior, cleaned, grown back to the area of the whole part."""
    full = scene.full
    adjacency = topology.adjacency(full.faces, full.vertex_count)
    core = clean_region(membership, full.vertex_areas, problem.part_area, adjacency=adjacency)
    distances = scene.geodesics.distances_to_set(np.flatnonzero(core))
    area = min(case.surface.mesh.area, full.area)
    return grow_region(core, distances, full.vertex_areas, area)


def overlap_with_truth(scene: Scene, case: Case, mask: Bools) -> float:
    """Area-weighted IoU with the true region or its mirror twin, whichever is larger."""
    areas = scene.full.vertex_areas
    return max(
        float(areas[mask & target].sum() / areas[mask | target].sum())
        for target in (case.truth, case.twin)
    )


def _scene(
    full: TriangleMesh, posed: TriangleMesh, seeds: dict[str, tuple[int, int | None]]
) -> Scene:
    geodesics = Geodesics(full)
    far = np.full(full.vertex_count, np.inf)
    if len(full.boundary_vertices):
        far = geodesics.distances_to_set(full.boundary_vertices) / full.length
    surface = SpectralSurface(full, eigenbasis(full, RICH_BASIS), full.length, far)
    posed_geodesics = geodesics if posed is full else Geodesics(posed)
    return Scene(full, posed, surface, geodesics, posed_geodesics, seeds)


def _ball(scene: Scene, seed: int, share: float) -> Bools:
    distance = scene.posed_geodesics.distances_from([seed])[0]
    order = np.argsort(distance, kind="stable")
    total = np.cumsum(scene.posed.vertex_areas[order])
    count = int(np.searchsorted(total, share * scene.posed.area))
    mask = np.zeros(len(distance), dtype=bool)
    mask[order[: count + 1]] = True
    return mask


def _found_seeds(full: TriangleMesh) -> dict[str, tuple[int, int | None]]:
    geodesics = Geodesics(full)
    center = int(np.linalg.norm(full.vertices - full.vertices.mean(axis=0), axis=1).argmin())
    away = int(geodesics.distances_from([center])[0].argmax())
    ends, distances = farthest_point_sample(geodesics, 6, start=away)
    height = full.vertices[ends] @ upward(full)
    low_first = np.argsort(height, kind="stable")
    hooves, others = low_first[:4], low_first[4:]
    near = distances < THICKNESS_RADIUS * full.length
    bulk = near.astype(np.float64) @ full.vertex_areas
    head, tail = others[np.argsort(-bulk[others], kind="stable")]
    leg = hooves[0]
    # left and right hoof are nearer to each other's place in the body: the same distance to the
    # head; hind and front hooves differ in it
    to_head = distances[head, ends[hooves]]
    twin = hooves[1:][np.abs(to_head[1:] - to_head[0]).argmin()]
    return {
        "head": (int(ends[head]), None),
        "tail": (int(ends[tail]), None),
        "leg": (int(ends[leg]), int(ends[twin])),
    }
