"""A part placed once more keeps what is known of it, and the answer."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.output import Stages
from sherd.place import PlacedPart, labeled_again, laid_part, placed_part
from sherd.results.match_options import MatchOptions
from sherd.scan.intake import scan_intake
from sherd.shapes import creature, cut_by_ball, whole
from sherd.surface.template import Template

SILENT = Stages(visible=False)


@pytest.fixture(scope="module")
def placed() -> PlacedPart:
    full = creature(5000)
    part = cut_by_ball(whole(creature(5000, pose="walk"), full), 0, 0.4).mesh
    return placed_part(Template(full), scan_intake(part), MatchOptions(), SILENT, twin=False)


def test_where_all_is_free_a_part_is_placed_again_to_the_last_bit(placed) -> None:
    free = np.ones(placed.template.mesh.vertex_count, dtype=bool)
    again = laid_part(labeled_again(placed, free, SILENT), SILENT)
    np.testing.assert_array_equal(
        again.best.deformation.positions, placed.best.deformation.positions
    )
    assert again.energies == placed.energies
    assert again.chance == placed.chance


def test_where_its_place_is_taken_a_part_has_a_higher_energy_and_lies_elsewhere(placed) -> None:
    free = ~placed.best.mask
    labeled = labeled_again(placed, free, SILENT)
    assert labeled.energy > 1.5 * placed.labeling_energy
    labels = labeled.asked.question.labels.vertices[labeled.labeling.labels]
    assert free[labels].all()
