"""The page of a fit: the slider from the template moves vertices, the scan can be laid over it."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.fitting.fit import fit
from sherd.report.html import write_page
from sherd.report.write import report_of


@pytest.fixture(scope="module")
def shown(match_result_of, exhibit):
    return report_of(fit(match_result_of(exhibit))).exhibit


@pytest.fixture(scope="module")
def tab(shown, shown_page, tmp_path_factory):
    path = tmp_path_factory.mktemp("fit") / "report.html"
    write_page(shown, path)
    return shown_page(path)


def positions(tab, shape) -> np.ndarray:
    """What is drawn, in the coordinates of the file."""
    flat = tab.evaluate("Array.from(window.sherd.page.shapes.full.positions)")
    center = tab.evaluate("window.sherd.page.shapes.full.center")
    return np.array(flat).reshape(-1, 3) + center


def test_the_slider_goes_from_the_template_to_the_fit(tab, shown) -> None:
    assert tab.locator("#fitting-card").is_visible()
    size = np.ptp(shown.full.vertices, axis=0).max()
    assert np.abs(positions(tab, shown) - shown.full.vertices).max() < 1e-4 * size
    tab.locator("#morph").fill("0")
    assert np.abs(positions(tab, shown) - shown.full_before).max() < 1e-4 * size
    tab.locator("#morph").fill("0.5")
    middle = 0.5 * (shown.full_before + shown.full.vertices)
    assert np.abs(positions(tab, shown) - middle).max() < 1e-4 * size
    tab.locator("#morph").fill("1")
    assert np.abs(positions(tab, shown) - shown.full.vertices).max() < 1e-4 * size


def test_the_views_say_what_they_show(tab) -> None:
    assert tab.locator(".caption.at-full b").inner_text() == "Fit"
    assert tab.locator(".caption.at-part b").inner_text() == "Scan"
    assert tab.locator("#view-part").get_attribute("aria-label").startswith("Scan.")


def test_the_scan_is_laid_over_the_fit(tab, shown) -> None:
    drawn = "window.sherd.page.stage.views.full.scene.children.length"
    assert tab.evaluate(drawn) == 1
    tab.locator("#overlaid").check()
    assert tab.evaluate(drawn) == 2
    place = tab.evaluate("window.sherd.page.stage.views.full.overlaid.matrix.elements")
    turn = np.array(place).reshape(4, 4).T
    own = tab.evaluate("window.sherd.page.stage.views.full.mesh.matrix.elements")
    apart = np.linalg.inv(np.array(own).reshape(4, 4).T) @ turn
    low, high = (getattr(shown.part.vertices, name)(axis=0) for name in ("min", "max"))
    center = tab.evaluate("window.sherd.page.shapes.full.center")
    assert np.allclose(apart[:3, 3], (low + high) / 2 - center, atol=1e-3)
    tab.locator("#overlaid").uncheck()
    assert tab.evaluate(drawn) == 1
