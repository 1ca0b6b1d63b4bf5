"""Help, completion, quiet, color and `sherd view`: how the commands behave around their work."""

from __future__ import annotations

import os
import pty
import re
import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.testing import CliRunner
from PIL import Image

from sherd.cli.main import COMMANDS, main
from sherd.files.mesh_files import write_mesh
from sherd.shapes.creature import creature, landmarks
from sherd.shapes.fragment import cut_by_ball, whole
from sherd.spectral.sampling import decimate

BENCHES = (
    "region", "paper", "shrec16", "faust", "smal", "smal-match", "cp2p", "singleview", "belonging",
    "robustness", "skulls", "identify",
)  # fmt: skip
LEAVES = [
    *([name] for name in COMMANDS if name != "bench"),
    *(["bench", name] for name in BENCHES),
]


@pytest.fixture(scope="module")
def located(run, tmp_path_factory) -> tuple[Path, subprocess.CompletedProcess[str]]:
    folder = tmp_path_factory.mktemp("manners")
    animal = creature(5000)
    piece = cut_by_ball(whole(animal, animal), landmarks(animal)["nose"], 0.6).mesh
    write_mesh(decimate(animal, 2000)[0], folder / "full.ply")
    write_mesh(decimate(piece, 700)[0], folder / "part.ply")
    done = run(
        "locate", folder / "full.ply", folder / "part.ply", "-o", folder / "out",
        "--quiet", "--export", "mat",
    )  # fmt: skip
    return folder / "out", done


@pytest.mark.parametrize("path", LEAVES, ids=" ".join)
def test_help_has_an_example_that_parses(path) -> None:
    done = CliRunner().invoke(main, [*path, "--help"], standalone_mode=False)
    examples = re.findall(r"^ *sherd (.*)$", done.output, re.MULTILINE)
    assert examples
    for line in done.output.splitlines():
        assert len(line) <= 80
    for example in examples:
        words = example.split("&&")[0].split()
        assert words[: len(path)] == path
        command: click.Command = main
        for name in path:
            command = command.get_command(click.Context(command), name)
        context = click.Context(command, resilient_parsing=True)
        command.parse_args(context, words[len(path) :])
        options = {name for option in command.params for name in option.opts}
        assert {word for word in words if word.startswith("-")} <= options


PROGRAM = "import sys; sys.argv[0] = 'sherd'; from sherd.cli import main; main()"


# bash is left out: click asks the installed bash for its version first
@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_completion_scripts_are_offered(shell) -> None:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        capture_output=True, text=True, check=True,
        env={**os.environ, "_SHERD_COMPLETE": f"{shell}_source"},
    )  # fmt: skip
    assert "_SHERD_COMPLETE" in done.stdout


def test_completion_knows_commands_and_choices() -> None:
    for typed, expected in (("sherd lo", "locate"), ("sherd match --export v", "vtp")):
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM],
            capture_output=True, text=True, check=True,
            env={
                **os.environ,
                "_SHERD_COMPLETE": "bash_complete",
                "COMP_WORDS": typed,
                "COMP_CWORD": str(len(typed.split()) - 1),
            },
        )  # fmt: skip
        assert f"plain,{expected}" in done.stdout


def test_quiet_says_nothing_and_exports_are_written(run, located) -> None:
    out, done = located
    assert done.returncode == 0
    assert done.stdout == done.stderr == ""
    assert (out / "result.mat").exists()
    assert run("check", out / "part.ply", "--quiet").stdout == ""


def test_view_draws_the_picture_again(run, located, tmp_path) -> None:
    out, _ = located
    assert run("view", out, "--png", "-q", "-o", tmp_path / "a.png").stdout == ""
    with Image.open(out / "region.png") as stored, Image.open(tmp_path / "a.png") as again:
        assert again.size == stored.size
    done = run("view", out, "--png", "--layer", "phase field", "--width", "800", "--transparent")
    assert done.stdout.strip() == f"written: {out / 'view.png'}"
    with Image.open(out / "view.png") as picture:
        assert picture.width == 800
        assert picture.getpixel((2, 2))[3] == 0


def test_view_names_the_report_when_nobody_looks(run, located, tmp_path) -> None:
    out, _ = located
    assert run("view", out).stdout.strip() == str((out / "report.html").resolve())
    assert run("view", tmp_path).returncode == 3
    assert run("view", out, "--layer", "region").returncode == 2
    done = run("view", out, "--png", "--layer", "nonsense")
    assert done.returncode == 2
    assert "nonsense" in done.stderr


def test_view_opens_the_browser_on_a_terminal(located, monkeypatch) -> None:
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setattr("sherd.cli.viewing.on_terminal", lambda: True)
    CliRunner().invoke(main, ["view", str(located[0])], standalone_mode=False)
    assert opened == [(located[0] / "report.html").resolve().as_uri()]


def test_color_is_for_terminals_only(run, tmp_path) -> None:
    missing = tmp_path / "missing.ply"
    assert "\x1b" not in run("check", missing).stderr
    reader, writer = pty.openpty()
    with os.fdopen(reader, "rb", buffering=0) as shown:
        subprocess.run(
            [sys.executable, "-m", "sherd", "check", str(missing)], stderr=writer, check=False
        )
        os.close(writer)
        assert b"\x1b[31m" in shown.read(4096)
