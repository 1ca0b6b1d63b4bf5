"""locate on generated shapes, where the truth is exact."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.benchmark.metrics import region_overlap
from sherd.errors import InfeasibleError, OptionError
from sherd.locate import locate
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.region.soft_match import MatchGeometry, soft_match
from sherd.results.locate_options import LocateOptions
from sherd.results.locate_result import LocateResult
from sherd.shapes.creature import creature, landmarks
from sherd.shapes.fragment import Fragment, cut_by_ball, moved, remeshed, reordered, scaled, whole
from sherd.spectral.sampling import decimate


@pytest.fixture(scope="module")
def animal() -> TriangleMesh:
    return creature(5000)


@pytest.fixture(scope="module")
def front(animal) -> Fragment:
    """The front of the walking animal, meshed anew, turned and renumbered."""
    piece = cut_by_ball(whole(creature(5000, pose="walk"), animal), landmarks(animal)["nose"], 0.7)
    rng = np.random.default_rng(5)
    return reordered(moved(remeshed(piece, 1.15), rng), rng)


@pytest.fixture(scope="module")
def found(front) -> LocateResult:
    return locate(front.full, front.mesh)


@pytest.fixture(scope="module")
def coarse(animal) -> Fragment:
    """The front of the walking animal on 1,200 vertices, for the slower methods."""
    small, points = decimate(animal, 1200)
    walking = small.with_vertices(points.positions(creature(5000, pose="walk")))
    nose = int(
        np.linalg.norm(small.vertices - animal.vertices[landmarks(animal)["nose"]], axis=1).argmin()
    )
    return cut_by_ball(whole(walking, small), nose, 0.7)


def iou(region: LocateResult, fragment: Fragment) -> float:
    return region_overlap(fragment.full, region.mask, fragment.region)


def test_the_front_is_found(found, front) -> None:
    assert iou(found, front) > 0.85
    check = found.check()
    assert check.passed
    assert check.piece_count == 1
    assert check.decided > 0.9
    assert found.convergence.succeeded
    assert 0.8 < found.score <= 1
    assert set(found.working_vertices) == {"full", "part"}
    assert min(found.working_vertices.values()) > 1000


def test_a_leg_is_found_and_its_twin_is_reported(animal) -> None:
    walking = whole(creature(5000, pose="walk"), animal)
    leg = moved(
        remeshed(cut_by_ball(walking, landmarks(animal)["left_front_hoof"], 0.4), 1.1),
        np.random.default_rng(2),
    )
    region = locate(animal, leg.mesh)
    placements = [region.mask, *(other.mask for other in region.alternatives)]
    best = max(region_overlap(animal, mask, leg.region) for mask in placements)
    assert best > 0.75
    assert region.alternatives
    assert all(other.score <= 1 for other in region.alternatives)


def test_same_input_same_bits(found, front) -> None:
    again = locate(front.full, front.mesh)
    np.testing.assert_array_equal(again.membership, found.membership)
    np.testing.assert_array_equal(again.mask, found.mask)


def test_unit_does_not_matter(found, front) -> None:
    large = scaled(front, 1000.0)
    full = front.full.with_vertices(front.full.vertices * 1000.0)
    assert region_overlap(front.full, locate(full, large.mesh).mask, found.mask) > 0.98


def test_part_identical_to_full(animal) -> None:
    region = locate(animal, animal)
    assert region.mask.all()
    assert region.membership.min() > 0.95
    assert region.area_fraction == pytest.approx(1)


def test_part_of_one_triangle(animal) -> None:
    triangle = TriangleMesh(animal.vertices[animal.faces[10]], [[0, 1, 2]])
    region = locate(animal, triangle)
    assert np.isfinite(region.membership).all()
    assert 1 <= region.mask.sum() <= 10


def test_part_in_two_pieces(animal) -> None:
    walking = whole(creature(5000, pose="walk"), animal)
    first = cut_by_ball(walking, landmarks(animal)["nose"], 0.5).mesh
    second = cut_by_ball(walking, landmarks(animal)["tail_tip"], 0.4).mesh
    both = TriangleMesh(
        np.concatenate([first.vertices, second.vertices + 2.0]),
        np.concatenate([first.faces, second.faces + first.vertex_count]),
    )
    region = locate(animal, both)
    ends = [landmarks(animal)["nose"], landmarks(animal)["tail_tip"]]
    assert region.mask[ends].all()


def test_refusals(animal) -> None:
    large = animal.with_vertices(animal.vertices * 1.2)
    with pytest.raises(InfeasibleError, match=r"1\.44 times the area"):
        locate(animal, large)
    with pytest.raises(InfeasibleError, match=r"1e-12 times the area .* different units"):
        locate(animal, animal.with_vertices(1e-6 * animal.vertices))
    with pytest.raises(OptionError, match="method is 'magic'"):
        LocateOptions(method="magic")
    with pytest.raises(OptionError, match="solver has no effect on method 'voting', only on subs"):
        LocateOptions(solver="active-set")
    with pytest.raises(OptionError, match="basis_size is 1"):
        LocateOptions(basis_size=1)
    with pytest.raises(OptionError, match="regularity is -1"):
        LocateOptions(regularity=-1)


@pytest.mark.parametrize(
    ("method", "descriptor", "overlap"),
    [
        # measured: 0.97, 0.97, 0.46, 0.82, 0.80; by chance half an animal overlaps by 0.31
        ("logistic", "shot", 0.9),
        ("subspace", "hks", 0.9),
        ("subspace", "wks", 0.4),  # forty eigenfunctions hold few waves
        ("exponential", "shot", 0.7),
        ("full", "shot", 0.7),
    ],
)
def test_integral_matching_finds_the_front(coarse, method, descriptor, overlap) -> None:
    rounds = {"iterations": 2} if method in {"subspace", "full"} else {}
    options = LocateOptions(
        method=method, descriptor=descriptor, basis_size=40, vocabulary_size=40, **rounds
    )
    region = locate(coarse.full, coarse.mesh, options)
    check = region.check()
    assert check.lowest >= 0
    assert check.highest <= 1
    assert abs(check.area_error) < 0.05
    assert iou(region, coarse) > overlap


def test_logistic_with_words_finds_the_front(coarse) -> None:
    options = LocateOptions(method="logistic", basis_size=60)
    assert iou(locate(coarse.full, coarse.mesh, options), coarse) > 0.6


class TestSoftMatch:
    """Two samples, three places, no geometry to speak of."""

    def geometry(self, part_fraction: float) -> MatchGeometry:
        return MatchGeometry(
            sample_areas=np.array([0.5, 0.5]),
            trust=np.ones(2),
            sample_distances=np.array([[0.0, 9.0], [9.0, 0.0]]),
            areas=np.full(4, 0.25),
            part_fraction=part_fraction,
            eigenvalues=np.zeros(4),
            # all of the "basis": nothing is smoothed
            eigenvectors=(2 * np.eye(4)).astype(np.float32),
        )

    def test_similar_places_win(self) -> None:
        similarity = np.array([[0.9, 0.1, 0.1, 0.1], [0.1, 0.1, 0.9, 0.1]], dtype=np.float32)
        probability = soft_match(similarity, self.geometry(0.5))
        assert probability.argmax(axis=1).tolist() == [0, 2]
        np.testing.assert_allclose(probability.sum(axis=1), 1, rtol=1e-5)

    def test_no_place_is_used_twice(self) -> None:
        """Both samples prefer place 0, which has room for one; the second choice of one is 1."""
        similarity = np.array([[0.9, 0.895, 0.1, 0.1], [0.9, 0.1, 0.1, 0.1]], dtype=np.float32)
        probability = soft_match(similarity, self.geometry(0.5))
        used = np.array([0.25, 0.25]) @ probability
        assert used.max() < 0.25 * 1.25
        assert probability[0, 1] > 0.6

    def test_forbidden_places_get_nothing(self) -> None:
        similarity = np.array([[0.9, 0.8, 0.1, 0.1], [0.1, 0.1, 0.9, 0.1]], dtype=np.float32)
        closed = np.array([True, False, False, False])
        probability = soft_match(similarity, self.geometry(0.5), forbidden=closed)
        assert probability[:, 0].max() == 0
