"""match_either_side: a part that may be inside out, placed on both sides."""

from __future__ import annotations

from sherd.match import MatchOptions, MatchResult, match
from sherd.mesh.sides import bulge, turned_over
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import Stages
from sherd.template import Template

__all__ = ["is_sure_of_side", "match_either_side"]

# Turned over, parts of animals and people scored at most 0.43 where the right side had 0.5 to 0.95.
SURE_SCORE = 0.6
# A patch a seventh as deep as it is wide. Flatter ones look alike from both sides.
SURE_BULGE = 0.02


def is_sure_of_side(result: MatchResult) -> bool:
    """Whether a match of a part that may be inside out need not be tried on the other side."""
    return result.scores["best"] >= SURE_SCORE and bulge(result.part) >= SURE_BULGE


def match_either_side(
    full: TriangleMesh | Template,
    part: TriangleMesh,
    options: MatchOptions | None = None,
    *,
    stages: Stages | None = None,
) -> MatchResult:
    """Match the part as it is and with all its faces turned over; the better answer.

    An open surface does not tell which of its sides is outside, and :func:`sherd.match` believes
    the order of corners. Where that may be wrong, this first takes the side that seems to be
    outside, and tries the other one unless the answer is good. It takes up to twice the time.

    Parameters
    ----------
    full, part, options, stages
        As for :func:`sherd.match`.

    Returns
    -------
    MatchResult
        Its `part` is the one that fits: as given, or turned over.

    Raises
    ------
    OptionError, InfeasibleError, InvalidMeshError
        As :func:`sherd.match`.
    """
    template = full if isinstance(full, Template) else Template(full)
    outward = turned_over(part) if bulge(part) < 0 else part
    found = match(template, outward, options, stages=stages)
    if is_sure_of_side(found):
        return found
    other = match(template, turned_over(outward), options, stages=stages)
    return other if other.scores["best"] > found.scores["best"] else found
