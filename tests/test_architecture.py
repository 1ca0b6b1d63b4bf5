"""The folder layout shows the architecture: imports go down only."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import sherd

ROOT = Path(sherd.__file__).parent
# Floor of each package or module, from the bottom; docs/architecture.md draws it.
FLOORS = {
    "_version": 0,
    "errors": 1,
    "arrays": 1,
    "output": 1,
    "threads": 1,
    "mesh": 2,
    "files": 3,
    "repair": 3,
    "scan": 4,
    "spectral": 5,
    "descriptors": 6,
    "energy": 6,
    "shapes": 6,
    "surface": 7,
    "results": 7,
    "region": 8,
    "correspondence": 8,
    "match": 9,
    "locate": 9,
    "report": 10,
    "benchmark": 11,
    "cli": 12,
}
LARGEST_FILE = 400


def room(path: Path) -> str:
    first = path.relative_to(ROOT).parts[0]
    return first.removesuffix(".py")


def imports(path: Path) -> set[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("sherd."):
            found.add(node.module.split(".")[1])
        if isinstance(node, ast.Import):
            found.update(n.name.split(".")[1] for n in node.names if n.name.startswith("sherd."))
    return found


def modules() -> list[Path]:
    return [p for p in sorted(ROOT.rglob("*.py")) if p.parent != ROOT or p.stem[:2] != "__"]


def test_imports_go_down_only() -> None:
    wrong = []
    for path in modules():
        here = room(path)
        for there in imports(path) - {here}:
            # errors and output stand side by side on the ground; output may raise errors
            ground = FLOORS[here] == FLOORS[there] == 1
            if FLOORS[there] >= FLOORS[here] and not ground:
                wrong.append(f"{path.relative_to(ROOT)} imports {there}")
    assert wrong == []


def test_every_room_has_a_floor() -> None:
    assert {room(path) for path in modules()} <= set(FLOORS)


def test_files_stay_small() -> None:
    lengths = {
        str(p.relative_to(ROOT)): len(p.read_text(encoding="utf-8").splitlines()) for p in modules()
    }
    assert {name: n for name, n in lengths.items() if n > LARGEST_FILE} == {}


def test_public_names_are_sorted_and_exist() -> None:
    assert sherd.__all__ == sorted(sherd.__all__)
    assert set(sherd._HOMES) == set(sherd.__all__) - {"__version__"}
    for name in sherd.__all__:
        assert getattr(sherd, name) is not None


def test_import_is_light() -> None:
    code = "import sys, sherd; print([m for m in ('numpy','numba','scipy') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
