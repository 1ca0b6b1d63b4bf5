"""The readers of other programs open what sherd writes, and find vertices, colors and numbers.

MeshLab, ParaView (VTK) and pygltflib are large and not needed otherwise: docs/contributing.md says
how to install them. Without them their tests are skipped.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import trimesh

from sherd.drawing.colors import linear_from_srgb
from sherd.files.mesh_files import read_mesh
from sherd.report.exports import exported
from sherd.report.write import write_report
from sherd.results.match_result import MatchResult

EXPORTS = ("vtp", "glb", "npz", "mat", "map", "vts")
SIDES = ("full", "part")
READERS = "is not installed: pip install -e '.[readers]', see docs/contributing.md"


@pytest.fixture(scope="module")
def result(match_result_of, exhibit) -> MatchResult:
    return match_result_of(exhibit)


@pytest.fixture(scope="module")
def folder(result, tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("for_others")
    write_report(result, out, exports=EXPORTS)
    return out


@pytest.fixture(scope="module")
def meshlab():
    return pytest.importorskip("pymeshlab", reason=f"MeshLab's reader (pymeshlab) {READERS}")


@pytest.fixture(scope="module")
def vtk_array():
    """ParaView's conversion of its arrays to those of NumPy."""
    support = pytest.importorskip(
        "vtkmodules.util.numpy_support", reason=f"ParaView's reader (vtk) {READERS}"
    )
    return support.vtk_to_numpy


def mesh_of(result: MatchResult, side: str):
    return result.full if side == "full" else result.part


def colors_in(folder: Path, side: str) -> np.ndarray:
    """Colors of the PLY file as sherd reads them, (n, 3) in 0..255."""
    return np.rint(255 * read_mesh(folder / f"{side}.ply").fields["color"]).astype(int)


def meshlab_mesh(meshlab, path: Path):
    meshes = meshlab.MeshSet(verbose=False)
    meshes.load_new_mesh(str(path))
    return meshes, meshes.current_mesh()


@pytest.mark.parametrize(("side", "quality"), [("full", "membership"), ("part", "confidence")])
def test_meshlab_shows_colors_and_selects_by_quality(
    side, quality, meshlab, result, folder
) -> None:
    mesh = mesh_of(result, side)
    meshes, seen = meshlab_mesh(meshlab, folder / f"{side}.ply")
    assert (seen.vertex_number(), seen.face_number()) == (mesh.vertex_count, mesh.face_count)
    np.testing.assert_allclose(seen.vertex_matrix(), mesh.vertices)
    np.testing.assert_array_equal(seen.face_matrix(), mesh.faces)
    shown = np.rint(255 * seen.vertex_color_matrix()[:, :3])
    np.testing.assert_array_equal(shown, colors_in(folder, side))
    wanted = result.best.membership if quality == "membership" else result.confidence
    np.testing.assert_allclose(seen.vertex_scalar_array(), wanted)
    meshes.compute_selection_by_condition_per_vertex(condselect="q > 0.6")
    assert seen.selected_vertex_number() == (wanted > 0.6).sum()


def test_meshlab_opens_the_scene_for_the_web(meshlab, result, folder) -> None:
    meshes, _ = meshlab_mesh(meshlab, folder / "result.glb")
    seen = [meshes.mesh(number) for number in range(meshes.mesh_number())]
    assert [mesh.vertex_number() for mesh in seen] == [
        result.full.vertex_count,
        result.part.vertex_count,
    ]
    assert all(mesh.has_vertex_color() for mesh in seen)


