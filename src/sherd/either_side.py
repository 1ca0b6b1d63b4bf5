"""match_either_side: a part that may be inside out, placed on both sides."""

from __future__ import annotations

from sherd.match import MatchOptions, MatchResult, match
from sherd.mesh.sides import turned_over
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import Stages
from sherd.template import Template

__all__ = ["match_either_side"]


def match_either_side(
    full: TriangleMesh | Template,
    part: TriangleMesh,
    options: MatchOptions | None = None,
    *,
    stages: Stages | None = None,
) -> MatchResult:
    """Match the part as it is and with all its faces turned over; the better answer.

    An open surface does not tell which of its sides is outside, and :func:`sherd.match` believes
    the order of corners. Where that may be wrong, this takes twice the time.

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
    found = match(template, part, options, stages=stages)
    other = match(template, turned_over(part), options, stages=stages)
    return other if other.scores["best"] > found.scores["best"] else found
