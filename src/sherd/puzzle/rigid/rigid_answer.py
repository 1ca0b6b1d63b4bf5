"""What to think of a rigid piece where it lies, and which of its vertices lie on the full shape."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sherd.correspondence.confidence import LEAST
from sherd.puzzle.rigid.motion import RigidMotion
from sherd.puzzle.rigid.surface_fit import lying_on
from sherd.results.advice import SURE, Doubts
from sherd.results.match_result import MatchResult
from sherd.results.status import Status
from sherd.scan.numbering import outward_normals

__all__ = ["rigid_answer"]

# A sherd has fracture by two fifths of its area at most, which lies nowhere, or is not found. Of
# what has more some lies where it does not belong, as one of two pieces in one file.
LEAST_LYING = 0.5


def rigid_answer(
    result: MatchResult, motion: RigidMotion, chance: float, tolerance: float
) -> MatchResult:
    """The result of a piece that nothing bends: how closely it fits is all there is to say.

    What is farther off than the tolerance, or looks another way, as a face of fracture does, has no
    point on the full shape. The rest is as sure as the place is.

    Parameters
    ----------
    result
        What neighborhoods say of the piece where it lies.
    motion
        What brings the vertices of its part there, in the unit of the files.
    chance
        That the place is right.
    tolerance
        In sqrt(area of the full shape).
    """
    full, part = result.full, result.part
    here, normals = motion(part.vertices), outward_normals(part) @ motion.rotation.T
    feet, planes = result.points.positions(full), full.face_normals[result.points.faces]
    # faces of a file may look inward
    outward = result.points.interpolate(full, outward_normals(full))
    planes = planes * np.sign(np.einsum("ij,ij->i", planes, outward))[:, None]
    _, lies = lying_on(feet, planes, here, normals, tolerance * full.length)
    area = part.vertex_areas
    share = float(area @ lies / area.sum())
    status = Doubts(chance=chance).status
    if chance >= SURE and share < LEAST_LYING:
        status = Status.DOUBTFUL
        advice = (
            f"doubtful: {share:.0%} of the piece lie on the full shape, and most of it nowhere; if "
            "the file holds several pieces give each by itself"
        )
    elif chance >= SURE:
        advice = (
            f"good: {share:.0%} of the piece lie on the full shape, more closely than elsewhere"
        )
    else:
        advice = (
            f"doubtful: the chance that the placement is right is {chance:.2f}; look at it in the "
            "report, or ask with another full shape or tolerance"
        )
    best = replace(
        result.best, matched=lies, confidence=np.where(lies, np.clip(chance, LEAST, 1.0), LEAST)
    )
    return replace(result, best=best, status=status, advice=advice, chance=chance)
