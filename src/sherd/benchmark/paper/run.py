"""The founding paper reproduced: figures 1 to 7 with numbers, the floors, and its open ends."""

from __future__ import annotations

import base64
import html
import json
import os
import platform
from collections.abc import Callable
from pathlib import Path
from typing import Any

from sherd._version import __version__
from sherd.benchmark.paper.drawing import check_plotting
from sherd.benchmark.paper.figures import (
    body_parts_figure,
    boundary_figure,
    convergence_figure,
    membership_figure,
    regularity_figure,
)
from sherd.benchmark.paper.scenes import Scene, creature_scene, file_scene
from sherd.benchmark.paper.studies import (
    animation_scenes,
    descriptor_study,
    method_study,
    parameter_study,
)
from sherd.benchmark.paper.timing import floors, outer_iteration_cost, solver_figures
from sherd.output import Stages, write_text

__all__ = ["paper_figures", "paper_summary"]

PAPER_VERTICES = 2_000  # the paper's horse
METHOD_VERTICES = 5_000
CAPTIONS = {
    "figure1": "Membership of a leg.",
    "figure2": "Boundary effect of the heat kernel signature: error against distance to the cut.",
    "figure3": "Influence of lambda_r: too low, right, too high.",
    "figure4": "Difference between subspace and all-vertex membership against k.",
    "figure5": "Head, tail and leg: all vertices above, subspace (k = 60) below.",
    "figure6": "Time of one membership step against k.",
    "figure7": "Error of the augmented Lagrangian against the quadratic program.",
    "floors": "Solver times at 10,000 vertices, set-up and eigenbasis excluded.",
    "iteration_cost": "Cost of one alternation against the number of vertices.",
    "parameters": "Automatic lambda_r against a grid, 20 pairs.",
    "descriptors": "Descriptors on the same parts (IoU).",
    "methods": "Head, tail and leg from another pose, by every method (IoU, twins forgiven).",
}


def paper_figures(
    out: str | os.PathLike[str],
    *,
    mesh: str | os.PathLike[str] | None = None,
    quick: bool = False,
    data: str | os.PathLike[str] | None = None,
    stages: Stages | None = None,
) -> dict[str, Any]:
    """Reproduce the paper into a folder: ``paper.json``, PNG figures and one ``paper.html``.

    Parameters
    ----------
    out
        Folder for the files; made if needed.
    mesh
        The full shape; a generated animal of 2,000 vertices in two poses if None. Parts are cut
        from the mesh itself then, as in the paper.
    quick
        Figures only, with 5 instead of 25 parts in figure 4: without the floors, the cost against
        n and the studies, which take most of the time.
    data
        Folder with ``animations/horse-poses`` for the table of methods; the generated animal
        alone if None.
    stages
        Shows progress; a silent one if None.

    Returns
    -------
    dict
        What ``paper.json`` holds.

    Raises
    ------
    OptionError
        If matplotlib is not installed.
    MeshFileError
        If the mesh cannot be read.
    OutputError
        If a file cannot be written.

    Notes
    -----
    About 4 minutes on one core, 1 minute with `quick`. Times in the result are wall times of
    this machine; run it on one that is idle.
    """
    check_plotting()
    folder = Path(out)
    stages = stages or Stages(visible=False)
    with stages("shapes"):
        scene = creature_scene(PAPER_VERTICES) if mesh is None else file_scene(Path(mesh))
    result: dict[str, Any] = {
        "version": __version__,
        "shape": scene.full.name,
        "vertices": scene.full.vertex_count,
        "machine": f"{platform.machine()}, Python {platform.python_version()}",
    }
    for name, run in _tasks(scene, folder, quick=quick, data=data).items():
        with stages(name):
            result[name] = run()
        write_text(folder / "paper.json", json.dumps(result, indent=1, default=float) + "\n")
    write_text(folder / "paper.html", _page(result, folder))
    stages.close()
    return result


