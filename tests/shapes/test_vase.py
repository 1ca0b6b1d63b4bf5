"""A vase and its sherds: solid, and all that lies on a wall lies there on the whole."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from sherd.errors import OptionError
from sherd.mesh.surface_points import closest_points
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes import Sherd, vase, vase_sherds


def is_solid(mesh: TriangleMesh) -> bool:
    solid = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    return bool(solid.is_watertight and solid.volume > 0)


def at_home(sherd: Sherd) -> np.ndarray:
    return sherd.mesh.vertices @ sherd.transform[:3, :3].T + sherd.transform[:3, 3]


def off(sherd: Sherd, full: TriangleMesh) -> np.ndarray:
    """How far what lies on a wall is off, in sqrt(area)."""
    home = at_home(sherd)[sherd.on_wall]
    return np.linalg.norm(closest_points(full, home).positions(full) - home, axis=1) / full.length


@pytest.fixture(scope="module")
def full() -> TriangleMesh:
    return vase(8000, seed=3)


@pytest.mark.parametrize("count", [5000, 20_000])
def test_a_vase_is_solid_and_has_about_as_many_vertices_as_wanted(count) -> None:
    full = vase(count)
    assert is_solid(full)
    assert 0.95 * count < full.vertex_count < count + 3000
    assert np.ptp(full.vertices[:, 2]) == pytest.approx(1.0, abs=0.1)


def test_sherds_are_solid_and_fit_the_vase_together(full) -> None:
    sherds = vase_sherds(5, vertex_count=8000, seed=3)
    assert all(is_solid(each.mesh) for each in sherds)
    walls = [each.mesh.vertex_areas[each.on_wall].sum() for each in sherds]
    assert sum(walls) == pytest.approx(full.area, rel=0.15)
    for each in sherds:
        assert np.linalg.det(each.transform[:3, :3]) == pytest.approx(1.0)
        assert np.median(off(each, full)) < 5e-4


def test_another_seed_is_another_relief_of_the_same_profile(full) -> None:
    other = vase_sherds(2, vertex_count=8000, seed=4)[0]
    assert 1e-3 < np.median(off(other, full)) < 0.03


def test_noise_and_wear_are_what_they_say(full) -> None:
    clean, noisy, worn = (
        vase_sherds(2, vertex_count=8000, seed=3, **each)[0]
        for each in ({}, {"noise": 0.005}, {"worn": 0.02})
    )
    apart = np.linalg.norm(at_home(noisy) - at_home(clean), axis=1) / full.length
    assert np.sqrt((apart**2).mean() / 3) == pytest.approx(0.005, rel=0.05)
    assert worn.mesh.area < clean.mesh.area


def test_a_plain_vase_is_round() -> None:
    plain = vase(5000, relief=0.0)
    radius = np.hypot(*plain.vertices[:, :2].T)
    waist = np.abs(plain.vertices[:, 2] - 0.5) < 0.02
    outer = radius[waist] > 0.3
    assert np.ptp(radius[waist][outer]) < 2e-3


def test_the_same_seed_gives_the_same_sherds() -> None:
    one, other = (vase_sherds(2, vertex_count=5000, seed=2) for _ in range(2))
    for here, there in zip(one, other, strict=True):
        assert np.array_equal(here.mesh.vertices, there.mesh.vertices)
        assert np.array_equal(here.transform, there.transform)


@pytest.mark.parametrize(
    "wrong",
    [
        {"count": 1},
        {"vertex_count": 100},
        {"relief": 0.1},
        {"noise": -1.0},
        {"worn": float("nan")},
    ],
)
def test_what_cannot_be_made_is_refused(wrong) -> None:
    with pytest.raises(OptionError):
        vase_sherds(**wrong)
