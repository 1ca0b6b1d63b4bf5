from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from sherd.benchmark.paper import figures as paper_figures
from sherd.benchmark.paper import run as paper
from sherd.benchmark.paper import scenes as paper_scenes
from sherd.benchmark.paper import studies as paper_studies
from sherd.benchmark.paper import timing as paper_timing
from sherd.benchmark.paper.witness import (
    clarabel_dense,
    piqp_all_vertex,
    piqp_dense,
    witnesses_installed,
)
from sherd.energy.all_vertices import full_membership_quadratic
from sherd.energy.solvers import active_set
from sherd.energy.structured import solve_structured
from sherd.energy.subspace import basis_rows, membership_quadratic
from sherd.errors import InfeasibleError, OptionError
from sherd.files.mesh_files import write_mesh

pytest.importorskip("matplotlib")

SMALL = 700


@pytest.fixture(scope="module")
def scene() -> paper_scenes.Scene:
    return paper_scenes.creature_scene(SMALL)


@pytest.fixture(scope="module")
def reproduced(tmp_path_factory) -> tuple[dict, Path]:
    """The whole command on a small animal, with two sizes where the paper has eight."""
    out = tmp_path_factory.mktemp("paper")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(paper, "PAPER_VERTICES", SMALL)
        patch.setattr(paper_figures, "BASIS_SIZES", (15, 60, 150))
        patch.setattr(paper_timing, "SIZES", (15, 40))
        patch.setattr(paper_timing, "REPEATS", 1)
        result = paper.paper_figures(out, quick=True)
    return result, out


def test_every_figure_and_its_numbers_are_there(reproduced) -> None:
    result, out = reproduced
    names = {path.name for path in out.glob("*.png")}
    parts = {f"figure5_{part}.png" for part in ("head", "tail", "leg")}
    assert {f"figure{number}.png" for number in (1, 2, 3, 4, 6, 7)} | parts <= names
    stored = json.loads((out / "paper.json").read_text())
    assert stored["figure4"]["mean"] == pytest.approx(result["figure4"]["mean"])
    page = (out / "paper.html").read_text()
    assert page.count("<img ") == len(names)
    for number in range(1, 8):
        assert f"Figure{number}" in page
    # self-contained; the letters of an image may spell anything
    assert "http" not in re.sub(r"data:image/png;base64,[^\"]*", "", page)
    assert "leg" in paper.paper_summary(result)


def test_heat_kernel_error_stays_near_the_cut(reproduced) -> None:
    for row in reproduced[0]["figure2"]["times"][1:3]:
        assert row["mean_error_within_2_roots"] > 5 * row["mean_error_beyond_2_roots"]
        assert row["mean_error_beyond_2_roots"] < 0.05


def test_regularity_smooths(reproduced) -> None:
    rows = [row for row in reproduced[0]["figure3"]["rows"] if row["method"] == "all vertices"]
    variations = [row["total_variation"] for row in rows]
    assert variations[0] > variations[1] > variations[2]
    assert rows[1]["softness"] < rows[2]["softness"]


def test_subspace_tends_to_all_vertices(reproduced) -> None:
    means = reproduced[0]["figure4"]["mean"]
    assert means[0] > means[1] > means[2]
    assert means[1] < 0.05
    for row in reproduced[0]["figure5"]["rows"]:
        assert row["difference"] < 0.05
        assert max(row["iou all vertices"], row["iou subspace"]) > 0.75


def test_solvers_agree_in_the_table(reproduced) -> None:
    table = reproduced[0]["figure6"]
    assert max(table["augmented_lagrangian_error"]) < 0.02
    assert max(table["active_set_relative_objective_gap"]) < 1e-6
    assert table["sigmoid_energy"][1] < table["sigmoid_energy"][0]


def test_parts_have_the_wanted_area_and_a_twin(scene) -> None:
    areas = scene.full.vertex_areas
    cases = {case.name: case for case in paper_scenes.extremity_cases(scene)}
    for name, share in paper_scenes.PART_SHARES.items():
        case = cases[name]
        assert areas[case.truth].sum() == pytest.approx(share * areas.sum(), rel=0.15)
        assert len(case.kept) == case.surface.mesh.vertex_count
        assert paper_scenes.overlap_with_truth(scene, case, case.truth) == 1.0
    leg = cases["leg"]
    assert not (leg.truth & leg.twin).any()
    assert paper_scenes.overlap_with_truth(scene, leg, leg.twin) == 1.0
    with pytest.raises(InfeasibleError, match="no face"):
        paper_scenes.ball_case(scene, "crumb", 0, 1e-9)
    with pytest.raises(OptionError, match="HKS"):
        paper_scenes.named_descriptor("color", scene, leg)


def test_extremities_of_an_unknown_animal_are_found(scene, tmp_path) -> None:
    write_mesh(scene.full, tmp_path / "animal.ply")
    found = paper_scenes.file_scene(tmp_path / "animal.ply")
    for name in ("head", "tail"):
        seed = found.seeds[name][0]
        gap = scene.geodesics.distances_from([scene.seeds[name][0]])[0][seed]
        assert gap < 0.25 * scene.full.length
    hoof, twin = found.seeds["leg"]
    # left and right are y; both are front hooves or both hind ones
    assert scene.full.vertices[hoof, 0] == pytest.approx(
        scene.full.vertices[twin, 0], abs=0.25
    )  # mid-stride
    assert scene.full.vertices[hoof, 1] * scene.full.vertices[twin, 1] < 0


def test_automatic_regularity_is_near_the_best(scene) -> None:
    case = paper_scenes.extremity_cases(scene)[1]
    row = paper_studies._grid(scene, case, paper_scenes.case_problem(scene, case))
    assert row["iou_automatic"] >= max(row["iou_by_regularity"]) - 0.1


@pytest.mark.skipif(not witnesses_installed(), reason="optional extra witness")
def test_witnesses_reach_the_same_objective(scene) -> None:
    case = paper_scenes.extremity_cases(scene)[2]
    problem = paper_scenes.case_problem(scene, case)
    basis = scene.surface.basis.truncated(30)
    ones = np.ones(problem.vertex_count)
    program = membership_quadratic(problem, basis_rows(problem, basis), ones)
    own = active_set(program).objective
    for witness in (piqp_dense, clarabel_dense):
        assert program.value(witness(program)) == pytest.approx(own, rel=1e-6)
    whole = full_membership_quadratic(problem, ones)
    own = solve_structured(whole).objective
    assert whole.value(piqp_all_vertex(whole)) == pytest.approx(own, rel=1e-6)


def test_method_table(scene, monkeypatch) -> None:
    monkeypatch.setattr(paper_studies, "METHODS", (("subspace", "hks"),))
    table = paper_studies.method_study({"animal": scene})
    assert [row["part"] for row in table["rows"]] == ["head", "tail", "leg"]
    for row in table["rows"]:
        # a mask meets an area to half a vertex, up to 3 % of a small part here
        assert 0 <= row["iou"] <= row["iou_possible"] + 0.03
        assert row["iou_possible"] <= 1
    assert table["best"]["animal tail"] > 0.7
