"""What the benchmarks of landmarks and of identification say of their rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from sherd.benchmark.identification import (
    IdentificationRow,
    identification_summary,
    identification_table,
)
from sherd.benchmark.skulls import (
    SkullRow,
    median_rows,
    skull_benchmark,
    skull_summary,
    skull_table,
)
from sherd.errors import MeshFileError

ROW = SkullRow(
    case="b whole by a",
    template="a",
    specimen="b",
    kind="whole",
    status="GOOD",
    chance=0.9,
    scale=1.0,
    errors=[0.1, 0.3, None],
    positions=[[1.0, 0.1, 0.0], [0.0, 1.3, 0.0], None],
    confidence=[0.9, 0.8, None],
    false=0,
    lost=1,
)


@pytest.fixture
def skulls(tmp_path):
    ball = trimesh.creation.icosphere(subdivisions=1)
    for name in "ab":
        np.savez(
            tmp_path / f"{name}.npz",
            vertices=ball.vertices, faces=ball.faces, landmarks=np.eye(3),
        )  # fmt: skip
    return tmp_path


def test_medians_of_templates_are_measured_like_single_ones(skulls) -> None:
    other = replace(
        ROW,
        case="b whole by c",
        template="c",
        positions=[[1.0, -0.1, 0.0], [0.0, 1.1, 0.0], [0.0, 0.0, 1.5]],
        errors=[0.1, 0.1, 0.5],
        lost=0,
    )
    (middle,) = median_rows([ROW, other], skulls)
    np.testing.assert_allclose([e for e in middle.errors if e is not None], [0.0, 0.2, 0.5])
    assert (middle.lost, middle.false, middle.specimen) == (0, 0, "b")
    summary = skull_summary([ROW, other])["whole"]
    assert (summary["cases"], summary["landmarks"], summary["lost"]) == (2, 5, 1)
    assert summary["median"] == pytest.approx(0.1)
    assert "median of templates, whole" in skull_table([ROW, other], [middle])


def test_a_folder_without_skulls_is_refused(skulls, tmp_path) -> None:
    (skulls / "b.npz").unlink()
    with pytest.raises(MeshFileError, match="fewer than two skulls"):
        skull_benchmark(skulls, tmp_path / "out")
    np.savez(skulls / "b.npz", vertices=np.eye(3))
    with pytest.raises(MeshFileError, match=r"b\.npz: cannot be read as a skull"):
        median_rows([ROW], skulls)


def test_identification_counts_what_is_right() -> None:
    right = IdentificationRow(
        case="x", own="cat.off", present=True, share=0.4, rank=1, best="cat.off", status="GOOD",
        also=["lion.off"], evidence_seconds=0.3, seconds=6.3, match_seconds=6.0,
    )  # fmt: skip
    second = replace(right, rank=2, best="lion.off", status="DOUBTFUL")
    small = replace(second, share=0.05)
    refused = replace(right, present=False, rank=0, best="", status="FOREIGN", match_seconds=0.0)
    fooled = replace(refused, best="lion.off", status="GOOD")
    summary = identification_summary([right, second, small, refused, fooled])
    assert (summary["parts"], summary["right"], summary["good"]) == (2, 0.5, 0.5)
    assert summary["wrong_called_good"] == 0.0
    assert (summary["first_by_evidence"], summary["second_or_first_by_evidence"]) == (0.5, 1.0)
    assert summary["without_own_called_good"] == 0.5
    assert summary["time_in_matches"] == pytest.approx(1.05)
    table = identification_table([right, second, refused, fooled])
    assert "cat.off, good, also lion.off" in table
    assert table.count("WRONG") == 2
