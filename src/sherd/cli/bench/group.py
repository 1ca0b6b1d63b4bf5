"""`sherd bench`."""

from __future__ import annotations

import tempfile
from pathlib import Path

import click

from sherd.benchmark.degrade import KINDS, degrade_benchmark, degrade_table
from sherd.benchmark.paper.run import paper_figures, paper_summary
from sherd.benchmark.region import region_benchmark, region_table
from sherd.benchmark.robustness import RobustnessRow, robustness, robustness_commands
from sherd.benchmark.size import SIZES, size_benchmark, size_table
from sherd.benchmark.speed import WORKS, speed_benchmark, speed_table
from sherd.cli.bench.fit import fit_bench_command
from sherd.cli.bench.many import identify_bench_command, skulls_command
from sherd.cli.bench.match import faust_command, shrec16_command, smal_match_command
from sherd.cli.bench.overlap import (
    belonging_command,
    cp2p_command,
    singleview_command,
    smal_command,
)
from sherd.cli.bench.puzzle import join_command, puzzle_command, sherds_command
from sherd.cli.exits import INTERNAL
from sherd.files.mesh_files import write_mesh
from sherd.limits import require_whole
from sherd.output import Stages
from sherd.results.locate_options import METHODS, LocateOptions, Method
from sherd.shapes.creature import creature
from sherd.shapes.fragment import cut_by_ball, whole

__all__ = ["bench_group"]


@click.group("bench")
def bench_group() -> None:
    """Measure accuracy and speed on data sets and generated shapes."""


for command in (
    shrec16_command, faust_command, smal_match_command, cp2p_command, smal_command,
    singleview_command, belonging_command, puzzle_command, join_command, sherds_command,
    identify_bench_command, skulls_command, fit_bench_command,
):  # fmt: skip
    bench_group.add_command(command)


@bench_group.command("region")
@click.argument("directory", type=click.Path(path_type=Path))
@click.option("--remeshed", type=click.Path(path_type=Path), help="Parts meshed anew.")
@click.option("--kind", type=click.Choice(["cuts", "holes"]), default="cuts", show_default=True)
@click.option("--method", type=click.Choice(METHODS), default="voting", show_default=True)
@click.option("--limit", type=int, help="First pairs only.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Folder for bench.json.")
def region_command(
    directory: Path,
    *,
    remeshed: Path | None,
    kind: str,
    method: Method,
    limit: int | None,
    output: Path | None,
) -> int:
    """Locate every part of a SHREC'16 folder, randomly rotated, and report the overlap.

    \b
    Example:
      sherd bench region shrec16/ --remeshed shrec16_remeshed/ -o bench/
    """  # noqa: D301
    rows = region_benchmark(
        directory,
        remeshed=remeshed,
        kind=kind,
        options=LocateOptions(method=method),
        limit=limit,
        output=output,
    )
    click.echo(region_table(rows))
    return 0


@bench_group.command("paper")
@click.option("--mesh", type=click.Path(path_type=Path), help="Full shape; a generated animal.")
@click.option("--data", type=click.Path(path_type=Path), help="Folder that has animations/ in it.")
@click.option("--quick", is_flag=True, help="Figures only, without the studies.")
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="Folder.")
def paper_command(*, mesh: Path | None, data: Path | None, quick: bool, output: Path) -> int:
    """Reproduce the figures of the founding paper with numbers beside them.

    Writes paper.json, PNG figures and paper.html.

    \b
    Example:
      sherd bench paper -o paper/ --quick
    """  # noqa: D301
    stages = Stages(6 if quick else 11)
    result = paper_figures(output, mesh=mesh, quick=quick, data=data, stages=stages)
    stages.close()
    click.echo(f"{paper_summary(result)}\nOpen {output / 'paper.html'} to see it.")
    return 0


