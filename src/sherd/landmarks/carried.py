"""Landmarks of a template carried to a specimen along a match.

The template is the full shape and the specimen, whole or damaged, the part. Its vertices lie on the
template; the landmark is where the image of its faces passes. Bone is thin, and its inner side may
pass nearer than the right one: only faces that look the way the landmark's surface does are asked.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Bools, Floats, FrozenState, frozen
from sherd.landmarks.attached import AttachedLandmarks, attached
from sherd.landmarks.landmark_list import Landmarks, Space
from sherd.mesh.surface_points import closest_points
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.match_result import MatchResult
from sherd.results.status import Status

__all__ = ["CarriedLandmarks", "carry_landmarks", "landmarks_of_part"]

# In sqrt(area) of the template. The image of a specimen leaves no wider gaps than its edges; a
# vertex spacing of a mesh of 10,000 vertices farther, the specimen ends.
REACH = 0.01
# Faces are asked whose center lies within twice that, as edges are that long at most.
LOOKED_AT = 2.0
# The chance to be within 0.05 sqrt(area) of the truth, below which a landmark is doubtful.
SURE = 0.5


@dataclass(frozen=True, eq=False, repr=False)
class CarriedLandmarks(FrozenState):
    """Landmarks on one specimen.

    Attributes
    ----------
    specimen
        Its name.
    templates
        Names of the templates that they come from.
    landmarks
        In the coordinates of the specimen's mesh; those that it does not have are NaN.
    confidence
        (p,) chance to be within 0.05 sqrt(area of the template) of the truth; NaN where missing.
    status
        (p,) ``"good"``, ``"doubtful"``, ``"missing"``: the specimen ends before, or what is there
        fits nothing; or ``"foreign"``: the specimen is not of this kind at all.
    spread
        (p,) median distance between the landmark and where single templates place it, in the unit
        of the specimen; NaN with one template.
    """

    specimen: str
    templates: tuple[str, ...]
    landmarks: Landmarks
    confidence: Floats
    status: tuple[str, ...]
    spread: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "confidence", frozen(np.array(self.confidence, dtype=float)))
        object.__setattr__(self, "spread", frozen(np.array(self.spread, dtype=float)))

    def __repr__(self) -> str:
        said = {
            word: self.status.count(word) for word in ("good", "doubtful", "missing", "foreign")
        }
        counts = ", ".join(f"{count} {word}" for word, count in said.items() if count)
        return f"CarriedLandmarks({self.specimen!r}: {counts})"

    @property
    def notes(self) -> tuple[str, ...]:
        """(p,) status and confidence in words, as descriptions of the points in a file."""
        return tuple(
            word if np.isnan(chance) else f"{word}, confidence {chance:.2f}"
            for word, chance in zip(self.status, self.confidence, strict=True)
        )


def carry_landmarks(
    result: MatchResult,
    landmarks: Landmarks | AttachedLandmarks,
    *,
    mesh_space: Space | None = None,
) -> CarriedLandmarks:
    """Where the landmarks of the full shape, the template, lie on the part, the specimen.

    Parameters
    ----------
    result
        The specimen matched with the template.
    landmarks
        Of the template.
    mesh_space
        See :func:`sherd.landmarks.attached.attached`.

    Raises
    ------
    InputError
        If the landmarks do not lie on the template.

    Notes
    -----
    How far a landmark lies off the template's surface is not carried over: set by hand, that is the
    error of the hand.
    """
    if isinstance(landmarks, Landmarks):
        landmarks = attached(landmarks, result.full, mesh_space=mesh_space)
    count = len(landmarks.landmarks)
    positions, confidence = np.full((count, 3), np.nan), np.full(count, np.nan)
    foreign = result.status is Status.FOREIGN
    if not foreign:
        image = _Image(result)
        for row in np.flatnonzero(landmarks.landmarks.known).tolist():
            positions[row], confidence[row] = image.landmark(landmarks, row)
    status = ["foreign" if foreign else _status(result, chance) for chance in confidence.tolist()]
    return CarriedLandmarks(
        specimen=result.part.name,
        templates=(result.full.name,),
        landmarks=Landmarks(
            landmarks.landmarks.names,
            positions,
            space=landmarks.landmarks.space,
            source=result.part.name,
        ),
        confidence=confidence,
        status=tuple(status),
        spread=np.full(count, np.nan),
    )


def landmarks_of_part(result: MatchResult, landmarks: AttachedLandmarks) -> Landmarks:
    """The other way: landmarks attached to the part as points of the full shape."""
    positions = landmarks.points.interpolate(result.part, result.positions)
    matched = result.matched[result.part.faces[landmarks.points.faces]].all(axis=1)
    lost = ~(matched & landmarks.landmarks.known)
    positions[lost] = np.nan
    return Landmarks(
        landmarks.landmarks.names,
        positions,
        space=landmarks.landmarks.space,
        source=result.full.name,
    )


def _status(result: MatchResult, confidence: float) -> str:
    if np.isnan(confidence):
        return "missing"
    return "good" if confidence >= SURE and result.status is Status.GOOD else "doubtful"


class _Image:
    """The specimen's faces as they lie on the template, to be asked at single places."""

    def __init__(self, result: MatchResult) -> None:
        self.result = result
        self.mesh = result.part.with_vertices(result.positions)
        self.centers = cKDTree(self.mesh.vertices[self.mesh.faces].mean(axis=1))
        # which way the template looks where each vertex of the specimen lies
        self.normals = result.points.interpolate(result.full, result.outward)
        self.matched: Bools = np.all(result.matched[self.mesh.faces], axis=1)
        longest = self.mesh.mean_edge_length
        self.reach = max(REACH * result.full.length, longest)

    def landmark(self, landmarks: AttachedLandmarks, row: int) -> tuple[Floats, float]:
        """Position (3,) on the specimen and confidence; NaN if the specimen does not have it."""
        full, part = self.result.full, self.result.part
        point = landmarks.points[[row]]
        place = point.positions(full)
        normal = point.interpolate(full, self.result.outward)[0]
        near = np.array(self.centers.query_ball_point(place[0], LOOKED_AT * self.reach), dtype=int)
        near = np.sort(near[self.matched[near]])
        looks = self.normals[self.mesh.faces[near]].mean(axis=1) @ normal
        near = near[looks > 0]
        if not len(near):
            return np.full(3, np.nan), np.nan
        patch = TriangleMesh(self.mesh.vertices, self.mesh.faces[near], name=part.name)
        found = closest_points(patch, place)
        if np.linalg.norm(found.positions(patch) - place) > self.reach:
            return np.full(3, np.nan), np.nan
        own = TriangleMesh(part.vertices, patch.faces, name=part.name)
        return found.positions(own)[0], float(found.interpolate(own, self.result.confidence)[0])