def paper_summary(result: dict[str, Any]) -> str:
    """The main numbers of a result as lines of text."""
    lines = [f"{result['shape']}, {result['vertices']} vertices"]
    lines += [
        f"{row['part']:<6} IoU all vertices {row['iou all vertices']:.2f}, subspace "
        f"{row['iou subspace']:.2f}, mean difference {row['difference']:.4f}"
        for row in result["figure5"]["rows"]
    ]
    pairs = zip(result["figure4"]["basis_sizes"], result["figure4"]["mean"], strict=True)
    lines.append("difference by k: " + ", ".join(f"{size}: {mean:.4f}" for size, mean in pairs))
    if "floors" in result:
        lines += [f"{name}: {value:.1f} x" for name, value in result["floors"]["ratios"].items()]
        lines.append(f"one alternation grows like n^{result['iteration_cost']['exponent']:.2f}")
        study = result["parameters"]
        lines.append(
            f"automatic lambda_r: mean IoU {study['mean_iou_automatic']:.3f}, best of the grid "
            f"{study['mean_iou_best_per_pair']:.3f} ({study['pairs']} pairs)"
        )
        lines += [f"{name}: IoU {value:.2f}" for name, value in result["methods"]["best"].items()]
    return "\n".join(lines)


def _tasks(
    scene: Scene, folder: Path, *, quick: bool, data: str | os.PathLike[str] | None
) -> dict[str, Callable[[], dict[str, Any]]]:
    tasks: dict[str, Callable[[], dict[str, Any]]] = {
        "figure1": lambda: membership_figure(scene, folder),
        "figure2": lambda: boundary_figure(scene, folder),
        "figure3": lambda: regularity_figure(scene, folder),
        "figure4": lambda: convergence_figure(scene, folder, more=0 if quick else 20),
        "figure5": lambda: body_parts_figure(scene, folder),
        "figure6": lambda: solver_figures(scene, folder),
    }
    if quick:
        return tasks

    def methods() -> dict[str, Any]:
        scenes = {"creature": creature_scene(METHOD_VERTICES)}
        return method_study(scenes | (animation_scenes(Path(data)) if data else {}))

    return tasks | {
        "floors": floors,
        "iteration_cost": lambda: outer_iteration_cost(folder),
        "parameters": parameter_study,
        "descriptors": lambda: descriptor_study(scene),
        "methods": methods,
    }


def _page(result: dict[str, Any], folder: Path) -> str:
    """One self-contained page: every figure with its numbers beside it."""
    sections = []
    for name, caption in CAPTIONS.items():
        pictures = [
            f'<img alt="{html.escape(caption)}" src="data:image/png;base64,'
            f'{base64.b64encode(path.read_bytes()).decode()}">'
            for path in sorted(folder.glob(f"{name}*.png"))
        ]
        # figure 7 has its numbers beside those of figure 6
        numbers = result.get(name)
        if not pictures and numbers is None:
            continue
        table = "" if numbers is None else f"<pre>{html.escape(_readable(numbers))}</pre>"
        title = html.escape(f"{name.capitalize().replace('_', ' ')}: {caption}")
        sections.append(f"<section><h2>{title}</h2>{''.join(pictures)}{table}</section>")
    heading = f"The founding paper, reproduced on {html.escape(result['shape'])}"
    style = (
        "body{font:15px/1.5 system-ui,sans-serif;max-width:1100px;margin:2em auto;padding:0 1em;"
        "color:#1c2026}img{max-width:100%}pre{background:#f4f5f7;padding:1em;overflow:auto;"
        "font-size:12px}h2{font-size:1.1em;margin-top:2em}"
    )
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{heading}</title>'
        f"<style>{style}</style></head><body><h1>{heading}</h1>"
        f"<p>sherd {html.escape(result['version'])}, {html.escape(result['machine'])}, "
        f"{result['vertices']} vertices. The same numbers are in paper.json.</p>"
        f"{''.join(sections)}</body></html>\n"
    )


def _readable(numbers: dict[str, Any]) -> str:
    """Nested numbers as text: one line for each row of a table."""
    lines = []
    for key, value in numbers.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            columns = list(value[0])
            lines.append("  ".join(f"{column:>22}" for column in columns))
            lines += ["  ".join(f"{_short(row[c]):>22}" for c in columns) for row in value]
        elif isinstance(value, dict):
            lines.append(f"{key}:")
            lines += [f"    {name}: {_short(item)}" for name, item in value.items()]
        else:
            lines.append(f"{key}: {_short(value)}")
    return "\n".join(lines)


def _short(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, list):
        return " ".join(_short(item) for item in value)
    if isinstance(value, dict):
        return ", ".join(f"{name} {_short(item)}" for name, item in value.items())
    return str(value)
