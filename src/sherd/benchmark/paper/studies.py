"""What the paper asks for in its last section, measured: parameters, descriptors, methods."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from sherd.arrays import Floats
from sherd.benchmark.paper.scenes import (
    DESCRIPTOR_NAMES,
    WORDS,
    Case,
    Scene,
    case_problem,
    creature_scene,
    extremity_cases,
    file_scene,
    named_descriptor,
    overlap_with_truth,
    random_cases,
    whole_region,
)
from sherd.energy.automatic import REGULARITIES, chosen_regularity
from sherd.energy.logistic import logistic_regions
from sherd.energy.problem import EnergyWeights, RegionProblem, region_problem
from sherd.energy.subspace import subspace_region
from sherd.locate import locate
from sherd.region.integral_matching import ball_starts
from sherd.results.locate_options import DescriptorName, LocateOptions, Method

__all__ = ["animation_scenes", "descriptor_study", "method_study", "parameter_study"]


BASIS_SIZE = 60
# Method with the descriptor it integrates; voting brings its own. The slow ones get one each.
METHODS: tuple[tuple[Method, DescriptorName], ...] = (
    ("voting", "shot"),
    ("logistic", "hks"),
    ("logistic", "shot"),
    ("subspace", "hks"),
    ("subspace", "shot"),
    ("exponential", "hks"),
    ("full", "hks"),
)
# Few signatures make few words: 160 words of eight heat kernel numbers split hairs.
VOCABULARY = {"hks": WORDS, "shot": 160}
POSES = ("walk", "gallop", "graze", "sit")


def parameter_study(*, vertex_count: int = 2000) -> dict[str, Any]:
    """IoU of the automatic lambda_r against every value of a grid, on 20 pairs.

    Five parts (head, tail, leg, two random balls) in each of four poses and individuals; the
    subspace method under HKS words.
    """
    rows = []
    for number, pose in enumerate(POSES):
        scene = creature_scene(vertex_count, pose=pose, individual=number + 1)
        cases = extremity_cases(scene)
        cases += random_cases(scene, 2, rng=np.random.default_rng(number))
        for case in cases:
            problem = case_problem(scene, case)
            rows.append({"pose": pose, "part": case.name} | _grid(scene, case, problem))
    table = np.array([row["iou_by_regularity"] for row in rows])
    automatic = np.array([row["iou_automatic"] for row in rows])
    return {
        "pairs": len(rows),
        "regularities": list(REGULARITIES),
        "mean_iou_by_regularity": table.mean(axis=0).tolist(),
        "mean_iou_best_per_pair": float(table.max(axis=1).mean()),
        "mean_iou_automatic": float(automatic.mean()),
        "rows": rows,
    }


def descriptor_study(scene: Scene) -> dict[str, Any]:
    """IoU under each descriptor on the same parts, with the subspace and with the sigmoid.

    "HKS, boundary kept" integrates the whole part; "HKS, raw" integrates the signatures
    themselves instead of soft words, as the paper does.
    """
    rows = []
    for case in extremity_cases(scene):
        problems = {
            f"{name} words": case_problem(scene, case, descriptor=name) for name in DESCRIPTOR_NAMES
        }
        problems["HKS, raw"] = _raw_problem(scene, case)
        open_cut = _ignoring_the_cut(case)
        problems["HKS words, boundary kept"] = case_problem(scene, open_cut)
        for name, problem in problems.items():
            rows.append({"part": case.name, "descriptor": name} | _both(scene, case, problem))
    names = list(dict.fromkeys(row["descriptor"] for row in rows))
    means = {
        name: {
            method: float(np.mean([row[method] for row in rows if row["descriptor"] == name]))
            for method in ("subspace", "sigmoid")
        }
        for name in names
    }
    return {"rows": rows, "means": means}


def method_study(scenes: dict[str, Scene]) -> dict[str, Any]:
    """IoU of head, tail and leg, cut from one pose and sought in another, by every method."""
    rows: list[dict[str, Any]] = []
    for animal, scene in scenes.items():
        for case in extremity_cases(scene):
            for method, descriptor in METHODS:
                options = (
                    LocateOptions()
                    if method == "voting"
                    else LocateOptions(
                        method=method,
                        descriptor=descriptor,
                        vocabulary_size=VOCABULARY[descriptor],
                    )
                )
                start = time.perf_counter()
                region = locate(scene.full, case.surface.mesh, options)
                rows.append(
                    {
                        "animal": animal,
                        "part": case.name,
                        "method": method,
                        "descriptor": "rotations" if method == "voting" else descriptor,
                        "iou": overlap_with_truth(scene, case, region.mask),
                        "iou_possible": _possible_overlap(scene, case),
                        "status": region.convergence.name,
                        "seconds": time.perf_counter() - start,
                    }
                )
    best = {
        f"{animal} {part}": max(
            row["iou"] for row in rows if row["animal"] == animal and row["part"] == part
        )
        for animal in scenes
        for part in ("head", "tail", "leg")
    }
    return {"rows": rows, "best": best}


def animation_scenes(folder: Path) -> dict[str, Scene]:
    """The horse of `folder`/animations/horse-poses in two of its poses, if it is there."""
    poses = folder / "animations" / "horse-poses"
    first, second = poses / "1.obj", poses / "5.obj"
    if not (first.exists() and second.exists()):
        return {}
    return {"horse-poses": file_scene(first, posed=second)}


def _possible_overlap(scene: Scene, case: Case) -> float:
    """The largest IoU of any region with the part's area: poses stretch skin, areas differ."""
    part = case.surface.mesh.area
    targets = [float(scene.full.vertex_areas[mask].sum()) for mask in (case.truth, case.twin)]
    return max(min(part, target) / max(part, target) for target in targets)


