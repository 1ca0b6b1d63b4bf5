"""Results whose map is known exactly: the part is a piece of the full shape itself, moved."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from sherd.mesh.surface_points import SurfacePoints
from sherd.results.match_options import MatchOptions
from sherd.results.match_result import MatchResult
from sherd.results.placement import Placement
from sherd.results.status import Status
from sherd.shapes.creature import creature, landmarks
from sherd.shapes.fragment import Fragment, cut_by_ball, moved, remeshed, whole


@pytest.fixture(scope="session")
def fragment() -> Fragment:
    """The head and the front legs, meshed anew: the truth lies inside faces."""
    full = creature(5000)
    piece = cut_by_ball(whole(full, full), landmarks(full)["nose"], 0.6)
    return moved(remeshed(piece, 1.2), np.random.default_rng(0))


@pytest.fixture(scope="session")
def answered(fragment: Fragment) -> Callable[[SurfacePoints], MatchResult]:
    """A result whose answers are the given points; three vertices are unmatched."""
    count, mask = fragment.mesh.vertex_count, fragment.region
    best = Placement(
        mask=mask,
        membership=mask.astype(float),
        score=0.9,
        points=fragment.truth,
        matched=np.arange(count) >= 3,
        confidence=np.linspace(0.5, 1.0, count),
    )

    def result(points: SurfacePoints) -> MatchResult:
        return MatchResult(
            full=fragment.full,
            part=fragment.mesh,
            best=replace(best, points=points),
            alternatives=(),
            scale=1.0,
            second_score=0.8,
            twin_score=0.3,
            status=Status.GOOD,
            timings={},
            options=MatchOptions(),
        )

    return result


@pytest.fixture(scope="session")
def known(fragment: Fragment, answered: Callable[[SurfacePoints], MatchResult]) -> MatchResult:
    return answered(fragment.truth)