@bench_group.command("size")
@click.option("--largest", type=int, default=1_000_000, show_default=True, help="Vertices.")
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="Folder.")
def size_command(*, largest: int, output: Path) -> int:
    """Time and memory of match, from files to report, against the number of vertices.

    Writes size.json and size.png.
    """
    reason = "larger shapes were never measured"
    require_whole("largest", largest, SIZES[0], SIZES[-1], reason)
    sizes = [size for size in SIZES if size <= largest]
    rows = size_benchmark(output, sizes=sizes)
    click.echo(f"{size_table(rows)}\nOpen {output / 'size.png'} to see it.")
    return 0


@bench_group.command("speed")
@click.option("--work", "works", type=click.Choice(list(WORKS)), multiple=True, help="All if none.")
@click.option("--repeats", type=int, default=5, show_default=True, help="Runs of each.")
@click.option(
    "--against",
    metavar="COMMAND",
    help="Another installation, such as other/.venv/bin/sherd: it runs in turn with this one.",
)
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="Folder.")
def speed_command(
    *, works: tuple[str, ...], repeats: int, against: str | None, output: Path
) -> int:
    """Time commands on generated shapes, alone or in turn with another installation.

    Writes speed.json; ratios are wall seconds of this installation over those of the other.

    \b
    Example:
      sherd bench speed --against old/.venv/bin/sherd -o speed/
    """  # noqa: D301
    require_whole("repeats", repeats, 1, 100, "the median of more says no more")
    chosen = works or tuple(WORKS)
    stages = Stages(len(chosen) + 1)
    rows = speed_benchmark(output, works=chosen, repeats=repeats, against=against, stages=stages)
    stages.close()
    click.echo(speed_table(rows))
    return 0


@bench_group.command("degrade")
@click.option("--kind", type=click.Choice(list(KINDS)), multiple=True, help="All if none.")
@click.option("--vertices", type=int, default=10_000, show_default=True)
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="Folder.")
def degrade_command(*, kind: tuple[str, ...], vertices: int, output: Path) -> int:
    """Accuracy of match against noise, uneven density, clutter, holes, flips and pieces.

    Writes degrade.json and a curve for each as PNG; goes on where an interrupted run stopped.
    """
    rows = degrade_benchmark(output, kinds=kind or tuple(KINDS), vertex_count=vertices)
    click.echo(f"{degrade_table(rows)}\nThe curves are in {output}.")
    return 0


@bench_group.command("robustness")
@click.argument("directory", type=click.Path(path_type=Path, exists=True, file_okay=False))
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="Folder.")
@click.option("--seconds", type=float, default=60.0, show_default=True, help="Limit for one run.")
@click.option(
    "--command",
    "chosen",
    type=click.Choice(["check", "locate", "match"]),
    multiple=True,
    help="All three if none.",
)
def robustness_command(
    directory: Path, *, output: Path, seconds: float, chosen: tuple[str, ...]
) -> int:
    """Run every file of a folder through check, locate and match, as full shape and as part.

    Writes robustness.csv and robustness.json: file, what was wrong, what sherd said. Goes on where
    an interrupted run stopped. Exit code 70 if any run ended in a traceback, a hang, a wrong exit
    code or a broken output.

    \b
    Example:
      sherd bench robustness bad_meshes/ --command check -o robustness/
    """  # noqa: D301

    def tell(row: RobustnessRow) -> None:
        if row.verdict == "failed":
            click.echo(f"FAILED {row.command} {row.file}: {row.failure}")

    with tempfile.TemporaryDirectory() as scratch:
        animal = creature(5000)
        full, part = Path(scratch) / "animal.ply", Path(scratch) / "head.ply"
        write_mesh(animal, full)
        write_mesh(cut_by_ball(whole(animal, animal), 0, 0.3).mesh, part)
        names = chosen or ("check", "locate", "match")
        commands = {
            name: command
            for name, command in robustness_commands(full, part).items()
            if name.split()[0] in names
        }
        rows = robustness(directory, output, commands=commands, seconds=seconds, progress=tell)
    failures = sum(row.verdict == "failed" for row in rows)
    click.echo(f"{len(rows)} runs, {failures} failed; the table is in {output}")
    return INTERNAL if failures else 0
