"""The page of a match with known truth: every layer of it, and what another placement changes."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.report.html import write_page
from sherd.report.write import report_of


@pytest.fixture(scope="module")
def shown(match_result_of, exhibit):
    """What the page is made of."""
    result = match_result_of(exhibit)
    errors = np.linspace(0, 0.1, result.part.vertex_count)
    return report_of(result, errors=errors).exhibit


@pytest.fixture(scope="module")
def tab(shown, shown_page, tmp_path_factory):
    path = tmp_path_factory.mktemp("match") / "report.html"
    write_page(shown, path)
    return shown_page(path)


def values(tab, name: str, placement: int) -> np.ndarray:
    """What the part shows under `name`."""
    tab.evaluate(f"window.sherd.page.setPlacement({placement})")
    tab.evaluate(f"window.sherd.page.setLayer({name!r})")
    # NaN does not survive JSON
    shown = tab.evaluate(
        "Array.from(window.sherd.page.shown.part.values, (v) => Number.isNaN(v) ? null : v)"
    )
    return np.array([np.nan if value is None else value for value in shown])


def named(layers, name: str):
    return next(layer for layer in layers if layer.name == name)


def test_every_layer_has_a_button(tab, shown) -> None:
    buttons = tab.locator("#layers .title").all_inner_texts()
    wanted = {layer.name for layer in (*shown.full_layers, *shown.part_layers)}
    assert {button.lower() for button in buttons} == {name.lower() for name in wanted}
    assert {"confidence", "distortion", "orientation", "error", "region"} <= wanted


@pytest.mark.parametrize("name", ["confidence", "distortion", "orientation", "error"])
def test_the_page_shows_the_numbers_of_the_result(tab, shown, name) -> None:
    layer = named(shown.part_layers, name)
    expected = np.clip(layer.values, *layer.limits)
    # 65,535 steps from end to end of what a layer holds
    np.testing.assert_allclose(
        np.clip(values(tab, name, 0), *layer.limits), expected, atol=np.ptp(layer.limits) / 1000
    )


def test_another_placement_shows_its_own_distortion_and_no_borrowed_truth(tab, shown) -> None:
    assert np.isnan(values(tab, "confidence", 1)).all()
    assert np.isnan(values(tab, "error", 1)).all()
    layer = named(shown.alternatives[0].part_layers, "distortion")
    twisted = np.clip(values(tab, "distortion", 1), *layer.limits)
    expected = np.clip(layer.values, *layer.limits)
    np.testing.assert_allclose(twisted, expected, atol=np.ptp(layer.limits) / 1000)
    assert np.abs(twisted - values(tab, "distortion", 0)).max() > 0.1


def test_lines_lead_where_the_shown_placement_leads(tab) -> None:
    tab.evaluate("window.sherd.page.setAnchors(true)")
    ends = []
    for placement in (0, 1):
        tab.evaluate(f"window.sherd.page.setPlacement({placement})")
        tab.evaluate("window.sherd.page.redrawOverlay()")
        ends.append(tab.evaluate("document.getElementById('overlay').innerHTML"))
    assert ends[0] != ends[1]
    assert ends[0].count("<path") == ends[1].count("<path") > 0
