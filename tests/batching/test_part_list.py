"""Parts from folders, patterns, files and tables; each has one name."""

from __future__ import annotations

from pathlib import Path

import pytest

from sherd.batching.parts import BatchPart, Share, batch_parts, shared_list
from sherd.cli.batch.part_table import parts_of_table
from sherd.errors import InputError


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name in ("s/b.ply", "s/a.ply", "s/arm/a.PLY", "s/c.obj", "s/c.ply", "s/.x.ply", "s/t.csv"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("")
    return tmp_path


def names(source) -> list[str]:
    return [part.name for part in batch_parts(source)]


def test_names_are_the_files_and_differ(folder) -> None:
    assert names("s") == ["a", "arm__a", "b", "c.obj", "c.ply"]
    assert names(folder / "s") == names("s")
    assert names("s/*.ply") == ["a", "b", "c"]
    assert names("s/**/*.[pP][lL][yY]") == ["a", "arm__a", "b", "c"]
    assert names("s/b.ply") == ["b"]
    assert names(["s/b.ply", BatchPart("s/a.ply", name="first")]) == ["b", "first"]


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("nowhere", "no such folder or file"),
        ("s/*.stl", "no file has such a name"),
        ("empty", "holds no"),
        ([], "no parts were given"),
        (
            [BatchPart("s/b.ply", name="b"), BatchPart("s/a.ply", name="b")],
            "would both be called b",
        ),
        ([BatchPart("s/a.ply", name="../b")], "no name of a folder"),
        ([BatchPart("s/a.ply", name=".b")], "no name of a folder"),
    ],
)
def test_what_is_no_list_of_parts_is_refused(folder, source, said) -> None:
    (folder / "empty").mkdir()
    with pytest.raises(InputError, match=said):
        batch_parts(source)


@pytest.mark.parametrize("count", [1, 3, 7])
def test_shares_are_all_parts_once(count) -> None:
    parts = [BatchPart(Path(f"{k}.ply"), name=str(k)) for k in range(10)]
    shares = [shared_list(parts, Share(k + 1, count)) for k in range(count)]
    assert sorted(p.name for share in shares for p in share) == [str(k) for k in range(10)]
    assert max(map(len, shares)) - min(map(len, shares)) <= 1


def test_a_table_says_where_a_part_belongs_and_what_is_known(folder) -> None:
    (folder / "pairs.csv").write_text("part_vertex,full_vertex\n3,5\n")
    (folder / "ignored.csv").write_text("part_vertex\n7\n")
    table = folder / "table.csv"
    table.write_text(
        "part,name,full,landmarks,ignore\n"
        "s/a.ply,first,cat.ply,pairs.csv,\n"
        "s/b.ply,,,,ignored.csv\n"
    )
    first, second = parts_of_table(table)
    assert (first.name, first.full, first.landmarks) == ("first", "cat.ply", ((3, 5),))
    assert (second.name, second.full, second.ignore) == ("", None, (7,))
    assert first.words == ("--landmarks", str(folder / "pairs.csv"))
    assert names([first, second]) == ["b", "first"]
    for text, said in (
        ("file\na.ply\n", "has a column 'file'"),
        ("name\na\n", "has no column 'part'"),
        ("part,name\n,a\n", "row 2 names no part"),
    ):
        table.write_text(text)
        with pytest.raises(InputError, match=said):
            parts_of_table(table)
