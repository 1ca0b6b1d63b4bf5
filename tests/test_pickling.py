"""Public objects are pickled, copied, sent to other processes and shown, each briefly."""

from __future__ import annotations

import base64
import copy
import io
import multiprocessing
import pickle
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import sherd
from sherd.energy.mumford_shah import EnergyTerms
from sherd.library.folder import Shelf
from sherd.results.fitted.completion import Completion
from sherd.results.fitted.fit_result import FitCheck, FittedPiece, HiddenRegion
from sherd.results.locate_result import LocateCheck
from sherd.results.match_result import MatchCheck
from sherd.results.overlap_result import SharedMap, StrainCurve
from sherd.results.puzzle.assembly import Contact, Gap, PieceAnswer, SharedPlace
from sherd.results.puzzle.joined import PairAnswer
from sherd.shapes.creature import creature
from sherd.spectral.basis import EigenBasis, eigenbasis

MESH = creature(5000).with_fields(height=np.linspace(0.0, 1.0, creature(5000).vertex_count))
COUNT = MESH.vertex_count
# What is no array: names, options, the pickle's own words.
WORDS = 6000


def surface_points() -> sherd.SurfacePoints:
    return sherd.SurfacePoints(MESH.faces.argmin(axis=0)[np.zeros(COUNT, dtype=int)], thirds())


def thirds() -> np.ndarray:
    return np.full((COUNT, 3), 1 / 3)


def placement() -> sherd.Placement:
    mask = np.arange(COUNT) % 2 == 0
    return sherd.Placement(
        mask=mask,
        membership=mask.astype(float),
        score=0.9,
        points=surface_points(),
        matched=mask,
        confidence=np.linspace(0, 1, COUNT),
    )


def match_result() -> sherd.MatchResult:
    result = sherd.MatchResult(
        full=MESH,
        part=MESH,
        best=placement(),
        alternatives=(placement(),),
        scale=1.0,
        second_score=0.5,
        twin_score=None,
        status=sherd.Status.GOOD,
        timings={"first": 1.0},
        options=sherd.MatchOptions(landmarks=((1, 2),), ignore=np.arange(COUNT) > COUNT - 3),
        notices={"full": ("repaired",), "part": ()},
    )
    _ = (result.outward, result.check())  # computed and kept
    return result


def locate_result() -> sherd.LocateResult:
    return sherd.LocateResult(
        full=MESH,
        part=MESH,
        best=placement(),
        alternatives=(),
        phase_field=np.linspace(0, 1, COUNT),
        energy=EnergyTerms(0.1, 0.2, 0.3),
        convergence=sherd.Convergence.CONVERGED,
        options=sherd.LocateOptions(),
        timings={"votes": 1.0},
    )


def mesh() -> sherd.TriangleMesh:
    _ = (MESH.vertex_areas, MESH.edges, MESH.vertex_normals, MESH.component_labels)
    return MESH


def repair_report() -> sherd.RepairReport:
    return sherd.repair(MESH)[1]


def template() -> sherd.Template:
    made = sherd.Template(MESH)
    _ = (made.normals, made.finder, made.geodesics, made.vertex_tree, made.elastic)
    return made


def basis() -> EigenBasis:
    return eigenbasis(MESH, 5)


def shared_map() -> SharedMap:
    mask = np.arange(COUNT) % 2 == 0
    return SharedMap(surface_points(), mask, mask.astype(float), mask.astype(float))


def overlap_result() -> sherd.Overlap:
    made = sherd.Overlap(
        first=MESH,
        second=MESH,
        second_to_first=shared_map(),
        first_to_second=shared_map(),
        scale=1.0,
        status=sherd.Status.GOOD,
        chance=0.9,
        curve=StrainCurve((0.1, 0.2), (0.4, 0.5), (0.4, 0.5)),
        timings={"labels": 1.0},
        options=sherd.OverlapOptions(landmarks=((1, 2),)),
        notices={"first": ("repaired",), "second": ()},
    )
    _ = made.check()  # computed and kept
    return made


