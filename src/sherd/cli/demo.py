"""`sherd demo`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click
import numpy as np

from sherd.benchmark.metrics import region_overlap
from sherd.cli.first_run import prepare_first_run
from sherd.cli.inputs import check_outputs, show_notices
from sherd.cli.matching import match_and_write, match_summary
from sherd.cli.options import overwrite_option, quiet_option
from sherd.cli.overlapping import overlap_and_write, overlap_summary
from sherd.files.mesh_files import write_mesh
from sherd.match import STAGES
from sherd.output import Stages
from sherd.overlap import STAGES as OVERLAP_STAGES
from sherd.report.stored.folder import MATCH_FORMAT, OVERLAP_FORMAT
from sherd.results.match_options import MatchOptions
from sherd.results.overlap_options import OverlapOptions
from sherd.scan.intake import scan_intake
from sherd.shapes.creature import creature, landmarks
from sherd.shapes.fragment import Fragment, cut_by_ball, moved, remeshed, whole
from sherd.spectral.surface_distances import SurfaceDistances
from sherd.surface.template import Template

__all__ = ["demo_command", "demo_fragment", "demo_pieces"]

VERTEX_COUNT = 10_000
# Geodesic distance from the nose, in sqrt(area): the head, and all but the hind quarters.
HEAD, FRONT = 0.35, 0.9


@click.command("demo")
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), default=Path("sherd-demo"), show_default=True
)
@overwrite_option
@quiet_option()
def demo_command(output: Path, *, overwrite: bool, quiet: bool) -> int:
    """Match a piece of a generated animal with the whole; needs no files.

    The animal walks, its front half is cut off, meshed anew, turned at random and sought on the
    standing animal. Then two overlapping pieces of it, in different poses, are asked for what they
    share; that is in the folder pieces/.

    \b
    Example:
      sherd demo -o demo/ && sherd view demo/
    """  # noqa: D301
    full, part = output / "creature.ply", output / "fragment.ply"
    own = (full.name, part.name)  # an interrupted demo may have left them
    pieces = output / "pieces"
    first, second = pieces / "front.ply", pieces / "rear.ply"
    check_outputs(output, MATCH_FORMAT, full, part, overwrite=overwrite, own=(*own, pieces.name))
    prepare_first_run(quiet=quiet)
    both = (first.name, second.name)
    check_outputs(pieces, OVERLAP_FORMAT, first, second, overwrite=overwrite, own=both)
    stages = Stages(len(STAGES) + len(OVERLAP_STAGES) + 3, visible=False if quiet else None)
    with stages("generated shapes"):
        fragment = demo_fragment()
        write_mesh(fragment.full, full)
        write_mesh(fragment.mesh, part)
        pieces.mkdir(exist_ok=True)
        for piece, path in zip(demo_pieces(), (first, second), strict=True):
            write_mesh(piece.mesh, path)
    result, document = match_and_write(
        Template(full), scan_intake(part), output, options=MatchOptions(), stages=stages
    )
    shared, _ = overlap_and_write(
        scan_intake(first), scan_intake(second), pieces, OverlapOptions(), stages
    )
    stages.close()
    show_notices(result, quiet=quiet)
    if quiet:
        return 0
    click.echo(match_summary(result, document, output))
    distances = SurfaceDistances(fragment.full)
    error = 100 * distances.between(fragment.truth, result.points).mean()
    common = region_overlap(fragment.full, result.best.mask, fragment.region)
    click.echo(
        f"The truth is known here: mean error {error:.2f} % of sqrt(area), region overlap "
        f"{100 * common:.0f} % (IoU)."
    )
    click.echo("Two pieces in different poses, and no whole:")
    click.echo(overlap_summary(shared, pieces))
    return 0


def demo_pieces() -> tuple[Fragment, Fragment]:
    """Front of the standing animal, and the walking one without its head; they share the middle."""
    full, walking = creature(VERTEX_COUNT), creature(VERTEX_COUNT, pose="walk")
    nose = landmarks(full)["nose"]
    posed = whole(walking, full)
    head = cut_by_ball(posed, nose, HEAD).region
    mesh, kept = posed.mesh.submesh(~head[posed.mesh.faces].any(axis=1))
    rear = replace(posed, mesh=mesh, truth=posed.truth[kept], present=posed.present[kept])
    front = cut_by_ball(whole(full, full), nose, FRONT)
    return front, moved(remeshed(rear, 1.1), np.random.default_rng(11))


def demo_fragment() -> Fragment:
    """Head, neck and chest of the walking animal, with other triangles and another position."""
    full, walking = creature(VERTEX_COUNT), creature(VERTEX_COUNT, pose="walk")
    piece = cut_by_ball(whole(walking, full), landmarks(full)["nose"], 0.7)
    return moved(remeshed(piece, 1.1), np.random.default_rng(7))
