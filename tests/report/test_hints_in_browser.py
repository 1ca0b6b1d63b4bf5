"""Landmarks and regions to ignore: placed in the page, saved, read again, followed by `match`."""

from __future__ import annotations

import numpy as np
import pytest
from click.testing import CliRunner

from sherd.cli.main import main
from sherd.cli.tables import read_ignored, read_landmarks
from sherd.drawing.exhibit import Verdict
from sherd.files.mesh_files import write_mesh
from sherd.report.html import write_page
from sherd.report.stored.stored_match import read_match

COMMAND = "sherd match whole.ply 'my piece.ply' -o out/ --landmarks 'old ones.csv' --side given"


@pytest.fixture
def opened(browser, exhibit_of_size, tmp_path):
    """Open the page of the half of a sphere; complaints of the page fail the test."""
    complaints, tabs = [], []

    def open_page(*, largest: int = 200_000, subdivisions: int = 3, **changes):
        shown = exhibit_of_size(subdivisions, command=COMMAND, **changes)
        write_page(shown, tmp_path / "report.html", largest=largest)
        tab = browser.new_page(viewport={"width": 1400, "height": 1000})
        tabs.append(tab)
        tab.on("console", lambda said: said.type == "error" and complaints.append(said.text))
        tab.on("pageerror", lambda error: complaints.append(str(error)))
        tab.goto((tmp_path / "report.html").as_uri())
        tab.evaluate("window.sherd.ready")
        return tab, shown

    yield open_page
    for tab in tabs:
        tab.close()
    assert complaints == []


def pixel(tab, side: str, vertex: int) -> dict:
    return tab.evaluate(
        """([side, vertex]) => {
            const { stage, shapes } = window.sherd.page;
            const view = stage.views[side];
            view.makeTree();
            const at = view.project([...shapes[side].positions.slice(3 * vertex, 3 * vertex + 3)]);
            const box = view.element.getBoundingClientRect();
            // a mouse stands on whole pixels
            const [x, y] = [Math.round(at.x + box.left), Math.round(at.y + box.top)];
            return { x, y, hidden: at.hidden };
        }""",
        [side, vertex],
    )


def visible(tab, side: str, candidates) -> int:
    """The first vertex that nothing hides, and that a click on its pixel hits."""
    for vertex in candidates:
        at = pixel(tab, side, int(vertex))
        if at["hidden"]:
            continue
        hit = tab.evaluate(
            """([side, x, y]) => {
                const view = window.sherd.page.stage.views[side];
                const box = view.element.getBoundingClientRect();
                return view.pick(x - box.left, y - box.top);
            }""",
            [side, at["x"], at["y"]],
        )
        if hit == vertex:
            return int(vertex)
    raise AssertionError("nothing is visible")


def click(tab, side: str, vertex: int) -> None:
    at = pixel(tab, side, vertex)
    tab.mouse.click(at["x"], at["y"])


def saved(tab, button: str, folder):
    """What a button downloads."""
    with tab.expect_download() as download:
        tab.locator(button).click()
    path = folder / download.value.suggested_filename
    download.value.save_as(path)
    return path