def assembly() -> sherd.Assembly:
    labels = np.arange(COUNT) % 2 - 1
    placed = PieceAnswer(
        MESH,
        placed=True,
        reason="",
        chance=0.9,
        match=copy.copy(match_result()),
        transform=np.eye(4),
    )
    return sherd.Assembly(
        full=MESH,
        pieces=(placed, PieceAnswer(MESH, placed=False, reason="foreign", chance=0.1)),
        labels=labels,
        memberships=np.stack([labels == 0, np.zeros(COUNT)]),
        gaps=(Gap(0.5, 1, COUNT // 2),),
        contacts=(Contact(0, 1, 1.0, 0.1, 0.0),),
        shared=(SharedPlace(0, 1, 0.1),),
        energy=-0.3,
        timings={"partition": 1.0},
        options=sherd.AssembleOptions(),
    )


def joined() -> sherd.Joined:
    there = shared_map()
    return sherd.Joined(
        pieces=(MESH, MESH, MESH),
        groups=((0, 1), (2,)),
        pairs=(PairAnswer(0, 1, 0.8, asked=True, chance=0.9, joined=True),),
        maps={(0, 1): there, (1, 0): there},
        cycle_before=0.1,
        cycle_after=0.05,
        timings={"pairs": 1.0},
        likely={1: 0.6},
        by_twin=(1,),
        unplaced=(2,),
        options=sherd.AssembleOptions(),
    )


def batch_row() -> sherd.BatchRow:
    return sherd.BatchRow("leg", "leg.ply", status="good", chance=0.9)


def pair_row() -> sherd.PairRow:
    return sherd.PairRow("leg--arm", "leg.ply", "arm.ply", status="foreign", likeness=0.2)


def landmarks() -> sherd.Landmarks:
    return sherd.Landmarks(["nose", "tail"], [[1, 2, 3], [4, 5, 6.5]], space="LPS")


def carried_landmarks() -> sherd.CarriedLandmarks:
    return sherd.CarriedLandmarks(
        specimen="scan.ply",
        templates=("a.ply", "b.ply"),
        landmarks=landmarks(),
        confidence=np.array([0.9, 0.8]),
        status=("good", "doubtful"),
        spread=np.array([0.1, 0.2]),
    )


def identification() -> sherd.Identification:
    return sherd.Identification(
        part=MESH,
        candidates=(candidate_answer(),),
        status=sherd.Status.GOOD,
        advice="good: belongs to cat.ply",
        options=sherd.IdentifyOptions(matches=3),
        timings={"evidence": 0.5},
    )


def candidate_answer() -> sherd.CandidateAnswer:
    return sherd.CandidateAnswer("cat.ply", 0.9, 0.3, match=copy.copy(match_result()))


def library() -> sherd.Library:
    shelf = Shelf("cat.ply", "0" * 64, 10, 1.5, "a.npz", "b.npz", "1" * 64, "2" * 64)
    return sherd.Library(Path("library"), (shelf,))


def fitted() -> sherd.Fit:
    piece = FittedPiece(MESH, surface_points(), np.ones(COUNT, dtype=bool), np.zeros(COUNT), 1.0)
    made = sherd.Fit(
        full=MESH,
        pieces=(piece,),
        positions=MESH.vertices + 1.0,
        seen=np.arange(COUNT) % 2 == 0,
        chance=np.linspace(0, 1, COUNT),
        distances=np.linspace(0, 0.1, COUNT),
        strain=np.zeros(COUNT),
        sizes=np.ones(COUNT),
        check=FitCheck(0, 1.0, 0, 0, passed=True),
        hidden=(HiddenRegion(0.5, 1.0, 1, COUNT // 2),),
        status=sherd.Status.GOOD,
        advice="good: it lies there",
        timings={"deformation": 1.0},
        options=sherd.FitOptions(merge=True),
        completion=Completion(MESH, np.zeros(COUNT, dtype=int), watertight=True, stitched=True),
    )
    _ = (made.mesh, made.scan_summary)  # computed and kept
    return made


MAKERS: dict[str, Callable[[], object]] = {
    "AssembleOptions": lambda: sherd.AssembleOptions(rigid=True),
    "Assembly": assembly,
    "BatchOptions": lambda: sherd.BatchOptions(shard="1/2"),
    "BatchPart": lambda: sherd.BatchPart("leg.ply", landmarks=((1, 2),)),
    "BatchResult": lambda: sherd.BatchResult(Path("out"), (batch_row(),), ("arm",), 1),
    "BatchRow": batch_row,
    "PairRow": pair_row,
    "PairsResult": lambda: sherd.PairsResult(Path("out"), (pair_row(),), (), 1),
    "Joined": joined,
    "Convergence": lambda: sherd.Convergence.STALLED,
    "Fit": fitted,
    "FitOptions": lambda: sherd.FitOptions(sizing="none"),
    "LocateOptions": lambda: sherd.LocateOptions(method="subspace"),
    "LocateResult": locate_result,
    "MatchOptions": lambda: match_result().options,
    "MatchResult": match_result,
    "MeshReport": lambda: sherd.inspect(MESH),
    "Overlap": overlap_result,
    "OverlapOptions": lambda: sherd.OverlapOptions(strain=0.3),
    "Placement": placement,
    "PointCloud": lambda: sherd.PointCloud(MESH.vertices, MESH.vertex_normals),
    "RepairReport": repair_report,
    "Status": lambda: sherd.Status.DOUBTFUL,
    "SurfacePoints": surface_points,
    "Template": template,
    "TriangleMesh": mesh,
    "CandidateAnswer": candidate_answer,
    "CarriedLandmarks": carried_landmarks,
    "Identification": identification,
    "IdentifyOptions": lambda: sherd.IdentifyOptions(matches=3),
    "Landmarks": landmarks,
    "Library": library,
    "EigenBasis": basis,
    "EnergyTerms": lambda: EnergyTerms(1.0, 2.0, 3.0),
    "MatchCheck": lambda: MatchCheck(1.0, 0.0, 1.0, passed=True),
    "LocateCheck": lambda: LocateCheck(0.0, 0.0, 0.0, 1.0, 1, 1.0, passed=True),
}


@dataclass
class Content:
    """Arrays and mappings inside an object, and all else that is no object of its own."""

    arrays: list[np.ndarray]
    mappings: list[Mapping[str, Any]]
    plain: list[object]


def content_of(thing: object, into: Content | None = None) -> Content:
    found = into or Content([], [], [])
    if isinstance(thing, np.ndarray):
        found.arrays.append(thing)
    elif is_dataclass(thing):
        for each in fields(thing):
            content_of(getattr(thing, each.name), found)
    elif isinstance(thing, Mapping):
        found.mappings.append(thing)
        for key in sorted(thing):
            content_of((key, thing[key]), found)
    elif isinstance(thing, tuple):
        for entry in thing:
            content_of(entry, found)
    elif isinstance(thing, sherd.Template):
        content_of(tuple(thing.__getstate__().values()), found)
    else:
        found.plain.append(thing)
    return found


def pickled(thing: object) -> object:
    return pickle.loads(pickle.dumps(thing))  # noqa: S301 - our own bytes


def test_every_public_type_is_tried() -> None:
    types = {name for name in sherd.__all__ if isinstance(getattr(sherd, name), type)}
    assert {name for name in types if not name.endswith("Error")} <= set(MAKERS)


@pytest.mark.parametrize("way", [pickled, copy.copy, copy.deepcopy])
@pytest.mark.parametrize("name", MAKERS)
def test_public_objects_come_back_whole(name: str, way: Callable[[object], object]) -> None:
    thing = MAKERS[name]()
    again = way(thing)
    assert type(again) is type(thing)
    before, after = content_of(thing), content_of(again)
    assert len(before.arrays) == len(after.arrays)
    for one, other in zip(before.arrays, after.arrays, strict=True):
        assert np.array_equal(one, other)
        assert one.dtype == other.dtype
        assert one.flags.writeable or not other.flags.writeable
    assert before.plain == after.plain
    for mapping in after.mappings:
        with pytest.raises(TypeError):
            mapping["new"] = 1


@pytest.mark.parametrize("name", MAKERS)
def test_a_pickle_costs_about_its_arrays(name: str) -> None:
    thing = MAKERS[name]()
    different = {id(array): array.nbytes for array in content_of(thing).arrays}
    assert len(pickle.dumps(thing)) < 1.01 * sum(different.values()) + WORDS


@pytest.mark.parametrize("name", MAKERS)
def test_what_is_shown_is_one_short_line(name: str) -> None:
    shown = repr(MAKERS[name]())
    assert name in shown
    assert "\n" not in shown
    assert len(shown) < 200


def test_options_show_what_is_not_the_default() -> None:
    assert repr(sherd.MatchOptions()) == "MatchOptions()"
    options = sherd.MatchOptions(scale=2, ignore=range(1000))
    assert repr(options) == "MatchOptions(scale=2.0, ignore=<1000 entries>)"


@pytest.mark.parametrize("make", [match_result, locate_result])
def test_notebooks_show_a_table_and_a_picture(make: Callable[[], Any]) -> None:
    result = make()
    odd = copy.copy(result)
    object.__setattr__(odd, "part", sherd.TriangleMesh(MESH.vertices, MESH.faces, name="<b>"))
    shown = odd._repr_html_()
    assert "&lt;b&gt;" in shown
    assert "<b>" not in shown
    for word in ("status", "coverage", "100.0%", "confidence" if make is match_result else "score"):
        assert word in shown
    table, _, picture = shown.partition("<img")
    assert len(table) < 3000
    assert len(picture) < 60_000
    data = base64.b64decode(picture.partition("base64,")[2].partition('"')[0])
    drawn = np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))
    full, part = drawn[:200, :320].reshape(-1, 3), drawn[:200, 320:].reshape(-1, 3)
    for shape in (full, part):
        assert len(np.unique(shape, axis=0)) > 10


def test_a_template_keeps_what_took_long_and_nothing_else() -> None:
    made = template()
    again = pickled(made)
    assert isinstance(again, sherd.Template)
    assert again.__getstate__()["known"].normals is not None
    assert np.array_equal(again.normals, made.normals)
    assert "geodesics" not in vars(again)
    assert np.array_equal(again.full.faces, made.full.faces)
    assert again.length == made.length


def test_a_result_comes_back_from_another_process() -> None:
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn) as pool:
        again = pool.submit(copy.copy, match_result()).result()
    assert isinstance(again, sherd.MatchResult)
    assert np.array_equal(again.positions, match_result().positions)
    assert again.check() == match_result().check()
