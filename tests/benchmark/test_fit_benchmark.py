"""What `sherd bench fit` cuts, and the table it prints."""

from __future__ import annotations

import json

import numpy as np
import pytest

from sherd.benchmark.fit import benchmark
from sherd.benchmark.fit.baselines import has_libigl
from sherd.benchmark.fit.measurement import FitRow, Quality
from sherd.benchmark.fit.sources import fit_sources
from sherd.errors import MeshFileError
from sherd.mesh.surface_points import closest_points
from sherd.mesh.triangle_mesh import TriangleMesh
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