@pytest.mark.parametrize("side", SIDES)
def test_paraview_finds_every_array(side, vtk_array, result, folder) -> None:
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader  # noqa: PLC0415  not always installed

    mesh = mesh_of(result, side)
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(str(folder / f"{side}.vtp"))
    reader.Update()
    seen = reader.GetOutput()
    np.testing.assert_array_equal(vtk_array(seen.GetPoints().GetData()), mesh.vertices)
    corners = vtk_array(seen.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    np.testing.assert_array_equal(corners, mesh.faces)
    arrays = seen.GetPointData()
    found = {
        arrays.GetArrayName(k): vtk_array(arrays.GetArray(k))
        for k in range(arrays.GetNumberOfArrays())
    }
    np.testing.assert_array_equal(found["correspondence"], colors_in(folder, side))
    if side == "full":
        np.testing.assert_array_equal(found["membership"], result.best.membership)
        np.testing.assert_array_equal(found["region"], result.best.mask)
        assert arrays.GetScalars().GetName() == "region"
    else:
        np.testing.assert_array_equal(found["confidence"], result.confidence)
        np.testing.assert_array_equal(found["matched"], result.matched)
        assert np.isnan(found["thickness_from_the_file"][~result.matched]).all()


@pytest.mark.parametrize("side", SIDES)
def test_paraview_shows_the_colors_of_the_ply_files(side, vtk_array, folder) -> None:
    from vtkmodules.vtkIOPLY import vtkPLYReader  # noqa: PLC0415  not always installed

    reader = vtkPLYReader()
    reader.SetFileName(str(folder / f"{side}.ply"))
    reader.Update()
    colors = vtk_array(reader.GetOutput().GetPointData().GetArray("RGB"))
    np.testing.assert_array_equal(colors, colors_in(folder, side))


def test_paraview_colors_by_confidence_and_keeps_the_sure(vtk_array, result, folder) -> None:
    """The steps of docs/howto/paraview.md, by the classes that ParaView runs them with."""
    from vtkmodules.vtkCommonDataModel import vtkDataObject  # noqa: PLC0415  not always installed
    from vtkmodules.vtkFiltersCore import vtkThreshold  # noqa: PLC0415
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader  # noqa: PLC0415
    from vtkmodules.vtkRenderingCore import vtkPolyDataMapper  # noqa: PLC0415

    reader = vtkXMLPolyDataReader()
    reader.SetFileName(str(folder / "part.vtp"))
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(reader.GetOutputPort())
    mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray("confidence")
    mapper.SetScalarRange(0, 1)
    mapper.Update()
    shades = vtk_array(mapper.MapScalars(1.0))
    assert len(np.unique(shades, axis=0)) > 50
    # uncheck Map Scalars: the stored colors themselves
    mapper.SelectColorArray("correspondence")
    mapper.SetColorModeToDirectScalars()
    stored = vtk_array(mapper.MapScalars(1.0))[:, :3]
    np.testing.assert_array_equal(stored, colors_in(folder, "part"))

    sure = vtkThreshold()
    sure.SetInputConnection(reader.GetOutputPort())
    sure.SetInputArrayToProcess(0, 0, 0, vtkDataObject.FIELD_ASSOCIATION_POINTS, "confidence")
    sure.SetThresholdFunction(vtkThreshold.THRESHOLD_UPPER)
    sure.SetUpperThreshold(0.6)
    sure.Update()
    kept = (result.confidence >= 0.6)[result.part.faces].all(axis=1)
    assert sure.GetOutput().GetNumberOfCells() == kept.sum()


def test_trimesh_opens_the_scene_with_colors_and_attributes(result, folder) -> None:
    scene = trimesh.load_scene(folder / "result.glb", process=False)
    assert set(scene.geometry) == set(SIDES)
    for side in SIDES:
        mesh, seen = mesh_of(result, side), scene.geometry[side]
        np.testing.assert_allclose(seen.vertices, mesh.vertices, rtol=1e-6, atol=1e-6)
        np.testing.assert_array_equal(seen.faces, mesh.faces)
        wanted = linear_from_srgb(colors_in(folder, side))
        np.testing.assert_allclose(seen.visual.vertex_attributes["color"], wanted, atol=1e-6)
        np.testing.assert_allclose(np.linalg.norm(seen.vertex_normals, axis=1), 1, rtol=1e-5)
    confidence = scene.geometry["part"].vertex_attributes["_confidence"]
    np.testing.assert_allclose(confidence.ravel(), result.confidence, rtol=1e-6)
    # carried over, so unknown where unmatched; glTF cannot say so
    assert "_thickness_from_the_file" in scene.geometry["full"].vertex_attributes
    assert "_thickness_from_the_file" not in scene.geometry["part"].vertex_attributes


def test_the_shapes_of_a_scene_stand_apart(folder) -> None:
    scene = trimesh.load_scene(folder / "result.glb", process=False)
    full, part = (
        scene.geometry[side].copy().apply_transform(scene.graph.get(side)[0]) for side in SIDES
    )
    assert part.bounds[0, 0] > full.bounds[1, 0]
    np.testing.assert_allclose(
        part.bounds.mean(axis=0)[1:], full.bounds.mean(axis=0)[1:], atol=1e-5
    )


def test_web_viewers_find_what_the_standard_asks_for(folder) -> None:
    gltf = pytest.importorskip("pygltflib", reason=f"pygltflib {READERS}")
    scene = gltf.GLTF2().load(str(folder / "result.glb"))
    assert [node.name for node in scene.nodes] == list(SIDES)
    assert scene.buffers[0].byteLength == len(scene.binary_blob())
    for mesh in scene.meshes:
        attributes = mesh.primitives[0].attributes
        counts = {
            scene.accessors[number].count
            for number in (attributes.POSITION, attributes.NORMAL, attributes.COLOR_0)
        }
        assert len(counts) == 1
        place = scene.accessors[attributes.POSITION]
        view = scene.bufferViews[place.bufferView]
        start = view.byteOffset
        stored = np.frombuffer(scene.binary_blob()[start : start + view.byteLength], "<f4")
        np.testing.assert_array_equal(stored.reshape(-1, 3).min(axis=0), np.float32(place.min))
        np.testing.assert_array_equal(stored.reshape(-1, 3).max(axis=0), np.float32(place.max))


def test_a_scene_of_a_region_leaves_the_part_neutral(exhibit_of_size, tmp_path) -> None:
    plain = exhibit_of_size(1, partner=None, alternatives=(), anchors=None)
    path = tmp_path / "result.glb"
    path.write_bytes(exported(plain, ["glb"])["result.glb"])
    scene = trimesh.load_scene(path, process=False)
    colors = {
        side: np.unique(scene.geometry[side].visual.vertex_attributes["color"], axis=0)
        for side in SIDES
    }
    assert len(colors["full"]) > 10
    assert len(colors["part"]) == 1


def test_a_scene_of_nothing_but_shapes_is_written(exhibit_of_size) -> None:
    bare = exhibit_of_size(1, full_layers=(), part_layers=())
    assert exported(bare, ["glb"])["result.glb"][:4] == b"glTF"


def matlab_numbers(path: Path) -> Iterator[tuple[str, np.ndarray]]:
    for name, values in scipy.io.loadmat(path).items():
        if not name.startswith("__"):
            yield name, values


def test_matlab_and_numpy_files_hold_the_same_numbers(folder) -> None:
    counted = {"full_faces", "part_faces", "full_face", "full_vertex"}
    with np.load(folder / "result.npz") as arrays:
        for name, values in matlab_numbers(folder / "result.mat"):
            first = 1 if name in counted else 0
            wanted = arrays[name].reshape(len(values), -1) + first
            np.testing.assert_array_equal(values, wanted, err_msg=name)
        assert {name for name, _ in matlab_numbers(folder / "result.mat")} == set(arrays)
