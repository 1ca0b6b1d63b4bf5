"""fit(result): the full shape in the pose and place of the pieces that were matched to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Unpack

import numpy as np

from sherd.errors import InfeasibleError, InputError
from sherd.fitting.assessment import Solved, fit_of
from sherd.fitting.fitted import fitted_shape
from sherd.fitting.targets import matched_surface, targets_of
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import Stages
from sherd.results.fitted.fit_options import FitKeywords, FitOptions
from sherd.results.fitted.fit_result import Fit
from sherd.results.keywords import options_of
from sherd.results.match_result import MatchResult
from sherd.results.puzzle.assembly import Assembly
from sherd.scan.intake import mesh_intake

__all__ = ["STAGES", "fit"]

STAGES = ("targets", "deformation", "distances", "intersections")


def fit(
    result: MatchResult | Assembly | Sequence[MatchResult],
    options: FitOptions | None = None,
    *,
    stages: Stages | None = None,
    **keywords: Unpack[FitKeywords],
) -> Fit:
    """Lay the full shape onto the pieces that were matched to it.

    Where the pieces were seen the full shape lies on them; where not, it continues as it is, bent
    and sized as little as what was seen asks for. Vertices and faces stay its own. Confidence
    decides how firmly the map draws; what is not matched draws nothing.

    Parameters
    ----------
    result
        Of :func:`sherd.match`, or of :func:`sherd.assemble`, whose pieces must then lie in one
        coordinate system and pose, as scans of one body from several sides do; or several matches
        of such pieces to one full shape.
    options
        See :class:`FitOptions`; the defaults if None.
    stages
        Collects timings and shows progress; a silent one if None.
    keywords
        The fields of :class:`FitOptions`, instead of `options`.

    Returns
    -------
    Fit
        In the coordinates and unit of the pieces.

    Raises
    ------
    OptionError
        If a keyword is unknown, or both `options` and keywords are given.
    InfeasibleError
        If hardly anything is matched, or no piece of an assembly has a place.
    InputError
        If `result` is none of match or assemble.

    Notes
    -----
    On two busy cores 2 to 5 s for 10,000 vertices, 26 s for 100,000; no random choice is made.

    Examples
    --------
    >>> from sherd.match import match
    >>> from sherd.shapes import creature, cut_by_ball, whole
    >>> full = creature(5000)
    >>> part = cut_by_ball(whole(creature(5000, pose="walk"), full), 0, 0.5).mesh
    >>> fit(match(full, part)).check.turned_faces
    0
    """
    options = options_of(FitOptions, options, keywords)
    stages = stages or Stages(visible=False)
    matches = _matches(result)
    intake = mesh_intake(matches[0].full)
    unit = matches[0].full.length
    shape = TriangleMesh(intake.mesh.vertices / unit, intake.mesh.faces, name=intake.mesh.name)
    with stages("targets"):
        targets = targets_of(matches).at(intake.report.original_vertices)
        surface = matched_surface(matches)
    with stages("deformation"):
        deformation = fitted_shape(shape, targets, surface, sizing=options.sizing)
    return fit_of(Solved(matches, intake, shape, targets, deformation), options, stages)


def _matches(
    result: MatchResult | Assembly | Sequence[MatchResult],
) -> tuple[MatchResult, ...]:
    if isinstance(result, MatchResult):
        return (result,)
    if isinstance(result, Assembly):
        found = tuple(
            piece.match for piece in result.pieces if piece.placed and piece.match is not None
        )
        if not found:
            raise InfeasibleError("no piece of the assembly has a place to fit the full shape to")
    else:
        found = tuple(result) if isinstance(result, Sequence) else ()
        if not found or not all(isinstance(match, MatchResult) for match in found):
            raise InputError(
                f"a {type(result).__name__} cannot be fitted to; match or assemble first"
            )
    first = found[0]
    for match in found[1:]:
        if not np.array_equal(match.full.vertices, first.full.vertices):
            raise InputError(
                f"{match.part.name} was matched to another full shape than {first.part.name}"
            )
        if not np.isclose(match.scale, first.scale):
            raise InputError(
                f"{match.part.name} was matched with scale {match.scale:.4g}, {first.part.name} "
                f"with {first.scale:.4g}; pieces of one pose have one scale: give it (scale=...)"
            )
    return found
