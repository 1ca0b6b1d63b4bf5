"""A batch whose matches are answered at once: what is tested here is all that is around them."""

from __future__ import annotations

import io
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from PIL import Image

from sherd.batching.batch import BatchResult, batch
from sherd.batching.choice import Chosen
from sherd.cli.main import main
from sherd.files.mesh_files import write_mesh
from sherd.report.match_report import match_report
from sherd.report.stored.folder import plain
from sherd.result_folder import ResultFolder


@dataclass
class Stand:
    """Files of a full shape and its parts, and what was asked so far."""

    folder: Path
    asked: list[str] = field(default_factory=list)
    before: Callable[[str], None] = lambda _: None

    @property
    def out(self) -> Path:
        return self.folder / "out"

    def run(self, **more: object) -> BatchResult:
        self.asked.clear()
        given = {"parts": self.folder / "scans", "folder": self.out} | more
        with ThreadPoolExecutor(1) as here:
            return batch(self.folder / "whole.ply", executor=here, **given)


@pytest.fixture(scope="session")
def written(exhibit, match_result_of) -> Callable[..., dict[str, object]]:
    """As `write_report`, but draws nothing."""
    document = plain(dict(match_report(match_result_of(exhibit)).document))
    stream = io.BytesIO()
    Image.new("RGB", (400, 160), "teal").save(stream, "PNG")

    def write(result, folder, *, command, exports):
        with ResultFolder(folder) as output:
            output.add("match.png", stream.getvalue())
            output.add("report.html", "<p>a report</p>")
            return output.finish(document | {"command": command})

    return write


@pytest.fixture
def stand(tmp_path, exhibit, match_result_of, written, monkeypatch) -> Stand:
    """Three parts and a broken one; `asked` are the names of the files that were matched."""
    made = Stand(tmp_path)
    (tmp_path / "scans").mkdir()
    write_mesh(exhibit.full, tmp_path / "whole.ply")
    for name in ("a", "b", "c"):
        write_mesh(exhibit.part, tmp_path / "scans" / f"{name}.ply")
    (tmp_path / "scans" / "broken.ply").write_text("ply\nformat ascii 1.0\nelement vertex 5\n")
    result = match_result_of(exhibit)

    def best_match(fulls, part, options, *, fit_scale):
        made.asked.append(part.original.name)
        made.before(part.original.name)
        return Chosen(fulls[0], result)

    def prepare(missing) -> None:
        for path in missing:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(b"template")

    monkeypatch.setattr("sherd.batching.work.best_match", best_match)
    monkeypatch.setattr("sherd.batching.work.write_report", written)
    monkeypatch.setattr("sherd.batching.batch.prepare_templates", prepare)
    return made


class Here(ThreadPoolExecutor):
    """In place of worker processes."""

    def __init__(self, jobs: int, *, memory: int | None = None) -> None:
        super().__init__(1)
        self.jobs = jobs


@pytest.fixture
def command(stand, monkeypatch) -> Callable[..., Result]:
    """`command("batch", ...)`: what `sherd` says and its exit code, in the folder of `stand`."""
    monkeypatch.setattr("sherd.batching.workers.IsolatedProcesses", Here)
    monkeypatch.setattr("sherd.cli.batch.command.prepare_first_run", lambda *, quiet: None)
    monkeypatch.chdir(stand.folder)
    stand.asked.clear()
    return lambda *words: CliRunner().invoke(main, [str(word) for word in words])
