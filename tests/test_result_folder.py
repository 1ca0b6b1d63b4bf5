"""What a result may replace in its folder: the older result of the same question, nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from sherd.errors import OutputError
from sherd.output import require_writable
from sherd.result_folder import ResultFolder, ResultKind, replaceable_files

MATCH = ResultKind("sherd match 1", "whole.ply", "piece.ply")
LOCATE = ResultKind("sherd region 1", "whole.ply", "piece.ply")


def write(folder: Path, kind: ResultKind, names: tuple[str, ...], *, overwrite: bool = False):
    replaced = replaceable_files(folder, kind, overwrite=overwrite)
    with ResultFolder(folder, replaced=replaced) as output:
        for name in names:
            output.add(name, str(kind))
        output.finish(
            {"format": kind.file_format, "full": {"name": kind.full}, "part": {"name": kind.part}}
        )


def names_in(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_the_same_question_replaces_its_result_and_leaves_nothing_of_it(tmp_path) -> None:
    write(tmp_path, MATCH, ("correspondence.csv", "alternatives.npz"))
    (tmp_path / "view.png").write_text("drawn later")
    write(tmp_path, MATCH, ("correspondence.csv",))
    assert names_in(tmp_path) == {"correspondence.csv", "result.json", "view.png"}
    assert ResultKind("sherd match 2", "whole.ply", "piece.ply").like(MATCH)


@pytest.mark.parametrize("kind", [LOCATE, ResultKind("sherd match 1", "whole.ply", "other.ply")])
def test_another_question_is_refused_unless_told_to_overwrite(tmp_path, kind) -> None:
    write(tmp_path, MATCH, ("correspondence.csv",))
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"holds the match of piece\.ply on whole\.ply; .*--over"):
        write(tmp_path, kind, ("region.csv",))
    assert names_in(tmp_path) == {"correspondence.csv", "result.json", "notes.txt"}
    write(tmp_path, kind, ("region.csv",), overwrite=True)
    assert names_in(tmp_path) == {"region.csv", "result.json", "notes.txt"}


def test_files_of_others_are_not_mixed_with_a_result(tmp_path) -> None:
    (tmp_path / ".hidden").write_text("does not matter")
    (tmp_path / "demo").mkdir()  # results stand beside each other: out/demo, then out
    assert replaceable_files(tmp_path, MATCH) == ()
    for name in "abcd":
        (tmp_path / name).write_text("mine")
    with pytest.raises(OutputError, match="a, b, c and 1 more, which no result names"):
        replaceable_files(tmp_path, MATCH)
    assert replaceable_files(tmp_path, MATCH, own="abcd") == ()
    write(tmp_path, MATCH, ("region.csv",), overwrite=True)
    (tmp_path / "full.ply").write_text("mine")
    with pytest.raises(OutputError, match=r"full\.ply, which its result\.json does not name"):
        replaceable_files(tmp_path, MATCH)


@pytest.mark.parametrize("overwrite", [False, True])
def test_what_a_result_cannot_replace_is_known_before_the_work(tmp_path, overwrite) -> None:
    puzzle = ResultKind("sherd assembly 1", "whole.ply", "a.ply, b.ply")
    (tmp_path / "piece_1").write_text("mine")
    with pytest.raises(OutputError, match=r"piece_1: is a file where the result has a folder; mo"):
        replaceable_files(tmp_path, puzzle, overwrite=overwrite)
    replaceable_files(tmp_path, MATCH, overwrite=True)  # it has no pieces
    (tmp_path / "piece_1").unlink()
    for name in ("piece_1/part.ply", "report.html"):
        (tmp_path / name).mkdir(parents=True)
        with pytest.raises(OutputError, match=rf"{name}: is a folder where a result has a file"):
            replaceable_files(tmp_path, puzzle, overwrite=overwrite)
        (tmp_path / name).rmdir()
    assert replaceable_files(tmp_path, puzzle, overwrite=overwrite) == ()


def test_what_cannot_be_written_is_known_before_and_leaves_no_trace(tmp_path) -> None:
    (tmp_path / "file").write_text("in the way")
    for path, folder in ((tmp_path / "file", True), (tmp_path / "file" / "a.npz", False)):
        with pytest.raises(OutputError, match="cannot be written"):
            require_writable(path, folder=folder)
    with pytest.raises(OutputError, match="directory"):
        require_writable(tmp_path)
    require_writable(tmp_path / "new" / "folder" / "a.npz")
    require_writable(tmp_path / "new", folder=True)
    assert names_in(tmp_path) == {"file"}
