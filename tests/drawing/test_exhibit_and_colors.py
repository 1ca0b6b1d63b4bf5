from __future__ import annotations

import numpy as np
import pytest

from sherd.drawing.colors import (
    UNKNOWN,
    color_table,
    full_layer,
    layer_colors,
    oklab_from_srgb,
    part_layer,
)
from sherd.drawing.exhibit import COLOR_MAPS, Exhibit, Layer, Partner, Verdict
from sherd.energy.convergence import Convergence
from sherd.errors import InvalidMeshError, OptionError
from sherd.mesh.surface_points import SurfacePoints
from sherd.results.status import Status


@pytest.mark.parametrize("name", COLOR_MAPS)
def test_lightness_orders_the_values_of_a_color_map(name):
    lightness = oklab_from_srgb(color_table(name))[:, 0]
    steps = np.diff(lightness)
    if name == "balance":  # up to the middle and down again
        assert (steps[:120] > -1e-3).all()
        assert (steps[136:] < 1e-3).all()
    else:
        assert (steps * np.sign(lightness[-1] - lightness[0]) > -2e-3).all()
        assert abs(lightness[-1] - lightness[0]) > 0.25


def test_colors_follow_limits_and_unknown_values():
    layer = Layer("u", np.array([-1.0, 0.0, 1.0, 2.0, np.nan]), range=(0.0, 1.0))
    colors = layer_colors(layer, 5)
    table = color_table("lagoon")
    np.testing.assert_array_equal(colors[:4], table[[0, 0, 255, 255]])
    np.testing.assert_array_equal(colors[4], UNKNOWN)


def test_part_shows_the_colors_of_its_partners(exhibit):
    full, partner = exhibit.full, exhibit.partner
    source = next(layer for layer in exhibit.full_layers if layer.name == "correspondence")
    shown = part_layer(exhibit, "correspondence")
    exact = source.values[partner.points.nearest_vertices(full)]
    known = partner.known
    np.testing.assert_array_equal(shown.values[known], exact[known])
    np.testing.assert_array_equal(shown.values[~known], np.tile(UNKNOWN, (2, 1)))
    octants = part_layer(exhibit, "octant")
    assert (octants.values[~known] == -1).all()
    assert part_layer(exhibit, "mask") is None  # not carried


def test_carried_colors_are_gray_where_the_part_does_not_lie(exhibit):
    shown = full_layer(exhibit, "correspondence")
    gray = (shown.values == UNKNOWN).all(axis=1)
    np.testing.assert_array_equal(gray, ~np.asarray(exhibit.region))
    assert full_layer(exhibit, "membership") is exhibit.full_layers[0]
    alone = Exhibit("t", exhibit.full, exhibit.part, exhibit.full_layers)
    assert full_layer(alone, "correspondence") is exhibit.full_layers[1]  # no map, no partners


@pytest.mark.parametrize("status", [*Status, *Convergence])
def test_every_status_gives_a_verdict_of_few_words(status):
    verdict = Verdict.from_advice(status.advice, trusted=True)
    assert 0 < len(verdict.words.split()) <= 5
    assert verdict.advice.endswith(".")


def test_correspondence_colors_tell_ends_apart(exhibit):
    colors = exhibit.full_layers[1].values.astype(float)
    x = exhibit.full.vertices[:, 0]
    assert np.linalg.norm(colors[x.argmax()] - colors[x.argmin()]) > 80


def test_what_does_not_fit_is_refused(exhibit):
    full, part = exhibit.full, exhibit.part
    with pytest.raises(InvalidMeshError, match="layer 'u' has 3 values"):
        Exhibit("t", full, part, full_layers=(Layer("u", np.zeros(3)),))
    with pytest.raises(InvalidMeshError, match="the map has 1 points"):
        Exhibit("t", full, part, partner=Partner(SurfacePoints([0], [[1, 0, 0]])))
    with pytest.raises(InvalidMeshError, match="anchors"):
        Exhibit("t", full, part, anchors=[[0, full.vertex_count]])
    with pytest.raises(OptionError, match="kind"):
        Layer("u", np.zeros(3), "colour")
    with pytest.raises(OptionError, match="must ascend"):
        Layer("u", np.zeros(3), range=(1.0, 1.0))
    with pytest.raises(InvalidMeshError, match="confidence has shape"):
        Partner(SurfacePoints([0], [[1, 0, 0]]), confidence=np.zeros(2))


def test_region_is_the_first_mask_unless_given(exhibit):
    np.testing.assert_array_equal(exhibit.region, exhibit.full_layers[2].values)
    assert Exhibit("t", exhibit.full, exhibit.part).region.all()
