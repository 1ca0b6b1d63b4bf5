"""The folder layout shows the architecture: floors, rooms, files, kernels; imports go down."""

from __future__ import annotations

import ast
import importlib.util
import subprocess
import sys
import tomllib
from collections import Counter
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import sherd

ROOT = Path(sherd.__file__).parent
REPOSITORY = Path(__file__).parents[1]
# Floor of each folder or module in src/sherd, from the bottom; docs/architecture.md draws it.
FLOORS = {
    "_version": 0,
    "errors": 1,
    "arrays": 1,
    "compiled": 1,
    "limits": 1,
    "npz": 1,
    "output": 1,
    "result_folder": 1,
    "threads": 1,
    "mesh": 2,
    "drawing": 3,
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
    "landmarks": 8,
    "correspondence": 8,
    "place": 9,
    "match": 10,
    "locate": 9,
    "overlap": 9,
    "puzzle": 11,
    "library": 12,
    "fitting": 11,
    "assemble": 12,
    "join": 12,
    "report": 13,
    "batching": 14,
    "benchmark": 15,
    "cli": 16,
    # loads the public names from all floors, and starts the command line
    "sherd": 17,
    "__main__": 17,
}
GROUND = 1  # output may raise errors, and both stand on the ground
LARGEST_FILE = 400
LARGEST_ROOM = 16
# Rooms that are too full, and by how much; a number here only ever falls.
CROWDED = {"correspondence": 18}


def module_name(path: Path) -> str:
    words = ("sherd", *path.relative_to(ROOT).with_suffix("").parts)
    return ".".join(words[:-1] if words[-1] == "__init__" else words)


MODULES = {module_name(path): path for path in sorted(ROOT.rglob("*.py"))}


def place(module: str) -> str:
    """The folder or module in src/sherd that a module belongs to; sherd itself is one."""
    return module.split(".")[:2][-1]


def imported(module: str, *, functions: bool) -> Iterator[str]:
    """What a module imports, at its top and perhaps inside functions; not for type checkers only.

    Of `from a.b import c` both `a.b` and `a.b.c`, which may be a module too.
    """
    path = MODULES[module]
    package = module if path.stem == "__init__" else module.rpartition(".")[0]
    nodes: list[ast.AST] = [ast.parse(path.read_text(encoding="utf-8"))]
    while nodes:
        node = nodes.pop()
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING"):
            continue
        if isinstance(node, ast.FunctionDef) and not functions:
            continue
        nodes.extend(ast.iter_child_nodes(node))
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            home = importlib.util.resolve_name("." * node.level + (node.module or ""), package)
            yield home
            yield from (f"{home}.{alias.name}" for alias in node.names)


def imports(module: str) -> set[str]:
    """The modules of sherd that a module imports; a package only if nothing inside it is named."""
    found = set(imported(module, functions=True)) & set(MODULES)
    return {name for name in found if not any(other.startswith(f"{name}.") for other in found)}


def test_every_module_has_a_floor_and_every_floor_a_module() -> None:
    assert {place(module) for module in MODULES} == set(FLOORS)


def test_imports_go_down_only() -> None:
    wrong = []
    for module in MODULES:
        here, floor = place(module), FLOORS[place(module)]
        for there in imports(module):
            side_by_side = FLOORS[place(there)] == floor == GROUND
            if place(there) != here and FLOORS[place(there)] >= floor and not side_by_side:
                wrong.append(f"{module} imports {there}")
    assert wrong == []


def test_no_modules_import_each_other() -> None:
    """Inside rooms too, and over any number of steps."""
    try:
        TopologicalSorter({module: imports(module) for module in MODULES}).prepare()
    except CycleError as error:
        pytest.fail(" imports ".join(reversed(error.args[1])))


def test_rooms_stay_small() -> None:
    sizes = Counter(
        path.parent.relative_to(ROOT).as_posix()
        for path in MODULES.values()
        if path.stem != "__init__"
    )
    assert {
        room: size for room, size in sizes.items() if size > CROWDED.get(room, LARGEST_ROOM)
    } == {}


def test_files_stay_small() -> None:
    lengths = {
        path.relative_to(ROOT).as_posix(): len(path.read_text(encoding="utf-8").splitlines())
        for path in MODULES.values()
    }
    assert {name: count for name, count in lengths.items() if count > LARGEST_FILE} == {}


def test_compiled_loops_are_in_kernels_and_mypy_knows_them() -> None:
    kernels = {module for module in MODULES if module.endswith("_kernel")}
    at_the_top = {module: set(imported(module, functions=False)) for module in MODULES}
    assert {module for module, names in at_the_top.items() if "numba" in names} == {
        "sherd.compiled"
    }
    assert {module for module, names in at_the_top.items() if "sherd.compiled" in names} == kernels
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))
    untyped = [
        override["module"]
        for override in project["tool"]["mypy"]["overrides"]
        if override.get("allow_untyped_defs")
    ]
    assert untyped == [sorted(kernels)]


def test_public_names_are_sorted_and_exist() -> None:
    assert sherd.__all__ == sorted(sherd.__all__)
    assert set(sherd._HOMES) == set(sherd.__all__) - {"__version__"}
    for name in sherd.__all__:
        assert getattr(sherd, name) is not None


def test_import_is_light() -> None:
    code = "import sys, sherd; print([m for m in ('numpy','numba','scipy') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
