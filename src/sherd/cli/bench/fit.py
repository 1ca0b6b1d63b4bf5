"""`sherd bench fit`."""

from __future__ import annotations

from pathlib import Path

import click
from click.core import ParameterSource

from sherd.benchmark.fit.benchmark import fit_benchmark, fit_table
from sherd.benchmark.fit.skull_fits import holds_skulls, skull_fit_benchmark, skull_fit_table
from sherd.benchmark.fit.sources import CUTS

__all__ = ["fit_bench_command"]


@click.command("fit")
@click.argument("directory", type=click.Path(path_type=Path))
@click.option("--poses", type=int, default=2, show_default=True, help="Poses or people of each.")
@click.option("--cut", "cuts", type=click.Choice(CUTS), multiple=True, help="All if none.")
@click.option("--pairs", "limit", type=int, help="First pairs only, which are of all kinds.")
@click.option("--icp", is_flag=True, help="Run trimesh's non-rigid ICP too; minutes a pair.")
@click.option("--jobs", type=int, default=1, show_default=True, help="Processes.")
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="Folder.")
def fit_bench_command(
    directory: Path,
    *,
    poses: int,
    cuts: tuple[str, ...],
    limit: int | None,
    icp: bool,
    jobs: int,
    output: Path,
) -> int:
    """Fit wholes to parts of them that are in another pose, or of another individual.

    DIRECTORY holds an .npz file or a folder of meshes for each animated shape, or faces.npz. The
    part is a geodesic ball with a share of the area, or what one camera sees, meshed anew and
    turned. With libigl installed its ARAP is run on the same map. Writes fit.json; goes on where an
    interrupted run stopped.

    If the .npz files hold skulls with landmarks, each is fitted to a half of each other one, and
    distances are those of landmarks from where a hand set them (skull_fits.json).

    \b
    Example:
      sherd bench fit tosca_poses/ --pairs 20 -o bench/
    """  # noqa: D301
    if holds_skulls(directory):
        given = click.get_current_context().get_parameter_source("poses")
        if cuts or given is not ParameterSource.DEFAULT:
            raise click.UsageError("--poses and --cut are for animated shapes; skulls are halved")
        skulls = skull_fit_benchmark(directory, output, limit=limit, with_icp=icp, jobs=jobs)
        click.echo(skull_fit_table(skulls))
        return 0
    rows = fit_benchmark(
        directory, output, poses=poses, cuts=cuts, limit=limit, with_icp=icp, jobs=jobs
    )
    click.echo(fit_table(rows))
    return 0
