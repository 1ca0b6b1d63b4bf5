"""A part that slid along the surface finds back by its neighborhoods."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sherd.arrays import Floats
from sherd.correspondence.elastic_kernel import fit_rotations
from sherd.correspondence.question import Pins
from sherd.correspondence.registration import (
    Deformation,
    elastic_strain,
    registered_to_places,
    registered_to_surface,
    surface_points,
)
from sherd.correspondence.similar_places import Look, similar_places
from sherd.correspondence.working_placement import part_queries

SLIDE = 0.03


def slid(planted) -> Floats:
    """Every vertex of the piece moved by 0.03 along the blob, around its long axis."""
    full = planted.question.full
    places, normals = full.mesh.vertices[planted.kept], full.normals[planted.kept]
    along = np.cross(normals, [0.0, 0.0, 1.0])
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
    moved = places + SLIDE * along
    return full.finder.closest(moved, normals).positions(full.mesh)


def look_of(planted) -> Look:
    question = planted.question
    queries = part_queries(question, np.random.default_rng(0))
    trust = np.ones(len(queries.vertices))
    return Look(queries.vertices, question.full.spectra, queries.cut_aware, trust)


def errors(planted, positions: Floats) -> Floats:
    distance: Floats = np.linalg.norm(
        positions - planted.question.full.mesh.vertices[planted.kept], axis=1
    )
    return distance


def test_similar_places_are_nearer_than_where_the_part_slid_to(planted) -> None:
    positions, look = slid(planted), look_of(planted)
    full = planted.question.full
    assert 0.02 < np.median(errors(planted, positions)) <= 0.031
    targets, confidence, similarity = similar_places(full, positions, look, reach=0.05)
    true = full.mesh.vertices[planted.kept][look.vertices]
    left = np.linalg.norm(targets - true, axis=1)
    before = errors(planted, positions)[look.vertices]
    assert np.median(left / before) < 0.35
    assert similarity.max() <= 1 + 1e-6
    assert similarity[planted.question.part.cut_distance[look.vertices] > 0.1].min() > 0.9
    # where equally similar places are far apart the answer is worth less
    assert confidence.min() > 0
    assert confidence.max() <= 1
    sure = confidence > np.median(confidence)
    assert left[sure].mean() < 0.7 * left[~sure].mean()


def test_what_is_where_it_belongs_stays_there(planted) -> None:
    full, look = planted.question.full, look_of(planted)
    true = full.mesh.vertices[planted.kept]
    targets, _, similarity = similar_places(full, true, look, reach=0.008)
    assert np.linalg.norm(targets - true[look.vertices], axis=1).max() < 1e-9  # alone in the ball
    # a place off the surface has the nearest vertex alone to compare with
    lifted = true + 0.05 * full.normals[planted.kept]
    targets, _, above = similar_places(full, lifted, look, reach=0.001)
    nearest = full.vertex_tree.query(lifted[look.vertices])[1]
    np.testing.assert_allclose(targets, full.mesh.vertices[nearest], atol=1e-12)
    same = nearest == planted.kept[look.vertices]
    assert same.mean() > 0.5
    np.testing.assert_allclose(above[same], similarity[same], atol=1e-6)


def test_registration_takes_the_slide_back(planted) -> None:
    question, positions, look = planted.question, slid(planted), look_of(planted)
    start = Deformation(positions, fit_rotations(question.part.elastic, positions))
    found = registered_to_surface(question, start, look, reaches=(0.05, 0.04))
    before, after = errors(planted, positions), errors(planted, found.positions)
    assert after.mean() < before.mean() / 5  # measured: 8.7 times
    assert after.max() < 0.02
    strain = elastic_strain(question.part, found).mean()
    assert strain < 0.3 * elastic_strain(question.part, start).mean()


def test_without_trust_nothing_is_drawn_anywhere(planted) -> None:
    question, positions, look = planted.question, slid(planted), look_of(planted)
    start = Deformation(positions, fit_rotations(question.part.elastic, positions))
    blind = replace(look, trust=np.zeros(len(look.vertices)))
    found = registered_to_surface(question, start, blind, reaches=(0.05,))
    assert errors(planted, found.positions).mean() > 0.7 * errors(planted, positions).mean()


def test_places_rounded_to_labels_are_averaged_and_wrong_ones_drag_nobody(planted) -> None:
    """Every place is the nearest label; one in fifty is any vertex at all."""
    question, kept = planted.question, planted.kept
    rng = np.random.default_rng(0)
    vertices, labels = question.full.mesh.vertices, question.full.dense
    places = labels.vertices[labels.cells[kept]]
    rounded = np.linalg.norm(vertices[places] - vertices[kept], axis=1).mean()
    after = errors(planted, registered_to_places(question, places).positions)
    assert after.mean() < 0.4 * rounded  # measured: 0.29
    wrong = rng.random(len(kept)) < 0.02
    spoiled = np.where(wrong, rng.integers(len(vertices), size=len(kept)), places)
    beside = errors(planted, registered_to_places(question, spoiled).positions)[~wrong]
    assert beside.mean() < 0.6 * rounded


def test_answers_lie_on_the_surface_under_the_deformed_part(planted) -> None:
    question, kept = planted.question, planted.kept
    full = question.full
    true = full.mesh.vertices[kept]
    lifted = Deformation(true + 0.004 * full.normals[kept], np.tile(np.eye(3), (len(kept), 1, 1)))
    points = surface_points(question, full.own_finder, lifted)
    assert errors(planted, points.positions(full.mesh)).max() < 0.004
    assert np.median(errors(planted, points.positions(full.mesh))) < 5e-4


def test_a_pin_holds_one_vertex_against_all_its_neighbors(planted) -> None:
    question, positions, look = planted.question, slid(planted), look_of(planted)
    deepest = int(question.part.cut_distance.argmax())
    place = question.full.mesh.vertices[planted.kept[deepest]][None] + 0.05
    pins = Pins(np.array([deepest]), place, np.zeros((1, 2), dtype=np.int64))
    pinned = replace(question, pins=pins)
    start = Deformation(positions, fit_rotations(question.part.elastic, positions))
    found = registered_to_surface(pinned, start, look, reaches=(0.05,))
    assert np.linalg.norm(found.positions[deepest] - place) < 0.01
    assert np.median(errors(planted, found.positions)) < 0.02
