"""What `sherd bench fit` cuts, and the table it prints."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.spatial import cKDTree

from sherd.benchmark.fit import benchmark, skull_fits
from sherd.benchmark.fit.baselines import has_libigl
from sherd.benchmark.fit.measurement import FitRow, Quality
from sherd.benchmark.fit.sources import fit_sources
from sherd.cli.bench.fit import fit_bench_command
from sherd.errors import MeshFileError, OptionError
from sherd.mesh.surface_points import closest_points, points_at_vertices
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.placement import Placement
from sherd.shapes import creature


@pytest.fixture(scope="module")
def animations(tmp_path_factory):
    folder = tmp_path_factory.mktemp("animations")
    rest, walk = creature(5000), creature(5000, pose="walk")
    np.savez(
        folder / "creature.npz", vertices=np.stack([rest.vertices, walk.vertices]), faces=rest.faces
    )
    return folder


@pytest.mark.parametrize("cut", ["0.5", "camera"])
def test_the_truth_lies_on_the_part_where_it_is_seen(animations, cut) -> None:
    (source,) = [each for each in fit_sources(animations, 3) if each.cut == cut]
    pair = source.load()
    off = closest_points(pair.part, pair.truth).positions(pair.part) - pair.truth
    far = np.linalg.norm(off, axis=1) / pair.full.length
    assert np.quantile(far[pair.seen], 0.95) < 0.01
    assert far[~pair.seen].mean() > 0.05
    share = pair.part.area / pair.full.area
    assert share == pytest.approx(0.5, abs=0.1) if cut == "0.5" else 0.1 < share < 0.5
    whole = TriangleMesh(pair.truth, pair.full.faces)
    assert whole.area == pytest.approx(pair.full.area, rel=0.1)


def test_rows_are_kept_and_a_run_goes_on(animations, tmp_path, monkeypatch) -> None:
    asked = []

    def measured(source, *, with_icp):
        asked.append(source.name)
        good = Quality(0.005, 0.05, 0.02, 0, 0.99, 0.0, 1.0)
        arap = Quality(0.01, 0.1, 0.03, 2, 0.9, 0.001, 2.0)
        tenths = tuple((10, k) for k in range(10))
        return FitRow(source.name, source.group, 2000, "good", good, arap, Quality(), tenths)

    monkeypatch.setattr(benchmark, "measured_fit", measured)
    first = benchmark.fit_benchmark(animations, tmp_path, limit=2)
    both = benchmark.fit_benchmark(animations, tmp_path, limit=3)
    assert len(asked) == 3
    assert both[:2] == first or np.isnan(both[0].icp.seen)
    assert len(json.loads((tmp_path / "fit.json").read_text())["rows"]) == 3
    table = benchmark.fit_table(both)
    assert "all, sherd fit (3):   0.50   5.00" in table
    assert "all, libigl ARAP, same map (3):   1.00  10.00" in table
    assert "nricp" not in table
    assert "40-50 %: 40 % of 30" in table
    assert ("libigl is not installed" in table) != has_libigl()


def test_a_folder_without_shapes_is_refused(tmp_path) -> None:
    with pytest.raises(MeshFileError, match=r"neither \.npz files nor folders"):
        fit_sources(tmp_path, 1)


@pytest.fixture
def skulls(tmp_path, match_result_of, exhibit, monkeypatch):
    """A folder of two equal skulls; what is matched to a half of one is exact."""
    match = match_result_of(exhibit)
    full = match.full
    for name in "ab":
        np.savez(
            tmp_path / f"{name}.npz",
            vertices=10 * full.vertices, faces=full.faces, landmarks=10 * full.vertices[::10],
        )  # fmt: skip

    def exact(template, part):
        places = cKDTree(template.vertices).query(part.vertices)[1]
        mask = np.isin(np.arange(template.vertex_count), places)
        best = Placement(
            mask=mask,
            membership=mask.astype(float),
            score=0.9,
            points=points_at_vertices(template, places),
            matched=np.ones(len(places), dtype=bool),
            confidence=np.ones(len(places)),
        )
        return replace(match, full=template, part=part, alternatives=(), best=best)

    monkeypatch.setattr(skull_fits, "rotated", lambda mesh, rng: mesh)
    monkeypatch.setattr(skull_fits, "match_with_fitted_scale", exact)
    return tmp_path


def test_landmarks_are_measured_on_the_half_and_beyond(skulls, tmp_path, monkeypatch) -> None:
    assert skull_fits.holds_skulls(skulls)
    (row,) = skull_fits.skull_fit_benchmark(skulls, tmp_path / "out", limit=1)
    size = 10 * np.sqrt(4 * np.pi)  # about that of the ball's area
    seen, errors = np.array(row.seen), np.array(row.fit)
    assert 0.3 < seen.mean() < 0.75
    assert errors[seen].mean() < 0.005 * size
    assert errors[~seen].mean() < 0.03 * size
    assert bool(row.arap) == has_libigl()
    monkeypatch.setattr(skull_fits, "match_with_fitted_scale", None)
    again = skull_fits.skull_fit_benchmark(skulls, tmp_path / "out", limit=1)
    assert again[0].fit == row.fit
    table = skull_fits.skull_fit_table([replace(row, fit=[1.0] * len(seen), arap=[])])
    assert "sherd fit (1): seen 1.000, hidden 1.000" in table
    assert "ARAP" not in table


def test_other_folders_are_not_taken_for_skulls(animations, tmp_path) -> None:
    assert not skull_fits.holds_skulls(animations)
    assert not skull_fits.holds_skulls(tmp_path / "nowhere")
    (tmp_path / "a.npz").write_bytes(b"no archive")
    with pytest.raises(MeshFileError, match=r"a\.npz: cannot be read"):
        skull_fits.holds_skulls(tmp_path)


def test_skulls_take_no_options_of_animations(skulls, tmp_path) -> None:
    for words in (["--poses", "1"], ["--cut", "0.5"]):
        asked = CliRunner().invoke(
            fit_bench_command, [str(skulls), "-o", str(tmp_path / "out"), *words]
        )
        assert asked.exit_code == 2
        assert "--poses and --cut are for animated shapes" in asked.output


def test_icp_without_its_tree_is_refused(animations, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(OptionError, match="needs rtree: pip install rtree"):
        benchmark.fit_benchmark(animations, tmp_path, with_icp=True)
