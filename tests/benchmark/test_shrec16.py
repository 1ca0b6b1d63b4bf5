"""The SHREC'16 benchmark of match: its measures, its files, its resumption."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from sherd.benchmark.datasets.pairs import BenchmarkSettings
from sherd.benchmark.datasets.shrec16 import shrec16_set
from sherd.benchmark.match import benchmark as runner_of_match
from sherd.benchmark.match.benchmark import match_benchmark
from sherd.benchmark.match.summary import summary_table
from sherd.benchmark.metrics import (
    cumulative_curve,
    region_overlap,
    vertex_mask,
)
from sherd.errors import OptionError
from sherd.files.mesh_files import write_mesh
from sherd.mesh.surface_points import SurfacePoints, points_at_vertices
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes.creature import creature
from sherd.shapes.fragment import Fragment, cut_by_ball, whole

# Half an edge of the animal, in sqrt(area); 0.004 was measured, as a mesh and as points.
GOOD = 0.008


@pytest.fixture(scope="module")
def sphere() -> TriangleMesh:
    ball = trimesh.creation.icosphere(subdivisions=4)
    return TriangleMesh(ball.vertices, ball.faces)


def test_overlap_and_curve_by_hand(sphere: TriangleMesh) -> None:
    upper, right = sphere.vertices[:, 2] > 0, sphere.vertices[:, 0] > 0
    assert region_overlap(sphere, upper, upper) == 1.0
    assert abs(region_overlap(sphere, upper, right) - 1 / 3) < 0.02
    assert np.isnan(region_overlap(sphere, upper & False, upper & False))
    hit = vertex_mask(sphere, points_at_vertices(sphere, [3, 5]))
    assert np.flatnonzero(hit).tolist() == [3, 5]
    errors = np.array([0.0, 0.1, 0.2, 0.3])
    assert cumulative_curve(errors, np.array([0.0, 0.15, 0.3])).tolist() == [0.25, 0.5, 1.0]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data set in the layout of SHREC'16, with an eighth of a generated animal as the part."""
    home = tmp_path_factory.mktemp("data")
    full = creature(5_000)
    posed = whole(creature(5_000, pose="walk"), full)
    part = cut_by_ball(posed, 50, 0.5)
    (home / "null").mkdir()
    (home / "cuts").mkdir()
    write_mesh(full, home / "null" / "animal.off")
    name = home / "cuts" / "cuts_animal_shape_1.off"
    write_mesh(part.mesh, name)
    _write_truth(name.with_suffix(".baryc_gt"), part)
    return home


def _write_truth(path: Path, part: Fragment) -> None:
    truth: SurfacePoints = part.truth
    table = np.column_stack([truth.faces + 1, truth.barycentric])
    np.savetxt(path, table, fmt=["%d", "%.12f", "%.12f", "%.12f"])


def test_a_run_measures_writes_and_resumes(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pairs = shrec16_set(folder, BenchmarkSettings(rotate=True), kinds=("cuts",))
    document = match_benchmark(pairs, tmp_path)
    (row,) = document["rows"]
    assert row["pair"] == "cuts_animal_shape_1"
    assert row["mean"] < GOOD
    assert row["near"] > 0.99
    # a row of vertices along the cut is 0.05 of so small a region: 0.955 and 0.933 were measured
    assert row["iou"] > 0.93
    assert row["iou_vertices"] > 0.9
    assert row["flips"] is None  # no mirror map was given
    assert row["recognized"] is None  # every vertex has a place
    assert document["totals"]["cuts"]["pairs"] == 1
    assert document["settings"]["rotate"] is True
    stages = document["totals"]["cuts"]["stages"]
    assert sum(stages.values()) == pytest.approx(sum(row["seconds"].values()))
    assert "cuts: 1 pairs" in summary_table(document)
    assert json.loads((tmp_path / "bench.json").read_text()) == document

    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("measured again")

    monkeypatch.setattr(runner_of_match, "measured", refuse)
    again = match_benchmark(pairs, tmp_path)
    assert again == document
    # other settings are another measurement
    with pytest.raises(AssertionError, match="measured again"):
        match_benchmark(shrec16_set(folder, kinds=("cuts",)), tmp_path)
    _page_shows(document, tmp_path)


def test_parts_are_measured_as_points_alone(folder: Path, tmp_path: Path) -> None:
    settings = BenchmarkSettings(rotate=True, points=True)
    pairs = shrec16_set(folder, settings, kinds=("cuts",))
    document = match_benchmark(pairs, tmp_path)
    assert document["rows"][0]["mean"] < GOOD
    assert document["rows"][0]["coverage"] > 0.98
    assert "parts as their points alone" in (tmp_path / "bench.html").read_text(encoding="utf-8")


def _page_shows(document: dict[str, Any], output: Path) -> None:
    page = (output / "bench.html").read_text(encoding="utf-8")
    for words in ("region IoU (dense)", "region IoU (vertices hit)", "Seconds by stage", "anchors"):
        assert words in page
    assert "flips" not in page  # nothing is known of them
    assert f"{100 * document['rows'][0]['mean']:.2f}</td>" in page
    assert page.count("data:image/png") == 2


def test_wrong_settings_are_refused(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="kinds"):
        shrec16_set(folder, kinds=("scans",))
    with pytest.raises(OptionError, match="jobs is 0"):
        match_benchmark(shrec16_set(folder, kinds=("cuts",)), tmp_path, jobs=0)