def test_placed_in_the_page_and_followed_by_match(opened, tmp_path):
    tab, shown = opened()
    tab.get_by_text("Landmarks", exact=True).click()
    part, full = (visible(tab, side, range(40, 300, 7)) for side in ("part", "full"))
    click(tab, "part", part)
    assert f"part vertex {part}" in tab.inner_text("#landmark-next")
    click(tab, "full", full)
    for other in (21, 33):
        true = int(shown.partner.points.nearest_vertices(shown.full)[other])
        tab.evaluate(f"window.sherd.page.pickLandmark('part', {other})")
        tab.evaluate(f"window.sherd.page.pickLandmark('full', {true})")
    assert tab.locator("#landmark-list li").count() == 3
    # drawn with the next frame, which a busy machine delays
    tab.locator("#overlay .landmark-number").nth(5).wait_for(state="attached")
    assert tab.locator("#overlay .landmark-number").all_text_contents() == list("112233")

    tab.keyboard.press("i")
    spot = visible(tab, "part", range(100, 300, 11))
    at = pixel(tab, "part", spot)
    turned = tab.evaluate("window.sherd.page.orbits.part.azimuth")
    tab.mouse.move(at["x"], at["y"])
    tab.mouse.down()
    tab.mouse.move(at["x"] + 12, at["y"], steps=3)
    tab.mouse.up()
    assert tab.evaluate("window.sherd.page.orbits.part.azimuth") == turned
    pairs = read_landmarks(saved(tab, "#save-landmarks", tmp_path))
    ignored = read_ignored(saved(tab, "#save-ignored", tmp_path))
    assert (pairs[0].tolist(), pairs[1][0]) == ([part, 21, 33], full)
    assert spot in ignored
    assert not set(ignored.tolist()) & set(pairs[0].tolist())
    gap = np.linalg.norm(shown.part.vertices[ignored] - shown.part.vertices[spot], axis=1)
    assert gap.max() < 0.3 * np.ptp(shown.part.vertices, axis=0).max()
    assert tab.inner_text("#hints-command") == (
        "sherd match whole.ply 'my piece.ply' -o out/ --side given "
        "--landmarks landmarks.csv --ignore ignore.csv"
    )

    write_mesh(shown.full, tmp_path / "whole.ply")
    write_mesh(shown.part, tmp_path / "my piece.ply")
    words = ["match", str(tmp_path / "whole.ply"), str(tmp_path / "my piece.ply"), "-q",
             "-o", str(tmp_path / "out"), "--side", "given",
             "--landmarks", str(tmp_path / "landmarks.csv"),
             "--ignore", str(tmp_path / "ignore.csv")]  # fmt: skip
    run = CliRunner().invoke(main, words, standalone_mode=False)
    assert run.exit_code in (0, 4), run.output  # a landmark that leads astray may make it doubtful
    result = read_match(tmp_path / "out")
    assert not result.matched[ignored].any()
    assert result.options.landmarks == tuple(zip(*(side.tolist() for side in pairs), strict=True))
    gaps = np.linalg.norm(result.positions[pairs[0]] - shown.full.vertices[pairs[1]], axis=1)
    length = np.sqrt(shown.full.area)
    assert gaps.max() < 0.01 * length
    # the pair that was clicked leads astray, so the answer follows the landmark and not the shape
    truth = shown.partner.points.positions(shown.full)[part]
    assert np.linalg.norm(result.positions[part] - truth) > 0.1 * length


def test_saved_files_are_read_again(opened, tmp_path):
    tab, shown = opened(landmarks=((3, 40), (9, 50)), ignored=(100, 101))
    assert tab.evaluate("window.sherd.page.hints.landmarks") == [
        {"part": 3, "full": 40},
        {"part": 9, "full": 50},
    ]
    tab.get_by_text("Ignore", exact=True).click()
    tab.locator("#brush-vertex").fill("200")
    tab.locator("#brush-form button").click()
    before = tab.evaluate("window.sherd.page.hints.ignoredNumbers")
    assert {100, 101, 200} <= set(before)
    files = [saved(tab, button, tmp_path) for button in ("#save-landmarks", "#save-ignored")]
    other, _ = opened()
    other.keyboard.press("p")
    other.locator("#load-hints").set_input_files(files)
    other.get_by_text("2 landmarks from landmarks.csv").wait_for()
    assert other.evaluate("window.sherd.page.hints.ignoredNumbers") == before
    assert other.locator("#landmark-list li").count() == 2
    other.get_by_label("Delete landmark 1").click()
    assert other.locator("#landmark-list li").all_inner_texts()[0].startswith("part 9, full 50")
    (tmp_path / "bad.csv").write_text("part_vertex,full_vertex\n1,999999\n", encoding="utf-8")
    other.locator("#load-hints").set_input_files(tmp_path / "bad.csv")
    last = shown.full.vertex_count - 1
    other.get_by_text(
        f"bad.csv: row 2: 999999 is no vertex of the full shape, which has 0..{last}."
    ).wait_for()


