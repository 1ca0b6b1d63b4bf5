"""Build wheel and source archive, install each alone in a fresh environment, and run its demo.

``PYTHONS`` names the interpreters, this one if not set. Needs a package index, as any installation
does, and takes some minutes: loops are compiled anew in each environment.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from hatchling.build import build_sdist, build_wheel

ROOT = Path(__file__).parents[1]


def main() -> None:
    """Build, install and run; end with the first failure."""
    os.chdir(ROOT)
    pythons = os.environ.get("PYTHONS", sys.executable).split()
    with tempfile.TemporaryDirectory() as folder:
        dist = Path(folder)
        packages = [dist / build_wheel(folder), dist / build_sdist(folder)]
        for python in pythons:
            for package in packages:
                _check(python, package, dist / f"{Path(python).name}-{package.suffix[1:]}")


def _check(python: str, package: Path, environment: Path) -> None:
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
