"""Fragments know exactly where they belong, whatever was done to them."""

import numpy as np
import pytest

from sherd.errors import InfeasibleError, InputError, OptionError
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes.clip import clip
from sherd.shapes.creature import landmarks
from sherd.shapes.fragment import (
    Fragment,
    cut_by_ball,
    cut_by_plane,
    cut_in_pieces,
    decimated,
    largest_piece,
    moved,
    noisy,
    punch_holes,
    remeshed,
    reordered,
    scaled,
    unevenly_sampled,
    whole,
    with_clutter,
    with_flipped_faces,
)
from sherd.shapes.truth import true_region

POINT, NORMAL = np.array([0.1, 0.0, 0.0]), np.array([1.0, 0.2, 0.1])


@pytest.fixture(name="animal", scope="module")
def _animal(full, posed):
    return whole(posed, full)


@pytest.fixture(name="front", scope="module")
def _front(animal):
    return cut_by_plane(animal, POINT, NORMAL)


@pytest.fixture(name="holed", scope="module")
def _holed(front):
    return punch_holes(front, 4, radius=0.06, rng=np.random.default_rng(0))


def gap(fragment, posed):
    """Distance of each vertex from its truth on the pose it was cut from, over the length."""
    difference = fragment.truth.positions(posed) - fragment.mesh.vertices
    return np.linalg.norm(difference, axis=1) / posed.length


def iou(left, right, weights):
    return weights[left & right].sum() / weights[left | right].sum()


def test_truth_of_the_whole_is_the_identity(animal, full):
    assert np.array_equal(animal.truth.nearest_vertices(full), np.arange(full.vertex_count))
    assert animal.region.all()


def test_truth_is_exact_through_cuts_holes_and_remeshing(animal, front, holed, full, posed):
    ball = cut_by_ball(front, landmarks(full)["nose"] % front.mesh.vertex_count, 0.3)
    for fragment in (front, holed, ball, remeshed(holed, 0.9), decimated(holed, 1_500)):
        assert gap(fragment, posed).max() < 1e-12
        assert fragment.present.all()
        assert 0 < fragment.mesh.area < animal.mesh.area


def test_truth_stays_near_when_remeshed_twice(front, posed):
    twice = remeshed(remeshed(front, 1.0), 1.3)
    assert gap(twice, posed).mean() < 0.004
    assert gap(twice, posed).max() < 0.03


def test_complementary_cuts_add_up(front, animal, full, posed):
    back = cut_by_plane(animal, POINT, -NORMAL)
    total = front.mesh.area + back.mesh.area
    assert total == pytest.approx(posed.area, rel=1e-12)
    # each vertex belongs to one side, except where the cut halves its area
    both, none = front.region & back.region, ~front.region & ~back.region
    assert (both | none).mean() < 0.002
    assert ((front.mesh.vertices - POINT) @ NORMAL).min() > -0.02 * posed.mean_edge_length * 2
    area = full.vertex_areas
    above = (posed.vertices - POINT) @ NORMAL > 0
    assert iou(front.region, above, area) > 0.99


def test_the_cut_leaves_no_crack_and_keeps_orientation(front, posed):
    border = front.mesh.boundary_vertices
    height = np.abs((front.mesh.vertices[border] - POINT) @ NORMAL)
    assert height.max() < 0.05 * posed.mean_edge_length
    assert (front.mesh.face_areas > 0).all()
    # same outward normal as the face of the pose it lies on
    centers = front.mesh.faces[:, 0]
    agreement = np.einsum(
        "mc,mc->m",
        front.mesh.face_normals,
        posed.vertex_normals[front.truth.nearest_vertices(posed)[centers]],
    )
    assert np.quantile(agreement, 0.01) > 0.5


def test_clip_by_hand():
    triangle = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    tip, points = clip(triangle, np.array([1.0, -1.0, -3.0]))
    assert tip.area == pytest.approx(0.5 * 0.5 * 0.25)
    assert np.array_equal(points.positions(triangle), tip.vertices)
    rest, _ = clip(triangle, -np.array([1.0, -1.0, -3.0]))
    assert rest.area + tip.area == pytest.approx(0.5)
    half, _ = clip(triangle, np.array([0.0, 1.0, -1.0]))
    assert half.area == pytest.approx(0.25)
    assert half.face_normals[:, 2].min() == 1
    # nearly through a corner: through the corner
    snapped, _ = clip(triangle, np.array([0.001, 1.0, -1.0]))
    assert snapped.face_count == 1


def test_the_region_does_not_depend_on_the_sampling_of_the_part(front, full):
    area = full.vertex_areas
    for other in (remeshed(front, 2.0), decimated(front, 600)):
        assert iou(other.region, front.region, area) > 0.98
    covered = area[front.region].sum() / full.area
    assert covered == pytest.approx(
        front.truth.positions(full).shape[0] / full.vertex_count, abs=0.05
    )
    with pytest.raises(InputError, match="truth has 3 rows"):
        true_region(full, front.mesh, front.truth[[0, 1, 2]])


