"""Landmarks of templates carried to all specimens that have a folder of an answer."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from sherd.batching.batch import BatchResult
from sherd.errors import InputError
from sherd.landmarks.carried import CarriedLandmarks, carry_landmarks
from sherd.landmarks.landmark_list import Landmarks, Space
from sherd.landmarks.several import median_landmarks
from sherd.report.stored.stored_match import read_match

__all__ = ["ANY_TEMPLATE", "carried_to_parts", "carried_to_specimens", "folders_by_template"]

# Stands for whatever the template is called.
ANY_TEMPLATE = ""
# In the output folder: a batch for each of several templates.
BY_TEMPLATE = "by_template"


def carried_to_specimens(
    folders: Iterable[Path], landmarks: Mapping[str, Landmarks], *, mesh_space: Space | None = None
) -> list[CarriedLandmarks]:
    """The landmarks on each specimen, in the order of their first folders.

    Where a specimen was matched with several templates, their median.

    Parameters
    ----------
    folders
        Of :func:`sherd.match`, the template as the full shape and the specimen as the part.
    landmarks
        By name of the template, or one list for `ANY_TEMPLATE`.
    mesh_space
        How the axes of the meshes' files run; as those of the landmarks if None.

    Raises
    ------
    InputError
        If a folder holds no match, two are of one specimen on one template, or a template has no
        landmarks; otherwise as :func:`sherd.carry_landmarks`.
    """
    found: dict[str, list[CarriedLandmarks]] = {}
    seen: dict[tuple[str, str], Path] = {}
    for folder in folders:
        result = read_match(folder)
        key = (result.full.name, result.part.name)
        if key in seen:
            raise InputError(
                f"{folder}: is of {key[1]} on {key[0]}, and so is {seen[key]}; name one of them"
            )
        seen[key] = folder
        own = _of_template(landmarks, result.full.name, folder)
        carried = carry_landmarks(result, own, mesh_space=mesh_space)
        found.setdefault(result.part.name, []).append(carried)
    return _medians(found)


def carried_to_parts(
    batches: Iterable[BatchResult],
    landmarks: Mapping[str, Landmarks],
    *,
    mesh_space: Space | None = None,
) -> list[CarriedLandmarks]:
    """The landmarks on each part that has an answer, by its name in the batches.

    Where a part has answers in several batches, one for each template, their median.

    Raises
    ------
    InputError
        If a full shape has no landmarks; otherwise as :func:`sherd.carry_landmarks`.
    """
    found: dict[str, list[CarriedLandmarks]] = {}
    for each in batches:
        for row in each.rows:
            if row.folder is not None:
                result = read_match(each.folder / row.folder)
                own = _of_template(landmarks, result.full.name, each.folder / row.folder)
                carried = carry_landmarks(result, own, mesh_space=mesh_space)
                found.setdefault(row.name, []).append(replace(carried, specimen=row.name))
    return _medians(found)


def folders_by_template(fulls: Sequence[Path], folder: Path) -> dict[Path, Path]:
    """Where the batch of each template goes that specimens are matched with.

    Raises
    ------
    InputError
        If two templates have one name.
    """
    by_name: dict[str, Path] = {}
    for full in fulls:
        if full.stem in by_name:
            raise InputError(
                f"{full} and {by_name[full.stem]}: templates of one name, {full.stem}; the answers "
                "of each go to a folder of its name, so rename a file"
            )
        by_name[full.stem] = full
    return {full: folder / BY_TEMPLATE / name for name, full in by_name.items()}


def _medians(found: Mapping[str, Sequence[CarriedLandmarks]]) -> list[CarriedLandmarks]:
    return [each[0] if len(each) == 1 else median_landmarks(each) for each in found.values()]


def _of_template(landmarks: Mapping[str, Landmarks], name: str, folder: Path) -> Landmarks:
    found = landmarks.get(name, landmarks.get(ANY_TEMPLATE))
    if found is None:
        raise InputError(
            f"{folder}: is of the template {name}, but landmarks are given for "
            f"{', '.join(landmarks)}"
        )
    return found
