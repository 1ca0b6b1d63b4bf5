from __future__ import annotations

import io
import time

import numpy as np
import pytest
import trimesh
from PIL import Image
from scipy.spatial.transform import Rotation

from sherd.drawing.alignment import rotation_to_full
from sherd.drawing.camera import best_view, orbit_view, upward
from sherd.drawing.color_bar import ticks
from sherd.drawing.exhibit import Exhibit, Layer
from sherd.drawing.picture import picture, png_bytes, stage, write_picture
from sherd.drawing.raster_kernel import BAND, covered_faces, shaded_image
from sherd.errors import OptionError, OutputError
from sherd.mesh.triangle_mesh import TriangleMesh


def test_rasterizer_covers_the_exact_area_and_keeps_the_nearest():
    # two right triangles of 50 x 50 pixels, the second one in front
    points = np.array(
        [[10, 10, 1], [60, 10, 1], [10, 60, 1], [10, 10, 0], [60, 10, 0], [60, 60, 0]], dtype=float
    )
    seen = covered_faces(points, np.array([[0, 1, 2], [3, 4, 5]]), width=80, height=80)
    assert abs((seen == 1).sum() - 1250) <= 50
    assert abs((seen == 0).sum() - 625) <= 50
    assert (seen[:10] == -1).all()


def test_faces_larger_than_a_tile_are_hidden_by_those_before_them_only():
    rng = np.random.default_rng(0)
    points = rng.uniform([-30, -30, 0], [150, 120, 9], size=(90, 3))
    faces = rng.integers(90, size=(400, 3))
    depth, expected = np.full((90, 120), np.inf), np.full((90, 120), -1)
    y, x = np.mgrid[:90, :120] + 0.5
    for index, (a, b, c) in enumerate(points[faces]):
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if area == 0:
            continue
        u = ((b[0] - x) * (c[1] - y) - (b[1] - y) * (c[0] - x)) / area
        v = ((c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x)) / area
        z = u * a[2] + v * b[2] + (1 - u - v) * c[2]
        seen = (u >= 0) & (v >= 0) & (u + v <= 1) & (z < depth)
        depth[seen], expected[seen] = z[seen], index
    found = covered_faces(points, faces, width=120, height=90)
    assert (found != expected).sum() <= 2  # pixels on an edge, by rounding


def test_a_large_face_many_times_over_is_drawn_once():
    """Half of its tiles are never full, so every copy would be drawn into them."""
    corners = np.array([[1.0, 1.0, 2.0], [1500.0, 20.0, 1.0], [300.0, 1200.0, 3.0]])
    copies = 20_000
    points = np.tile(corners, (copies, 1))
    faces = np.arange(3 * copies).reshape(-1, 3)
    once = covered_faces(corners, faces[:1], width=1600, height=1300)
    start = time.perf_counter()
    found = covered_faces(points, faces, width=1600, height=1300)
    assert time.perf_counter() - start < 10  # 60 s when each is drawn
    np.testing.assert_array_equal(found >= 0, once >= 0)


def test_a_fan_of_slivers_costs_little_and_has_no_gaps():
    """A disk as one polygon of 20,000 corners: each triangle's box is as large as the picture."""
    around = np.linspace(0, 2 * np.pi, 20_001)[:-1]
    ring = np.stack([800 + 700 * np.cos(around), 650 + 600 * np.sin(around), 0 * around], axis=1)
    inner = np.arange(1, 19_999)
    faces = np.stack([np.zeros(19_998, dtype=np.int64), inner, inner + 1], axis=1)
    start = time.perf_counter()
    found = covered_faces(ring, faces, width=1600, height=1300)
    assert time.perf_counter() - start < 20  # minutes when each tile of each box is looked at
    assert (found >= 0).sum() == pytest.approx(np.pi * 700 * 600, rel=1e-3)


def test_orientation_decides_what_is_inside():
    points = np.array([[0, 0, 0], [0, 9, 0], [9, 0, 0]], dtype=float)  # counterclockwise on screen
    normals = np.tile([0.0, 0.0, 1.0], (3, 1))
    red = np.tile(np.array([200, 30, 30], dtype=np.uint8), (3, 1))
    shapes = {"normals": normals, "colors": red, "width": 9, "height": 9}
    outside = shaded_image(points, np.array([[0, 1, 2]]), **shapes)[2, 2]
    inside = shaded_image(points, np.array([[0, 2, 1]]), **(shapes | {"normals": -normals}))[2, 2]
    assert outside[0] > 150
    mixed = shaded_image(
        points, np.array([[0, 2, 1]]), **(shapes | {"normals": -normals}), two_sided=True
    )[2, 2]
    np.testing.assert_array_equal(mixed, outside)
    assert int(outside[0]) - int(outside[1]) > 2 * (int(inside[0]) - int(inside[1]))


