"""Individuals of another size: the second match takes the lengths of the first answer."""

from __future__ import annotations

from dataclasses import replace

import pytest

from sherd.errors import InfeasibleError, OptionError
from sherd.library import fitted_scale
from sherd.library.fitted_scale import length_ratio_of, match_with_fitted_scale
from sherd.mesh.sizes import check_sizes


@pytest.fixture(scope="module")
def exact(exhibit_of_size, match_result_of):
    return match_result_of(exhibit_of_size())


def _smaller(exact, factor: float):
    return replace(exact, part=exact.part.with_vertices(exact.part.vertices / factor))


def test_lengths_on_both_shapes_are_compared(exact) -> None:
    assert length_ratio_of(exact) == pytest.approx(1.0, abs=1e-9)
    assert length_ratio_of(_smaller(exact, 1.1)) == pytest.approx(1.1, abs=1e-9)
    known = replace(_smaller(exact, 1.1), scale=1.1)
    assert length_ratio_of(known) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize(
    ("factor", "second_score", "scales"),
    [(1.1, 0.95, [1.1]), (1.1, 0.5, [1.1]), (1.01, 0.95, []), (2.0, 0.95, [])],
)
def test_the_better_answer_is_taken(exact, monkeypatch, factor, second_score, scales) -> None:
    part = _smaller(exact, factor)
    asked = []

    def matched(_full, _part, options, *, stages):
        if options.scale == "same":
            return part
        asked.append(options.scale)
        best = replace(part.best, score=second_score)
        return replace(part, scale=options.scale, best=best)

    monkeypatch.setattr(fitted_scale, "match", matched)
    found = match_with_fitted_scale(exact.full, part.part)
    assert asked == pytest.approx(scales)
    taken = bool(scales) and second_score > part.best.score
    assert found.scale == pytest.approx(factor if taken else 1.0)


@pytest.mark.parametrize(("larger", "asked"), [(1.1, [1.1]), (1.2, [1.14018]), (1.6, [])])
def test_a_whole_that_is_larger_is_asked_at_the_largest_size_that_fits(
    exact, monkeypatch, larger, asked
) -> None:
    """A part may have 1.3 times the area of the full shape: 1.14018 times its lengths."""
    part = exact.full.with_vertices(exact.full.vertices * larger)
    sizes = []

    def matched(_full, scan, options, *, stages):
        check_sizes(exact.full, scan.mesh, factor=options.factor)
        sizes.append(options.factor * larger)
        return exact

    monkeypatch.setattr(fitted_scale, "match", matched)
    if asked:
        match_with_fitted_scale(exact.full, part)
    else:
        with pytest.raises(InfeasibleError, match="are the two swapped"):
            match_with_fitted_scale(exact.full, part)
    assert sizes == pytest.approx(asked, abs=1e-4)


def test_an_unknown_scale_is_fitted_anyway(exact) -> None:
    with pytest.raises(OptionError, match="is fitted anyway"):
        match_with_fitted_scale(exact.full, exact.part, scale="unknown")
