"""What to think of a rigid piece where it lies, and which of its vertices lie on the full shape."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sherd.correspondence.confidence import LEAST
from sherd.puzzle.rigid.motion import RigidMotion
from sherd.puzzle.rigid.surface_fit import lying_on
from sherd.results.advice import SURE, Doubts
from sherd.results.match_result import MatchResult

__all__ = ["rigid_answer"]


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
    here, normals = motion(part.vertices), part.vertex_normals @ motion.rotation.T
    _, lies = lying_on(full, result.points, here, normals, tolerance * full.length)
    area = part.vertex_areas
    doubts = Doubts(chance=chance)
    advice = doubts.advice
    if chance >= SURE:
        share = float(area @ lies / area.sum())
        advice = (
            f"good: {share:.0%} of the piece lie on the full shape, and nowhere else as closely"
        )
    best = replace(
        result.best, matched=lies, confidence=np.where(lies, np.clip(chance, LEAST, 1.0), LEAST)
    )
    return replace(result, best=best, status=doubts.status, advice=advice, chance=chance)