def test_nothing_is_seen_where_there_are_no_faces():
    none = np.empty((0, 3), dtype=np.int64)
    assert (covered_faces(np.zeros((3, 3)), none, width=4, height=3) == -1).all()


def test_what_reaches_over_bands_of_rows_is_drawn_whole():
    rng = np.random.default_rng(1)
    height, width, samples = 2 * BAND // 3 + 40, 50, 3
    points = rng.uniform([-10, -10, 0], [width + 10, height + 10, 9], size=(120, 3))
    faces = rng.integers(120, size=(60, 3))
    faces = faces[(np.diff(np.sort(faces, axis=1), axis=1) > 0).all(axis=1)]
    image = shaded_image(
        points, faces, normals=np.tile([0.0, 0.0, 1.0], (120, 1)),
        colors=rng.integers(255, size=(120, 3), dtype=np.uint8), width=width, height=height,
    )  # fmt: skip
    fine = points * [samples, samples, 1.0]
    seen = covered_faces(fine, faces, width=samples * width, height=samples * height) >= 0
    share = seen.reshape(height, samples, width, samples).mean(axis=(1, 3))
    np.testing.assert_array_equal(image[..., 3], (255 * share + 0.5).astype(np.uint8))


def test_picture_shows_the_mask_and_repeats_to_the_bit(exhibit):
    image = picture(exhibit, layer="mask", width=800)
    pixels = np.asarray(image).astype(int)
    left = pixels[:, :400]
    orange = (left[..., 0] - left[..., 2] > 60).mean()
    gray = ((np.ptp(left[..., :3], axis=2) < 15) & (left[..., 0] < 240)).mean()
    assert orange > 0.05
    assert gray > 0.02
    assert png_bytes(image) == png_bytes(picture(exhibit, layer="mask", width=800))


def test_each_layer_and_background(exhibit):
    pictures = {name: np.asarray(picture(exhibit, layer=name, width=500)) for name in
                ("membership", "correspondence", "mask", "octant", "confidence")}  # fmt: skip
    assert len({image.tobytes() for image in pictures.values()}) == 5
    clear = np.asarray(picture(exhibit, width=500, transparent=True))
    assert clear[0, 0, 3] == 0
    assert np.asarray(picture(exhibit, width=500))[0, 0].tolist() == [255, 255, 255, 255]
    with pytest.raises(OptionError, match="layer is 'no such'"):
        picture(exhibit, layer="no such")
    with pytest.raises(OptionError, match="400"):
        picture(exhibit, width=10)


def test_picture_without_layers_and_of_one_triangle():
    triangle = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    image = np.asarray(picture(Exhibit("bare", triangle, triangle), width=500))
    assert (image[80:200] < 230).any()


def test_ten_thousand_vertices_take_less_than_a_second(exhibit_of_size):
    large = exhibit_of_size(5)
    picture(large, width=500)  # compiles on the first run
    start = time.process_time()
    picture(large)
    assert time.process_time() - start < 1.0


def test_written_file_is_an_image_and_bad_folder_an_error(exhibit, tmp_path):
    write_picture(exhibit, tmp_path / "a.png")
    with Image.open(io.BytesIO((tmp_path / "a.png").read_bytes())) as image:
        assert image.format == "PNG"
        assert image.width == 1600
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError):
        write_picture(exhibit, tmp_path / "file" / "a.png")


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_camera_faces_the_marked_cap(exhibit, axis):
    full = exhibit.full
    for sign in (1.0, -1.0):
        up = np.eye(3)[(axis + 1) % 3]
        marked = sign * full.vertices[:, axis] > 0.6 * np.abs(full.vertices[:, axis]).max()
        view = best_view(full, marked, up)
        assert sign * view.rotation[2, axis] > 0.4
        assert view.visible_share > 0.7
        np.testing.assert_allclose(view.rotation @ view.rotation.T, np.eye(3), atol=1e-12)
        assert view.rotation[1] @ up > 0  # never upside down


def test_views_are_rotations_with_up_upward():
    for azimuth in (0.0, 77.0, 251.0):
        rotation = orbit_view(np.array([0.0, 0.0, 1.0]), azimuth, 30.0)
        assert np.linalg.det(rotation) == pytest.approx(1)
        assert rotation[2, 2] == pytest.approx(0.5)