def test_the_brush_erases_and_spares_landmarks(opened):
    tab, _ = opened()
    tab.get_by_text("Landmarks", exact=True).click()
    tab.locator("#landmark-part").fill("50")
    tab.locator("#landmark-full").fill("60")
    tab.locator("#landmark-form button").click()
    tab.keyboard.press("Escape")
    tab.get_by_text("Ignore", exact=True).click()
    tab.locator("#brush-radius").fill("30")
    tab.evaluate("window.sherd.page.brushNumber(50)")
    many = tab.evaluate("window.sherd.page.hints.ignoredNumbers")
    assert len(many) > 20
    assert 50 not in many
    tab.get_by_text("Erase", exact=True).click()
    tab.locator("#brush-radius").fill("10")
    tab.evaluate("window.sherd.page.brushNumber(50)")
    assert 0 < len(tab.evaluate("window.sherd.page.hints.ignoredNumbers")) < len(many)
    tab.get_by_text("Ignore nothing").click()
    assert tab.locator("#save-ignored").is_disabled()


def test_a_decimated_view_ignores_every_vertex_of_the_file(opened):
    tab, shown = opened(subdivisions=4, largest=600)
    tab.keyboard.press("i")
    tab.locator("#brush-radius").fill("20")
    tab.evaluate("window.sherd.page.brush(10)")
    numbers = tab.evaluate("window.sherd.page.hints.ignoredNumbers")
    marked = tab.evaluate("window.sherd.page.hints.ignored.filter((value) => value).length")
    assert len(numbers) > 1.5 * marked
    inside = np.isin(shown.part.faces, numbers)
    cut = inside.any(axis=1) & ~inside.all(axis=1)
    assert cut.sum() < 0.5 * inside.any(axis=1).sum()  # a patch, no scattered points


def test_a_vertex_that_does_not_exist_is_refused_in_words(opened):
    tab, shown = opened()
    assert shown.full.vertex_count == 642
    tab.locator("#vertex-side").select_option("full")
    for wanted in ("642", "-1", "2.5", ""):
        tab.locator("#vertex-number").fill(wanted)
        tab.locator("#vertex-form button").click()
        assert tab.inner_text("#vertex-message") == (
            f"{wanted or 'nothing'} is no vertex of the full shape, which has 0..641."
        )
        tab.locator("#vertex-number").fill("641")
        tab.locator("#vertex-form button").click()
        assert tab.inner_text("#vertex-message") == ""
        assert "vertex 641" in tab.inner_text("#point-full")
        tab.evaluate("window.sherd.page.select('full', 3)")  # or the next word finds the old answer


def test_what_has_no_partner_is_gray_on_both_shapes(opened):
    tab, shown = opened()
    tab.evaluate("window.sherd.page.setLayer('correspondence')")
    for placement, region in ((0, shown.region), (1, ~np.asarray(shown.region))):
        tab.evaluate(f"window.sherd.page.setPlacement({placement})")
        colors = {
            side: np.array(
                tab.evaluate(f"[...window.sherd.page.stage.views.{side}.colors]")
            ).reshape(-1, 4)[:, :3]
            for side in ("full", "part")
        }
        gray = tab.evaluate("window.sherd.page.palette.unknown")
        np.testing.assert_array_equal((colors["full"] == gray).all(axis=1), ~np.asarray(region))
        np.testing.assert_array_equal((colors["part"] == gray).all(axis=1), ~shown.partner.known)


def test_the_verdict_stands_first(opened):
    tab, _ = opened(verdict=Verdict("Doubtful", trusted=False, advice="Check the scale."))
    assert tab.inner_text("#verdict").split("\n") == ["Doubtful", "Check the scale."]
    box, views = tab.locator("#verdict").bounding_box(), tab.locator(".views").bounding_box()
    assert box["y"] + box["height"] < views["y"]
    doubted = tab.evaluate("getComputedStyle(document.getElementById('verdict')).backgroundColor")
    calm, _ = opened(verdict=Verdict("Good", trusted=True))
    color = calm.evaluate("getComputedStyle(document.getElementById('verdict')).backgroundColor")
    assert doubted != color