def test_disguises_keep_the_truth(front, full, posed):
    rng = np.random.default_rng(4)
    turned = moved(scaled(front, 2.5), rng)
    before, after = (x.vertices[x.edges] for x in (front.mesh, turned.mesh))
    ratio = np.linalg.norm(after[:, 1] - after[:, 0], axis=1) / np.linalg.norm(
        before[:, 1] - before[:, 0], axis=1
    )
    np.testing.assert_allclose(ratio, 2.5, rtol=1e-9)
    # a rotation, not a reflection: signed volumes keep their sign
    corner = np.array([0, 40, 900, 2000])
    volumes = [
        np.linalg.det(np.diff(x.vertices[corner], axis=0)) for x in (front.mesh, turned.mesh)
    ]
    assert volumes[1] == pytest.approx(2.5**3 * volumes[0], rel=1e-9)
    shuffled = reordered(front, rng)
    assert gap(shuffled, posed).max() < 1e-12
    assert not np.array_equal(shuffled.mesh.vertices, front.mesh.vertices)
    np.testing.assert_allclose(
        np.sort(shuffled.mesh.face_areas), np.sort(front.mesh.face_areas), rtol=1e-9
    )
    shaken = noisy(front, 0.002, rng=rng)
    offset = (shaken.mesh.vertices - front.mesh.vertices) / full.length
    assert offset.std() == pytest.approx(0.002, rel=0.05)
    flipped = with_flipped_faces(front, 0.1, rng=rng)
    wrong = np.einsum("mc,mc->m", flipped.mesh.face_normals, front.mesh.face_normals) < 0
    assert wrong.mean() == pytest.approx(0.1, abs=0.03)
    for other in (turned, shuffled, shaken, flipped):
        # a reordered face breaks ties between its corners elsewhere
        assert (other.region != front.region).mean() < 0.001


def test_clutter_belongs_nowhere(front):
    cluttered = with_clutter(front, 0.05, rng=np.random.default_rng(1))
    extra = ~cluttered.present
    assert cluttered.mesh.component_count == front.mesh.component_count + 1
    added = cluttered.mesh.area - front.mesh.area
    assert added == pytest.approx(0.05 * front.mesh.area, rel=0.35)
    assert np.isnan(cluttered.mesh.fields["segment"][extra]).all()
    assert np.array_equal(cluttered.region, front.region)
    # what is made from clutter is clutter
    again = remeshed(cluttered, 1.2)
    assert 0 < (~again.present).sum() < 0.2 * again.mesh.vertex_count
    assert largest_piece(cluttered).present.all()


def test_the_same_seed_gives_the_same_bits(front):
    def made():
        rng = np.random.default_rng(11)
        holed = punch_holes(front, 2, radius=0.05, rng=rng)
        return moved(with_clutter(remeshed(holed, 1.1), 0.1, rng=rng), rng)

    first, second = made(), made()
    assert first.mesh.vertices.tobytes() == second.mesh.vertices.tobytes()
    assert first.truth.barycentric.tobytes() == second.truth.barycentric.tobytes()
    assert np.array_equal(first.region, second.region)


def test_impossible_requests_are_refused(animal, front, full):
    with pytest.raises(InfeasibleError, match="leaves nothing"):
        cut_by_plane(animal, [9, 0, 0], [1, 0, 0])
    with pytest.raises(InfeasibleError, match="leaves nothing"):
        punch_holes(front, 1, radius=50.0, rng=np.random.default_rng(0))
    for call, message in (
        (lambda: cut_by_plane(animal, [0, 0, 0], [0, 0, 0]), "normal is"),
        (lambda: cut_by_ball(animal, 0, -1.0), "radius is -1"),
        (lambda: scaled(animal, 0.0), "factor is 0"),
        (lambda: with_clutter(front, 0.0, rng=np.random.default_rng(0)), "share is 0"),
        (lambda: decimated(front, 10), "on its border"),
    ):
        with pytest.raises(OptionError, match=message):
            call()
    with pytest.raises(InputError, match="same vertices and faces"):
        whole(front.mesh, full)
    with pytest.raises(InputError, match="truth has 1 rows"):
        Fragment(front.mesh, SurfacePoints([0], [[1, 0, 0]]), full, front.present)


def test_uneven_sampling_keeps_the_surface_and_reaches_the_ratio(front, posed):
    uneven = unevenly_sampled(front, 10.0)
    assert gap(uneven, posed).max() < 1e-12
    assert uneven.mesh.area == pytest.approx(front.mesh.area, rel=1e-12)
    axis = np.linalg.eigh(np.cov(front.mesh.vertices.T))[1][:, -1]
    place = uneven.mesh.vertices @ axis
    density = [
        ends.sum() / uneven.mesh.vertex_areas[ends].sum()
        for ends in (place < np.quantile(place, 0.02), place > np.quantile(place, 0.98))
    ]
    assert 6 < max(density) / min(density) < 25
    with pytest.raises(OptionError, match="ratio is"):
        unevenly_sampled(front, 0.5)


def test_pieces_are_apart_and_know_their_places(front, posed):
    pieces = cut_in_pieces(front, 3, width=0.05)
    assert pieces.mesh.component_count >= 3
    assert gap(pieces, posed).max() < 1e-12
    assert 0.6 < pieces.mesh.area / front.mesh.area < 1
    assert cut_in_pieces(front, 1, width=0.05).mesh is front.mesh
