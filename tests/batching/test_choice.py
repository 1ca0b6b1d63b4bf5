"""With several full shapes a part goes to the one it is identified with, and doubts are kept."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest

from sherd.batching import choice
from sherd.batching.templates import FullShape
from sherd.errors import InfeasibleError, OptionError
from sherd.results.match_options import MatchOptions
from sherd.results.status import Status

FULLS = tuple(FullShape(f"{name}.ply", name, name, Path(f"{name}.npz")) for name in ("cat", "dog"))


@pytest.fixture
def identified(monkeypatch):
    """`identified(name, status, match status, advice)`: what identification will say."""
    asked = []

    def say(name: str, status: Status, match: Status | None, advice: str = "") -> list:
        answer = None if match is None else SimpleNamespace(status=match)
        first = SimpleNamespace(name=name, match=answer)
        found = SimpleNamespace(candidates=(first,), status=status, advice=advice)

        def identify_among(known, part, options, stages):
            asked.append((known, options))
            return found

        monkeypatch.setattr(choice, "identify_among", identify_among)
        monkeypatch.setattr(choice, "_candidate", lambda full: full.name)
        return asked

    return say


def test_the_best_shape_is_taken_with_the_options_of_the_match(identified) -> None:
    asked = identified("dog.ply", Status.GOOD, Status.GOOD)
    chosen = choice.best_match(FULLS, None, MatchOptions(scale=2.0, seed=5, ignore=(1,)))
    assert chosen.full is FULLS[1]
    assert chosen.doubt == ""
    ((known, options),) = asked
    assert known == ["cat.ply", "dog.ply"]
    assert options.match_options == MatchOptions(scale=2.0, seed=5, ignore=(1,))


def test_a_good_match_is_doubtful_where_another_shape_fits_as_well(identified) -> None:
    identified("cat.ply", Status.DOUBTFUL, Status.GOOD, "fits cat.ply and dog.ply about equally")
    assert "about equally" in choice.best_match(FULLS, None, MatchOptions()).doubt
    identified("cat.ply", Status.DOUBTFUL, Status.DOUBTFUL, "doubtful")
    assert choice.best_match(FULLS, None, MatchOptions()).doubt == ""  # the match says so itself


def test_what_fits_none_by_size_and_landmarks_on_several_are_refused(identified) -> None:
    identified("cat.ply", Status.FOREIGN, None, "all are out of the question by size")
    with pytest.raises(InfeasibleError, match="by size"):
        choice.best_match(FULLS, None, MatchOptions())
    with pytest.raises(OptionError, match="column full"):
        choice.best_match(FULLS, None, MatchOptions(landmarks=((1, 2),)))
