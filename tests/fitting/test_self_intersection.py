"""Faces that pierce each other, against all pairs of a soup and shapes with known answers."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from sherd.fitting.mending.self_intersection import intersecting_faces, intersecting_pairs


def edge_pierces(p, q, triangle) -> bool:
    """Möller and Trumbore, *Fast, minimum storage ray-triangle intersection*, 1997."""
    first, second, start = triangle[1] - triangle[0], triangle[2] - triangle[0], p - triangle[0]
    across = np.cross(q - p, second)
    determinant = first @ across
    if determinant == 0:
        return False
    u = start @ across / determinant
    v = (q - p) @ np.cross(start, first) / determinant
    t = second @ np.cross(start, first) / determinant
    return u > 0 and v > 0 and u + v < 1 and 0 < t < 1


def pairs_one_by_one(vertices, faces) -> set[tuple[int, int]]:
    found = set()
    for f in range(len(faces)):
        for g in range(f + 1, len(faces)):
            if len(set(faces[f]) & set(faces[g])) > 1:
                continue
            for one, other in ((f, g), (g, f)):
                for k in range(3):
                    ends = faces[one][[k, (k + 1) % 3]]
                    if set(ends) & set(faces[other]):
                        continue
                    if edge_pierces(*vertices[ends], vertices[faces[other]]):
                        found.add((f, g))
    return found


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_pairs_are_those_of_all_edges_against_all_faces(seed) -> None:
    rng = np.random.default_rng(seed)
    vertices = rng.normal(size=(40, 3))
    faces = np.array([rng.choice(40, 3, replace=False) for _ in range(45)])
    found = {tuple(pair) for pair in intersecting_pairs(vertices, faces).tolist()}
    assert found == pairs_one_by_one(vertices, faces)
    assert found


def test_a_sphere_is_clean_and_two_that_overlap_meet_along_a_circle() -> None:
    sphere = trimesh.creation.icosphere(subdivisions=3)
    count = len(sphere.vertices)
    assert not intersecting_faces(sphere.vertices, sphere.faces).any()
    vertices = np.concatenate([sphere.vertices, sphere.vertices + np.array([1.0, 0.01, 0.003])])
    faces = np.concatenate([sphere.faces, sphere.faces + count])
    marked = intersecting_faces(vertices, faces)
    centers = vertices[faces[marked]].mean(axis=1)
    assert marked.any()
    assert np.abs(centers[:, 0] - 0.5).max() < 0.2  # the plane in the middle
    assert not intersecting_faces(
        np.concatenate([sphere.vertices, sphere.vertices + np.array([3.0, 0.0, 0.0])]), faces
    ).any()


def test_many_pairs_do_not_end_the_list() -> None:
    """Each of 70 upright needles pierces each of 70 sheets: more than are kept at first."""
    x = np.linspace(0, 1, 70)
    needles = [[[a, 0.0, -1.0], [a, 0.001, -1.0], [a, 0.0005, 2.0]] for a in x]
    sheets = [[[-9.0, -9.0, z], [9.0, -9.0, z], [0.5, 9.0, z]] for z in x]
    vertices = np.array(needles + sheets).reshape(-1, 3)
    faces = np.arange(len(vertices)).reshape(-1, 3)
    assert len(intersecting_pairs(vertices, faces)) == 70 * 70


def test_nothing_has_no_pairs() -> None:
    empty = np.empty((0, 3), dtype=np.int64)
    assert intersecting_pairs(np.zeros((3, 3)), empty).shape == (0, 2)
