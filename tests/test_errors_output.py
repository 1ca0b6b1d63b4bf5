"""The exception tree, atomic files and progress by stage."""

from __future__ import annotations

import os
import pickle
import time

import pytest

from sherd import errors
from sherd.errors import InputError, OptionError, OutputError, SherdError
from sherd.output import Stages, replacing, write_bytes, write_text


def test_every_exception_is_in_the_tree_and_in_the_drawing():
    for name in errors.__all__:
        assert issubclass(getattr(errors, name), SherdError)
        assert name in errors.__doc__


@pytest.mark.parametrize(
    ("kind", "builtin"),
    [(InputError, ValueError), (OptionError, ValueError), (OutputError, OSError)],
)
def test_exceptions_are_also_what_python_calls_them(kind, builtin):
    with pytest.raises(builtin, match="seven"):
        raise kind("seven")


@pytest.mark.parametrize("name", errors.__all__)
def test_exceptions_travel_between_processes(name):
    kind = getattr(errors, name)
    again = pickle.loads(pickle.dumps(kind("a.ply: is empty")))  # noqa: S301 - our own bytes
    assert type(again) is kind
    assert str(again) == "a.ply: is empty"


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_text_and_bytes_are_written_as_given(tmp_path):
    write_text(tmp_path / "new" / "a.txt", "x\ny\u00e4\n")
    assert (tmp_path / "new" / "a.txt").read_bytes() == b"x\ny\xc3\xa4\n"
    write_bytes(tmp_path / "a.bin", b"\0\r\n")
    assert (tmp_path / "a.bin").read_bytes() == b"\0\r\n"
    assert names(tmp_path) == ["a.bin", "new"]


def test_the_old_file_stands_until_the_new_one_is_complete(tmp_path):
    path = tmp_path / "result.json"
    path.write_text("old")
    with replacing(path) as temporary:
        assert temporary.parent == tmp_path
        assert temporary.suffix == ".json"
        temporary.write_text("half")
        assert path.read_text() == "old"
    assert path.read_text() == "half"
    assert names(tmp_path) == ["result.json"]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_an_interruption_keeps_the_old_file_and_leaves_nothing(tmp_path, error):
    path = tmp_path / "result.json"
    path.write_text("old")

    def interrupted():
        with replacing(path) as temporary:
            temporary.write_text("half")
            raise error

    with pytest.raises(error):
        interrupted()
    assert path.read_text() == "old"
    assert names(tmp_path) == ["result.json"]


def test_failures_of_the_disk_name_path_and_remedy(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match=r"file/a\.txt: cannot be written \(.*choose another"):
        write_text(tmp_path / "file" / "a.txt", "")

    def full_disk():
        with replacing(tmp_path / "b") as temporary:
            temporary.write_text("half")
            raise OSError(28, "No space left on device")

    with pytest.raises(OutputError, match="No space left"):
        full_disk()
    with pytest.raises(OutputError, match="nothing was written"), replacing(tmp_path / "c"):
        raise OutputError("nothing was written")
    with pytest.raises(OutputError, match="cannot be written"), replacing(tmp_path / "d"):
        pass  # a block that writes nothing is a failure, not an empty file
    assert names(tmp_path) == ["file"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_an_unwritable_folder_is_named(tmp_path):
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(OutputError, match="Permission denied"):
            write_text(tmp_path / "a.txt", "")
    finally:
        tmp_path.chmod(0o700)


def test_stages_add_up_and_are_timed_even_when_they_fail(capsys):
    stages = Stages(2, visible=False)
    with stages("first"):
        time.sleep(0.01)
    with pytest.raises(ZeroDivisionError), stages("second"):
        raise ZeroDivisionError
    with stages("first"):
        time.sleep(0.01)
    stages.close()
    assert list(stages.seconds) == ["first", "second"]
    assert 0.02 <= stages.seconds["first"] < 5
    assert capsys.readouterr() == ("", "")


def test_the_bar_names_the_stage_on_standard_error(capsys):
    stages = Stages(1, visible=True)
    with stages("eigenbasis"):
        stages.show("eigenbasis: second half")
    stages.close()
    out, err = capsys.readouterr()
    assert out == ""
    assert "eigenbasis" in err
    assert "second half" in err
