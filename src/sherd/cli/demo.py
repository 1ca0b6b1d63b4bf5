"""`sherd demo`."""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from sherd.cli.inputs import prepared_mesh
from sherd.cli.locating import STAGE_COUNT, locate_and_write, summary
from sherd.mesh.files import write_mesh
from sherd.output import Stages
from sherd.region.options import LocateOptions
from sherd.shapes.creature import creature, landmarks
from sherd.shapes.fragment import Fragment, cut_by_ball, moved, remeshed, whole

__all__ = ["demo_command", "demo_fragment"]

VERTEX_COUNT = 10_000


@click.command("demo")
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), default=Path("sherd-demo"), show_default=True
)
def demo_command(output: Path) -> int:
    """Locate a piece of a generated animal; needs no files.

    The animal walks, its front half is cut off, meshed anew, turned at random and sought on the
    standing animal.
    """
    stages = Stages(STAGE_COUNT + 1)
    with stages("generated shapes"):
        fragment = demo_fragment()
        full, part = output / "creature.ply", output / "fragment.ply"
        write_mesh(fragment.full, full)
        write_mesh(fragment.mesh, part)
    region, _ = locate_and_write(
        prepared_mesh(full), prepared_mesh(part), output, options=LocateOptions(), stages=stages
    )
    stages.close()
    areas, truth = fragment.full.vertex_areas, fragment.region
    overlap = areas[region.mask & truth].sum() / areas[region.mask | truth].sum()
    click.echo(summary(region, output))
    click.echo(f"The true place is known here: {100 * overlap:.1f} % overlap (IoU).")
    return 0


def demo_fragment() -> Fragment:
    """Head, neck and chest of the walking animal, with other triangles and another position."""
    full, walking = creature(VERTEX_COUNT), creature(VERTEX_COUNT, pose="walk")
    piece = cut_by_ball(whole(walking, full), landmarks(full)["nose"], 0.7)
    return moved(remeshed(piece, 1.1), np.random.default_rng(7))
