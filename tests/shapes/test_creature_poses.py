"""The animal is a clean closed surface at every size, and its poses are near-isometric."""

import numpy as np
import pytest

from sherd.errors import OptionError
from sherd.mesh import topology
from sherd.mesh.geometry import edge_lengths
from sherd.shapes.creature import creature, landmarks
from sherd.shapes.skeleton import POSES, SEGMENTS


def lengths(mesh):
    ends = mesh.vertices[mesh.edges]
    return np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)


@pytest.mark.parametrize(
    ("count", "individual"), [(5_000, 0), (7_300, 0), (45_000, 0), (5_000, 3), (10_000, 8)]
)
def test_the_skin_is_one_closed_outward_surface_of_genus_zero(count, individual):
    mesh = creature(count, individual=individual)
    assert mesh.vertex_count == pytest.approx(count, rel=0.02)
    assert mesh.component_count == 1
    edges, uses = topology.unique_edges(mesh.faces)
    assert (uses == 2).all()
    assert mesh.vertex_count - len(edges) + mesh.face_count == 2
    # oriented: each directed edge occurs once, and the enclosed volume is positive
    directed = topology.half_edges(mesh.faces)
    assert len(np.unique(directed, axis=0)) == len(directed)
    corners = mesh.vertices[mesh.faces]
    assert np.linalg.det(corners).sum() / 6 > 0.05


def test_triangles_are_well_shaped():
    mesh = creature(10_000)
    quality = 4 * np.sqrt(3) * mesh.face_areas
    quality /= (edge_lengths(mesh.vertices, mesh.faces) ** 2).sum(axis=1)
    assert np.quantile(quality, 0.01) > 0.6
    assert np.median(quality) > 0.95


@pytest.mark.parametrize("pose", sorted(POSES))
def test_poses_share_their_numbering_and_keep_lengths(full, pose):
    mesh = creature(5_000, pose=pose)
    assert np.array_equal(mesh.faces, full.faces)
    change = np.abs(lengths(mesh) / lengths(full) - 1)
    assert (change < 0.10).mean() >= 0.94
    assert mesh.area == pytest.approx(full.area, rel=0.02)
    moved = np.linalg.norm(mesh.vertices - full.vertices, axis=1).max() / full.length
    assert (moved > 0.15) == (pose != "stand")


def test_the_same_options_give_the_same_bits():
    first = creature(6_000, pose="walk")
    creature.__globals__["_standing"].cache_clear()
    second = creature(6_000, pose="walk")
    assert first.vertices.tobytes() == second.vertices.tobytes()
    assert first.faces.tobytes() == second.faces.tobytes()


def test_resolutions_sample_the_same_surface(full):
    fine = creature(45_000)
    gap = np.linalg.norm(
        fine.vertices[:, None, :1] - full.vertices[landmarks(full)["nose"], :1], axis=2
    )
    assert gap.min() < 0.01
    assert fine.area == pytest.approx(full.area, rel=0.02)
    for name, vertex in landmarks(full).items():
        place = fine.vertices[landmarks(fine)[name]]
        assert np.linalg.norm(place - full.vertices[vertex]) < 0.05, name


def test_landmarks_lie_where_their_names_say(full):
    found = landmarks(full)
    segment = full.fields["segment"].astype(int)
    for name, part in (
        ("nose", "head"),
        ("tail_tip", "tail"),
        ("left_front_hoof", "left_front_leg"),
        ("right_hind_hoof", "right_hind_leg"),
    ):
        assert SEGMENTS[segment[found[name]]] == part
    place = {name: full.vertices[vertex] for name, vertex in found.items()}
    assert place["nose"][0] == full.vertices[:, 0].max()
    assert place["left_front_hoof"][1] > 0 > place["right_front_hoof"][1]
    assert set(segment) == set(range(len(SEGMENTS)))


def test_left_and_right_differ(full):
    """The mirror image fits the animal nowhere near as well as the animal itself."""
    found = landmarks(full)
    for part in ("front_hoof", "hind_hoof", "ear_tip"):
        left, right = (full.vertices[found[f"{side}_{part}"]] for side in ("left", "right"))
        assert np.linalg.norm(left - right * [1, -1, 1]) > 0.03 * full.length


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"vertex_count": 4_999}, "vertex_count is 4999"),
        ({"vertex_count": 1_000_001}, "vertex_count is 1000001"),
        ({"pose": "fly"}, "pose is 'fly', but one of stand, walk"),
        ({"individual": -1}, "individual is -1"),
    ],
)
def test_wrong_options_are_refused(options, message):
    with pytest.raises(OptionError, match=message):
        creature(**options)
