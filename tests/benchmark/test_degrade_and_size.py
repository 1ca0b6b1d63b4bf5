"""The degradation benchmark resumes; one size is measured from files to report."""

from __future__ import annotations

import json

import pytest

from sherd.benchmark import degrade, size
from sherd.benchmark.degrade import KINDS, degrade_benchmark, degrade_table


def test_every_kind_starts_clean_and_the_run_resumes(tmp_path, monkeypatch) -> None:
    """Matching is replaced by the truth; only the course of the run is looked at."""
    asked = []

    def measured(kind, level, part, template, distances):
        asked.append((kind, level, part.mesh.vertex_count))
        return degrade.DegradeRow(kind, level, 1.0 + level, 1.0, None, 0.9, 0.1)

    monkeypatch.setattr(degrade, "_measured", measured)
    kinds = ("noise", "clutter", "points")
    rows = degrade_benchmark(tmp_path, kinds=kinds, vertex_count=5000)
    assert [(row.kind, row.level) for row in rows] == [
        (kind, level) for kind in kinds for level in KINDS[kind].levels
    ]
    clean = {count for kind, level, count in asked if level == KINDS[kind].levels[0]}
    assert len(clean) == 1
    assert {path.name for path in tmp_path.glob("*.png")} == {f"degrade-{k}.png" for k in kinds}
    assert degrade_table(rows).count("\n") == len(rows)
    content = json.loads((tmp_path / "degrade.json").read_text())
    content["rows"] = content["rows"][:4]
    (tmp_path / "degrade.json").write_text(json.dumps(content))
    asked.clear()
    again = degrade_benchmark(tmp_path, kinds=kinds, vertex_count=5000)
    assert len(asked) == len(rows) - 4
    assert {(row.kind, row.level) for row in again} == {(row.kind, row.level) for row in rows}


def test_one_size_is_measured_from_files_to_report(tmp_path) -> None:
    (row,) = size.size_benchmark(tmp_path, sizes=[2000])
    assert row.full_vertices == pytest.approx(2000, rel=0.05)
    assert 0.2 < row.part_vertices / row.full_vertices < 0.4
    assert 0.05 < row.peak_gigabytes < 4
    assert 0 < row.cpu_seconds
    assert row.error < 8
    assert "confidence" in row.stages
    assert (tmp_path / "size.png").stat().st_size > 1000