def _four_legged(length_axis: int, up_axis: int) -> TriangleMesh:
    def box(center, size):
        body = trimesh.creation.box(size)
        body.vertices += center
        return body

    parts = [box([0, 0, 1], [2, 0.6, 0.5]), box([1.2, 0, 1.4], [0.5, 0.3, 0.4])]
    parts += [box([x, y, 0.4], [0.2, 0.2, 0.8]) for x in (-0.8, 0.8) for y in (-0.2, 0.2)]
    beast = trimesh.util.concatenate(parts).subdivide().subdivide()
    side_axis = 3 - length_axis - up_axis
    vertices = np.empty_like(beast.vertices)
    vertices[:, [length_axis, side_axis, up_axis]] = beast.vertices
    return TriangleMesh(vertices, beast.faces)


@pytest.mark.parametrize(("length_axis", "up_axis"), [(0, 1), (0, 2), (1, 2), (2, 1)])
def test_four_legged_animals_stand(length_axis, up_axis):
    assert upward(_four_legged(length_axis, up_axis)).tolist() == np.eye(3)[up_axis].tolist()


def test_part_is_turned_onto_its_place(exhibit):
    turn = Rotation.from_rotvec([0.4, 1.1, -0.7]).as_matrix()
    np.testing.assert_allclose(rotation_to_full(exhibit), turn.T, atol=1e-6)
    # without a map the shapes alone must do: the region is the exact half here
    blind = Exhibit("t", exhibit.full, exhibit.part, region=exhibit.region)
    found = rotation_to_full(blind)
    angle = np.degrees(Rotation.from_matrix(found @ turn).magnitude())
    assert angle < 10
    assert stage(blind).part_rotation == pytest.approx(found)


def test_inverted_mesh_is_noticed(exhibit):
    full = exhibit.full
    assert full.winding == 1
    assert TriangleMesh(full.vertices, full.faces[:, ::-1]).winding == -1
    mixed = full.faces.copy()
    mixed[:100] = mixed[:100, ::-1]
    assert TriangleMesh(full.vertices, mixed).winding == 0


def test_ticks_are_round_and_inside():
    assert ticks(0.0, 1.0) == [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]
    assert ticks(-3.0, 41.0) == [0.0, 10.0, 20.0, 30.0, 40.0]
    for low, high in [(1e-9, 3e-9), (-7.3, -7.1), (5.0, 5e8)]:
        found = ticks(low, high)
        assert 3 <= len(found) <= 7
        assert min(found) >= low - 1e-12 * abs(low)
        assert max(found) <= high + 1e-12 * abs(high)


def test_unknown_values_are_drawn(exhibit):
    hidden = Layer("u", np.full(exhibit.full.vertex_count, np.nan))
    assert picture(Exhibit("t", exhibit.full, exhibit.part, (hidden,)), width=500).width == 500


def test_a_large_mesh_is_seen_from_the_same_side() -> None:
    """Views are compared on a thinned mesh; the choice and the share stay what they were."""
    up, views = np.array([0.0, 0, 1]), []
    for subdivisions in (4, 7):
        ball = trimesh.creation.icosphere(subdivisions)
        mesh = TriangleMesh(ball.vertices * [3.0, 1, 0.7], ball.faces)
        views.append(best_view(mesh, mesh.vertices @ [1.0, 0.4, 0.2] > 1.5, up))
    coarse, fine = views
    assert np.trace(fine.rotation @ coarse.rotation.T) > 2.9
    assert abs(fine.visible_share - coarse.visible_share) < 0.1


def test_the_legend_names_kinds_that_only_the_other_shape_has() -> None:
    ball = trimesh.creation.icosphere(1)
    mesh = TriangleMesh(ball.vertices, ball.faces)
    one, other = (np.full(mesh.vertex_count, kind) for kind in (0, 1))
    labels, palette = ("here", "there"), ((0, 0, 255), (255, 0, 0))
    layers = [
        Layer("kind", values, kind="category", labels=labels, palette=palette)
        for values in (one, other)
    ]
    drawn = [
        np.asarray(picture(Exhibit("", mesh, mesh, layers[:1], (layer,)), width=400))
        for layer in layers
    ]
    swatches = [(image[:, 112:288, :3] == (255, 0, 0)).all(axis=2)[-48:].sum() for image in drawn]
    assert swatches[0] == 0
    assert swatches[1] > 10
