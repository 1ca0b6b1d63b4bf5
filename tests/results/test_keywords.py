"""match and locate take their options as an object or as keywords, and say what is wrong."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import pytest

import sherd
from sherd.errors import InfeasibleError, OptionError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.keywords import options_of
from sherd.results.locate_options import LocateKeywords, LocateOptions
from sherd.results.match_options import MatchKeywords, MatchOptions

SMALL = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
LARGE = SMALL.with_vertices(100 * SMALL.vertices)


@pytest.mark.parametrize(
    ("options", "keywords"), [(MatchOptions, MatchKeywords), (LocateOptions, LocateKeywords)]
)
def test_keywords_are_the_fields_of_the_options(options: Any, keywords: Any) -> None:
    assert list(keywords.__annotations__) == [each.name for each in fields(options)]


def test_keywords_make_the_same_options() -> None:
    made = options_of(MatchOptions, None, {"scale": "unknown", "ignore": [False, True]})
    assert made == MatchOptions(scale="unknown", ignore=(1,))
    assert options_of(LocateOptions, None, {}) == LocateOptions()
    assert options_of(LocateOptions, LocateOptions(seed=3), {}).seed == 3


def test_keywords_reach_the_question() -> None:
    """Each is refused by the options it belongs to, before any shape is looked at."""
    with pytest.raises(OptionError, match="scale"):
        sherd.match("nowhere.ply", "nowhere.ply", scale="large")
    with pytest.raises(OptionError, match="method"):
        sherd.locate("nowhere.ply", "nowhere.ply", method="guess")
    with pytest.raises(InfeasibleError):
        sherd.match(SMALL, LARGE, seed=3)
    with pytest.raises(InfeasibleError):
        sherd.locate(SMALL, LARGE, seed=3)


@pytest.mark.parametrize(
    ("ask", "options"), [(sherd.match, MatchOptions()), (sherd.locate, LocateOptions())]
)
def test_what_contradicts_or_does_not_exist_is_refused(ask: Any, options: Any) -> None:
    with pytest.raises(OptionError, match=r"options and seed=\.\.\. are both given"):
        ask(SMALL, SMALL, options, seed=0)
    with pytest.raises(OptionError, match=r"'sede' is no option; known are .*side, seed"):
        ask(SMALL, SMALL, sede=0)
    with pytest.raises(OptionError, match=f"but takes {type(options).__name__}"):
        ask(SMALL, SMALL, {"seed": 0})
