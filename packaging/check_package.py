"""Build wheel and source archive, install the wheel alone in a fresh environment, run its demo.

The archive must make the same wheel, file by file, so that one environment answers for both.
``PYTHONS`` names the interpreters, this one if not set. Needs a package index, as any installation
does, and takes a minute or two each: loops are compiled anew in each environment.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from pathlib import Path

from hatchling.build import build_sdist, build_wheel

ROOT = Path(__file__).parents[1]


def main() -> None:
    """Build, install and run; end with the first failure."""
    os.chdir(ROOT)
    pythons = os.environ.get("PYTHONS", sys.executable).split()
    with tempfile.TemporaryDirectory() as folder:
        dist = Path(folder)
        wheel, archive = dist / build_wheel(folder), dist / build_sdist(folder)
        _check_archive(archive, wheel, dist / "unpacked")
        for number, python in enumerate(pythons):
            _check_wheel(python, wheel, dist / f"environment-{number}")


def _check_archive(archive: Path, wheel: Path, folder: Path) -> None:
    """The wheel that the archive makes has the same files as `wheel`."""
    with tarfile.open(archive) as content:
        content.extractall(folder, filter="data")
    (source,) = folder.iterdir()
    os.chdir(source)
    again = source / build_wheel(str(source))
    os.chdir(ROOT)
    first, second = _checksums(wheel), _checksums(again)
    if first != second:
        names = sorted(name for name, _ in first.items() ^ second.items())
        sys.exit(f"{archive.name} makes another wheel; they differ in {', '.join(names[:5])}")
    sys.stdout.write(f"{archive.name} makes the same wheel, {len(first)} files\n")


def _checksums(wheel: Path) -> dict[str, int]:
    with zipfile.ZipFile(wheel) as archive:
        return {each.filename: each.CRC for each in archive.infolist()}


def _check_wheel(python: str, package: Path, environment: Path) -> None:
    """It installs without extras, and its demo runs there."""
    _run([python, "-m", "venv", environment])
    own = environment / "bin" / "python"
    constraints = ROOT / "constraints.txt"
    _run([own, "-m", "pip", "install", "--quiet", "-c", constraints, package])
    said = _run([environment / "bin" / "sherd", "--version"], folder=environment)
    _run([environment / "bin" / "sherd", "demo", "--quiet", "-o", "demo"], folder=environment)
    written = environment / "demo" / "report.html"
    if not written.is_file():
        sys.exit(f"{package.name}: the demo wrote no {written.name}")
    sys.stdout.write(f"{package.name} on {python}: {said.strip()}, its demo runs\n")


def _run(words: list[str | Path], *, folder: Path | None = None) -> str:
    done = subprocess.run(  # noqa: S603 - our own words
        [str(word) for word in words], cwd=folder, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, words))} ended with {done.returncode}:\n{done.stderr}")
    return done.stdout


if __name__ == "__main__":
    main()
