"""The page in a real browser. Screenshots go to $SHERD_SCREENSHOTS if that is set."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from sherd.drawing.exhibit import Exhibit
from sherd.report.html import write_page
from sherd.report.notebook import show


@pytest.fixture(scope="module")
def large(exhibit_of_size):
    return exhibit_of_size(5)


@pytest.fixture(scope="module")
def report(large, tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "report.html"
    write_page(large, path)
    return path


@pytest.fixture(scope="module")
def small_report(exhibit, tmp_path_factory):
    path = tmp_path_factory.mktemp("small") / "report.html"
    write_page(exhibit, path)
    return path


@pytest.fixture
def opened(browser):
    """Open a file; complaints of the page and requests to elsewhere fail the test."""
    complaints, requests, pages = [], [], []

    def open_file(path: Path, **options):
        tab = browser.new_page(viewport={"width": 1400, "height": 1000}, **options)
        pages.append(tab)
        tab.on(
            "console", lambda message: message.type == "error" and complaints.append(message.text)
        )
        tab.on("pageerror", lambda error: complaints.append(str(error)))
        tab.on("request", lambda request: requests.append(request.url))
        tab.goto(path.as_uri())
        tab.evaluate("window.sherd.ready")
        tab.wait_for_function(
            "() => !window.sherd.page || window.sherd.page.stage.views.part.geometry.boundsTree"
        )
        return tab

    yield open_file
    for tab in pages:
        tab.close()
    assert complaints == []
    assert [url for url in requests if not url.startswith(("file:", "data:", "blob:"))] == []


def _keep(tab, name: str) -> None:
    folder = os.environ.get("SHERD_SCREENSHOTS")
    if folder:
        tab.screenshot(path=Path(folder) / f"{name}.png")


def _pixel(tab, side: str, vertex: int) -> dict:
    """Where a vertex is on the screen, and whether something hides it."""
    return tab.evaluate(
        """([side, vertex]) => {
            const { stage, shapes } = window.sherd.page;
            const view = stage.views[side];
            const at = view.project([...shapes[side].positions.slice(3 * vertex, 3 * vertex + 3)]);
            const box = view.element.getBoundingClientRect();
            return { x: at.x + box.left, y: at.y + box.top, hidden: at.hidden };
        }""",
        [side, vertex],
    )


def _visible_vertex(tab, side: str, candidates) -> int:
    return next(int(v) for v in candidates if not _pixel(tab, side, int(v))["hidden"])


def test_opens_within_two_seconds_and_six_megabytes(opened, report):
    assert report.stat().st_size < 6_000_000
    seconds = []
    for _ in range(3):
        tab = opened(report)
        seconds.append(tab.evaluate("window.sherd.page.timings.sinceNavigation") / 1000)
        if seconds[-1] < 2.0:  # another try only if the machine was busy
            break
    _keep(tab, "first-view")
    assert min(seconds) < 2.0
    assert tab.evaluate("document.documentElement.dataset.view") == "live"
    drawn = tab.evaluate(
        """() => {
            const canvas = document.getElementById("canvas");
            const copy = document.createElement("canvas");
            Object.assign(copy, { width: 300, height: 150 });
            const pen = copy.getContext("2d");
            pen.drawImage(canvas, 0, 0, 300, 150);
            const bytes = pen.getImageData(0, 0, 300, 150).data;
            return [0, 150].map((left) => {
                let count = 0;
                for (let i = 0; i < 45000; i++) {
                    const here = i % 300 >= left && i % 300 < left + 150;
                    count += here && bytes[4 * i + 3] > 128;
                }
                return count / 22500;
            });
        }"""
    )
    assert min(drawn) > 0.1  # both panels show a shape


@pytest.mark.parametrize("side", ["part", "full"])
def test_a_click_lights_up_the_partner_with_the_right_numbers(opened, report, large, side):
    tab = opened(report)
    partner = large.partner
    nearest = partner.points.nearest_vertices(large.full)
    if side == "part":
        part_vertex = _visible_vertex(tab, "part", range(800, 3000, 37))
        clicked = part_vertex
    else:
        clicked = _visible_vertex(tab, "full", nearest[800:3000:37])
        part_vertex = int(np.flatnonzero(nearest == clicked)[0])
    at = _pixel(tab, side, clicked)
    tab.mouse.click(at["x"], at["y"])
    numbers = large.part.vertices[part_vertex], large.full.vertices[nearest[part_vertex]]
    assert tab.inner_text("#point-heading") in ("Selected point", "Point under the pointer")
    assert f"vertex {part_vertex:,}" in tab.inner_text("#point-part")
    assert f"vertex {nearest[part_vertex]:,}" in tab.inner_text("#point-full")
    for name, expected in zip(("part", "full"), numbers, strict=True):
        shown = [float(word) for word in tab.inner_text(f"#point-{name}-at").split(",")]
        np.testing.assert_allclose(shown, expected, atol=1e-4)
    shown = float(tab.inner_text("#point-confidence"))
    assert shown == pytest.approx(partner.confidence[part_vertex], abs=1e-3)
    assert tab.locator("#overlay .ring").count() >= 2
    assert tab.locator("#overlay .line").count() >= 1
    select = f"(window.sherd.page.select('{side}', 100), window.sherd.page.timings.select)"
    times = [tab.evaluate(select) for _ in range(5)]
    assert min(times) < 50
    _keep(tab, f"click-{side}")
    tab.keyboard.press("Escape")
    assert tab.locator("#overlay .ring.pinned").count() == 0


def test_a_click_stays_fast_on_a_large_shape(opened, exhibit_of_size, tmp_path):
    write_page(
        exhibit_of_size(6), tmp_path / "large.html"
    )  # 40,962 vertices; more is slow without GPU
    tab = opened(tmp_path / "large.html")
    times = tab.evaluate(
        """() => {
            const { page } = window.sherd;
            const view = page.stage.views.full;
            const { width, height } = view.size();
            return [0, 1, 2, 3, 4].map((i) => {
                const start = performance.now();
                const vertex = view.pick(width / 2 + 5 * i, height / 2);
                page.select("full", vertex);
                return performance.now() - start;
            });
        }"""
    )
    assert np.median(times) < 50


def test_unmatched_vertices_say_so(opened, small_report):
    tab = opened(small_report)
    tab.evaluate("window.sherd.page.select('part', 5)")
    assert tab.inner_text("#point-full") == "no partner"


def test_layers_and_threshold_show_the_numbers_of_the_result(opened, small_report, exhibit):
    tab = opened(small_report)
    labels = tab.locator("#layers .title").all_text_contents()
    assert labels == ["membership", "correspondence", "mask", "octant", "confidence"]
    membership, areas = exhibit.full_layers[0].values, exhibit.full.vertex_areas
    tab.locator("#threshold").fill("0.7")
    inside = membership >= 0.7
    words = tab.inner_text("#coverage")
    assert f"{inside.sum():,} of {exhibit.full.vertex_count:,} vertices" in words
    share = 100 * areas[inside].sum() / areas.sum()
    assert float(words.split("vertices, ")[1].split(" %")[0]) == pytest.approx(share, abs=0.06)
    _keep(tab, "threshold")
    before = tab.locator("#canvas").screenshot()
    tab.get_by_text("mask", exact=True).click()
    mask = exhibit.full_layers[2].values
    assert f"{mask.sum():,} of {exhibit.full.vertex_count:,} vertices" in tab.inner_text(
        "#coverage"
    )
    assert tab.locator("#swatches .swatch").count() == 2
    tab.wait_for_timeout(100)
    assert tab.locator("#canvas").screenshot() != before
    tab.get_by_text("confidence", exact=True).click()
    tab.locator("#threshold").fill("0.6")
    count = (exhibit.part_layers[0].values >= 0.6).sum()
    assert f"Part: {count:,} of {exhibit.part.vertex_count:,}" in tab.inner_text("#coverage")
    tab.keyboard.press("2")
    assert tab.evaluate("window.sherd.page.state.layer") == "correspondence"


def test_alternatives_switch_region_and_map(opened, small_report, exhibit):
    tab = opened(small_report)
    assert tab.locator("#placements .tail").all_text_contents() == ["0.95", "0.71"]
    tab.evaluate("window.sherd.page.select('part', 200)")
    tab.get_by_text("mask", exact=True).click()
    tab.get_by_text("other half").click()
    other = exhibit.alternatives[0]
    assert f"{other.full_layers[1].values.sum():,} of" in tab.inner_text("#coverage")
    partner = other.partner
    expected = partner.points.nearest_vertices(exhibit.full)[200]
    assert f"vertex {expected:,}" in tab.inner_text("#point-full")
    assert float(tab.inner_text("#point-confidence")) == pytest.approx(
        partner.confidence[200], abs=1e-3
    )
    _keep(tab, "alternative")
    tab.keyboard.press("a")
    assert tab.evaluate("window.sherd.page.state.placement") == 0


def test_views_turn_together_or_freely(opened, small_report):
    tab = opened(small_report)
    angles = (
        "(() => { const o = window.sherd.page.orbits; return [o.full.azimuth, o.part.azimuth]; })()"
    )
    start = tab.evaluate(angles)

    def drag():
        box = tab.locator("#view-full").bounding_box()
        tab.mouse.move(box["x"] + 200, box["y"] + 200)
        tab.mouse.down()
        tab.mouse.move(box["x"] + 300, box["y"] + 210, steps=4)
        tab.mouse.up()
        return tab.evaluate(angles)

    turned = drag()
    assert turned[0] != start[0]
    assert turned[0] == turned[1]
    tab.get_by_label("Turn both together").uncheck()
    free = drag()
    assert free[0] != turned[0]
    assert free[1] == turned[1]
    tab.locator("#view-part").focus()
    tab.keyboard.press("ArrowLeft")
    assert tab.evaluate(angles)[1] != free[1]
    tab.get_by_text("Reset the view").click()
    assert tab.evaluate(angles) == pytest.approx(start)
    tab.get_by_label("Lines between anchors").check()
    # drawn with the next frame, which a busy machine delays
    tab.locator("#overlay .line.anchor").nth(9).wait_for(state="attached")
    assert tab.locator("#overlay .line.anchor").count() == 10


def test_vertex_can_be_chosen_by_number(opened, small_report):
    tab = opened(small_report)
    tab.locator("#vertex-number").fill("321")
    tab.locator("#vertex-number").press("Enter")
    assert "vertex 321" in tab.inner_text("#point-part")


def test_dark_and_light(opened, small_report):
    tab = opened(small_report, color_scheme="dark")
    background = "getComputedStyle(document.body).backgroundColor"
    dark = tab.evaluate(background)
    _keep(tab, "dark")
    tab.locator("#theme").click()
    assert tab.evaluate(background) != dark


def test_print_shows_the_picture(opened, small_report):
    tab = opened(small_report)
    assert not tab.locator(".still img").is_visible()
    tab.emulate_media(media="print")
    assert tab.locator(".still img").is_visible()
    assert not tab.locator("#canvas").is_visible()
    assert tab.evaluate("document.querySelector('.still img').naturalWidth") == 1600


def test_region_without_map(opened, exhibit, tmp_path):
    bare = Exhibit("t", exhibit.full, exhibit.part, exhibit.full_layers[:1])
    write_page(bare, tmp_path / "region.html")
    tab = opened(tmp_path / "region.html")
    tab.evaluate("window.sherd.page.select('part', 3)")
    assert tab.inner_text("#point-full") == "no map in this result"
    assert not tab.locator("#placements-card").is_visible()
    write_page(Exhibit("t", exhibit.full, exhibit.part), tmp_path / "bare.html")
    assert opened(tmp_path / "bare.html").inner_text("#legend-name").lower() == "no layer"


def test_hostile_names_do_nothing(opened, exhibit_of_size, tmp_path):
    name = (
        "</script><script>window.hacked = true</script><img src=x onerror='window.hacked = true'>"
    )
    small = exhibit_of_size(
        2, title=name, summary=(name, name), command=name, facts={name: {name: name}}
    )
    write_page(small, tmp_path / "hostile.html")
    tab = opened(tmp_path / "hostile.html")
    assert tab.evaluate("window.hacked") is None
    assert tab.inner_text("h1") == name


def test_decimated_view_keeps_the_numbers_of_the_file(opened, exhibit_of_size, tmp_path):
    exhibit = exhibit_of_size(4)
    write_page(exhibit, tmp_path / "light.html", largest=1000)
    tab = opened(tmp_path / "light.html")
    shown = tab.evaluate("[...window.sherd.page.shapes.full.numbers]")
    assert len(shown) < 1100
    assert max(shown) > 2000
    tab.locator("#vertex-side").select_option("full")
    tab.locator("#vertex-number").fill(str(shown[17]))
    tab.locator("#vertex-number").press("Enter")
    assert f"vertex {shown[17]:,}" in tab.inner_text("#point-full")
    assert "decimated" in tab.inner_text(".notice")


def test_without_webgl_a_picture_is_shown(launched, small_report):
    tab = launched(["--no-sandbox", "--disable-3d-apis"]).new_page()
    tab.goto(small_report.as_uri())
    tab.evaluate("window.sherd.ready")
    assert tab.evaluate("document.documentElement.dataset.view") == "still"
    assert tab.locator(".still img").is_visible()
    assert "WebGL" in tab.inner_text(".still figcaption")
    assert tab.locator("#command").is_visible()


def test_without_scripts_a_picture_is_shown(browser, small_report):
    tab = browser.new_page(java_script_enabled=False)
    tab.goto(small_report.as_uri())
    assert tab.locator(".still img").is_visible()
    tab.close()


def test_notebook_frame_runs(browser, exhibit, tmp_path):
    frame = show(exhibit)._repr_html_()
    (tmp_path / "cell.html").write_text(f"<!doctype html>{frame}", encoding="utf-8")
    tab = browser.new_page()
    tab.goto((tmp_path / "cell.html").as_uri())
    inner = tab.frames[1]
    inner.locator("#layers .choice").first.wait_for()
    assert inner.evaluate("document.documentElement.dataset.view") == "live"
    tab.close()