def _grid(scene: Scene, case: Case, problem: RegionProblem) -> dict[str, Any]:
    basis = scene.surface.basis.truncated(BASIS_SIZE)
    kept: list[Floats] = []

    def solve(candidate: RegionProblem) -> Sequence[Floats]:
        kept.append(subspace_region(candidate, basis).membership)
        return kept[-1:]

    choice = chosen_regularity(problem, solve)
    ious = [
        overlap_with_truth(scene, case, whole_region(scene, case, problem, membership))
        for membership in kept
    ]
    return {
        "iou_by_regularity": ious,
        "iou_automatic": ious[REGULARITIES.index(choice.regularity)],
        "automatic": choice.regularity,
    }


def _both(scene: Scene, case: Case, problem: RegionProblem) -> dict[str, float]:
    basis = scene.surface.basis
    starts = ball_starts(scene.full, problem.part_area)
    answers = {
        "subspace": subspace_region(problem, basis.truncated(BASIS_SIZE)).membership,
        "sigmoid": logistic_regions(problem, basis.truncated(80), starts)[0].membership,
    }
    return {
        name: overlap_with_truth(scene, case, whole_region(scene, case, problem, membership))
        for name, membership in answers.items()
    }


def _raw_problem(scene: Scene, case: Case) -> RegionProblem:
    """The signatures themselves, interior only, as in the paper."""
    descriptor = named_descriptor("HKS", scene, case)
    on_full, on_part = descriptor.describe(scene.surface), descriptor.describe(case.surface)
    areas = case.surface.mesh.vertex_areas * on_part.interior
    return region_problem(
        scene.full,
        full_descriptors=on_full.values,
        part_integral=on_part.values.T @ areas,
        part_area=float(areas.sum()),
        weights=EnergyWeights(regularity=case_problem(scene, case, words=WORDS).weights.regularity),
    )


def _ignoring_the_cut(case: Case) -> Case:
    far = np.full(len(case.surface.cut_distance), np.inf)
    return replace(case, surface=replace(case.surface, cut_distance=far))
