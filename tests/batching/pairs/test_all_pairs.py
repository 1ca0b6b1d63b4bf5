"""All pairs of a collection: what is not alike is not asked, and matrices hold what is known."""

from __future__ import annotations

import csv
from concurrent.futures import ThreadPoolExecutor
from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from sherd.batching.batch import BatchResult
from sherd.batching.collect import collect_batch
from sherd.batching.ledger.rows import PairRow
from sherd.batching.options import BatchOptions
from sherd.batching.pairs.all_pairs import all_pairs
from sherd.batching.pairs.matrix import (
    likeness_matrix,
    matrix_picture,
    shared_matrix,
)
from sherd.errors import InputError
from sherd.files.mesh_files import write_mesh
from sherd.result_folder import ResultFolder
from sherd.results.status import Status

NAMES = ("a", "b", "c")


@pytest.fixture
def asked(tmp_path, exhibit, monkeypatch) -> list[tuple[str, str]]:
    """Files of three shapes, of which c is like none; the pairs whose full question was asked."""
    pairs: list[tuple[str, str]] = []
    (tmp_path / "shapes").mkdir()
    for name in NAMES:
        write_mesh(exhibit.part, tmp_path / "shapes" / f"{name}.ply")

    def answer(first, second, options):
        pairs.append((first.original.name, second.original.name))
        return SimpleNamespace(
            first=first.original,
            second=second.original,
            status=Status.GOOD,
            advice="good",
            chance=0.9,
            shared_of_first=0.5,
            shared_of_second=0.25,
        )

    def write(result, folder, *, command, exports):
        assert command.startswith("sherd overlap ")
        with ResultFolder(folder) as output:
            output.add("report.html", "<p>a report</p>")
            return output.finish({})

    monkeypatch.setattr("sherd.batching.pairs.work.overlap", answer)
    monkeypatch.setattr("sherd.batching.pairs.work.write_report", write)
    monkeypatch.setattr(
        "sherd.batching.pairs.work._likeness",
        lambda task, read, unit: 0.2 if "c" in task.name else 0.8,
    )
    return pairs


def run(tmp_path, **more):
    with ThreadPoolExecutor(1) as here:
        return all_pairs(tmp_path / "shapes", tmp_path / "out", executor=here, **more)


def test_only_what_is_alike_is_asked_in_full_and_once(tmp_path, asked) -> None:
    result = run(tmp_path)
    assert asked == [("a.ply", "b.ply")]
    assert result.all_answered
    assert [(row.name, row.status) for row in result.rows] == [
        ("a--b", "good"), ("a--c", "foreign"), ("b--c", "foreign"),
    ]  # fmt: skip
    with (tmp_path / "out" / "shared_area.csv").open(newline="") as stream:
        table = list(csv.reader(stream))
    assert table == [
        ["shape", "a", "b", "c"], ["a", "1", "0.5", "0"], ["b", "0.25", "1", "0"],
        ["c", "0", "0", "1"],
    ]  # fmt: skip
    again = run(tmp_path)
    assert (again.computed, again.rows) == (0, result.rows)


def test_shards_of_pairs_are_collected(tmp_path, asked) -> None:
    run(tmp_path, batch_options=BatchOptions(shard="1/2"))
    half = collect_batch(tmp_path / "out")
    assert not isinstance(half, BatchResult)
    assert half.waiting == ("a--c",)
    run(tmp_path, batch_options=BatchOptions(shard="2/2"))
    assert collect_batch(tmp_path / "out").all_answered


def test_one_shape_is_no_collection(tmp_path) -> None:
    (tmp_path / "a.ply").write_text("")
    with pytest.raises(InputError, match="pairs need two"):
        all_pairs(tmp_path / "a.ply", tmp_path / "out")


def test_unknown_is_not_zero_and_large_matrices_stay_pictures(tmp_path) -> None:
    rows = [PairRow("a--b", "a.ply", "b.ply", status="failed")]
    shared, likeness = shared_matrix(NAMES, rows), likeness_matrix(NAMES, rows)
    assert np.isnan(shared[0, 1])
    assert (np.diag(shared) == 1).all()
    names = [f"shape number {k}" for k in range(120)]
    rows = [
        PairRow(f"{names[i]}--{names[j]}", "", "", status="good", likeness=1 / (j - i))
        for i, j in combinations(range(120), 2)
    ]
    (tmp_path / "matrix.png").write_bytes(
        matrix_picture(names, shared_matrix(names, rows), likeness_matrix(names, rows))
    )
    with Image.open(tmp_path / "matrix.png") as image:
        assert max(image.size) < 4000
    matrix_picture(NAMES, shared, likeness)
