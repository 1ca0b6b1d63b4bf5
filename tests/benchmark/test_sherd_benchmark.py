"""The benchmark of rigid puzzles: what is counted, with answers that are known."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from sherd.benchmark.puzzle import sherds
from sherd.benchmark.puzzle.sherds import FOREIGN, GIVEN, sherd_benchmark, sherd_table
from sherd.cli.main import main
from sherd.errors import OptionError
from sherd.shapes import vase_sherds


@pytest.fixture
def asked(monkeypatch) -> list[int]:
    """The first sherd lies where it belongs, the second a tenth beside it, the rest nowhere.

    But for the last, which is foreign.
    """
    calls: list[int] = []
    real = vase_sherds

    def answered(full, pieces, *, rigid: bool) -> SimpleNamespace:
        assert rigid
        calls.append(len(pieces))
        beside = np.eye(4)
        beside[0, 3] = 0.1
        own = real(7, vertex_count=5000, seed=len(calls) - 1)
        motions = [own[0].transform, beside @ own[1].transform]
        motions += [None] * (len(pieces) - 3) + [np.eye(4)]
        found = [SimpleNamespace(placed=each is not None, transform=each) for each in motions]
        return SimpleNamespace(pieces=found)

    monkeypatch.setattr(sherds, "KINDS", {"clean": {"vertex_count": 5000}})
    monkeypatch.setattr(sherds, "assemble", answered)
    return calls


def test_vases_are_measured_and_kept(asked, tmp_path) -> None:
    (row,) = sherd_benchmark(tmp_path, vases=1)
    assert (row.own, row.placed, row.wrong) == (GIVEN, 1, 1)
    assert (row.foreign, row.foreign_placed) == (FOREIGN, 1)
    assert row.errors == pytest.approx([0.0], abs=1e-9)
    assert row.angles == pytest.approx([0.0], abs=1e-4)
    assert sherd_benchmark(tmp_path, vases=1) == [row]
    assert asked == [GIVEN + FOREIGN]
    assert json.loads((tmp_path / "sherds.json").read_text())["rows"]
    assert "1/4" in sherd_table([row])


def test_unknown_kinds_are_refused(tmp_path) -> None:
    with pytest.raises(OptionError, match="glazed"):
        sherd_benchmark(tmp_path, kinds=["glazed"])
    refused = CliRunner().invoke(main, ["bench", "sherds", "-o", str(tmp_path), "--vases", "0"])
    assert refused.exit_code == 2
    assert "vases" in refused.output
