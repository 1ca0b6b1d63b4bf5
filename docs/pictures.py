"""Draw docs/images anew from generated shapes: `make pictures`.

The picture of the report needs Chromium; without one the old picture stays.
"""

from __future__ import annotations

import argparse
import shutil
from pathlib import Path

from PIL import Image

import sherd
from sherd.cli.demo import demo_fragment
from sherd.drawing.picture import picture, stage
from sherd.report.write import report_of, write_report
from sherd.shapes import creature, puzzle_pieces, vase, vase_sherds
from sherd.spectral.surface_distances import SurfaceDistances

IMAGES = Path(__file__).parent / "images"
WIDTH = 1100


def save(image: Image.Image, name: str) -> None:
    """Write an opaque picture, as small as PNG can be."""
    image.convert("RGB").save(IMAGES / name, optimize=True)


def screenshot(report: Path, name: str) -> None:
    """Open a report in a browser, choose a point, and keep what is seen."""
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None:
        return
    from playwright.sync_api import sync_playwright  # noqa: PLC0415

    flags = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=flags)
        tab = browser.new_page(viewport={"width": 1280, "height": 860})
        tab.goto(report.resolve().as_uri())
        tab.evaluate("window.sherd.ready")
        tab.evaluate("window.sherd.page.select('part', 100)")
        tab.wait_for_timeout(1500)
        tab.screenshot(path=str(IMAGES / name))
        browser.close()
    with Image.open(IMAGES / name) as image:
        image.load()
    save(image, name)


def draw_puzzles() -> None:
    """An animal in pieces, each in a pose of its own, and a broken vase; of each one is missing."""
    full = creature(8000)
    poses = [creature(8000, pose=pose) for pose in ("walk", "stand", "graze", "gallop")]
    pieces = [piece.mesh for piece in puzzle_pieces(full, poses)]
    broken = [sherd_.mesh for sherd_ in vase_sherds(6, vertex_count=12_000)]
    foreign = vase_sherds(6, vertex_count=12_000, seed=1)[5].mesh
    answers = {
        "puzzle": sherd.assemble(full, pieces[:-1]),
        "sherds": sherd.assemble(vase(12_000), [*broken[:-1], foreign], rigid=True),
    }
    for name, answer in answers.items():
        save(picture(report_of(answer).exhibit, width=WIDTH, heading=False), f"{name}.png")


def main() -> None:
    """Match and locate the piece of the demo, and draw both answers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("out/pictures"), help="Reports.")
    output = parser.parse_args().output
    IMAGES.mkdir(exist_ok=True)
    fragment = demo_fragment()
    matched = sherd.match(fragment.full, fragment.mesh)
    errors = SurfaceDistances(fragment.full).between(fragment.truth, matched.points)
    write_report(matched, output / "match")
    write_report(matched, output / "truth", errors=errors)
    located = sherd.locate(fragment.full, fragment.mesh)
    write_report(located, output / "locate")
    exhibit = report_of(matched, errors=errors).exhibit
    staging = stage(exhibit)
    drawn = {"demo": None, "confidence": "confidence", "distortion": "distortion", "error": "error"}
    for name, layer in drawn.items():
        image = picture(exhibit, layer=layer, width=WIDTH, heading=False, staging=staging)
        save(image, f"{name}.png")
    exhibit = report_of(located).exhibit
    for name, layer in {"membership": "membership", "phase-field": "phase field"}.items():
        image = picture(exhibit, layer=layer, width=WIDTH, heading=False, staging=staging)
        save(image, f"{name}.png")
    screenshot(output / "match" / "report.html", "report.png")
    draw_puzzles()


if __name__ == "__main__":
    main()
