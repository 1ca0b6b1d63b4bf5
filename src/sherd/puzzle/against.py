"""What speaks against the place of a piece on a whole: its skin there, and that it is folded."""

from __future__ import annotations

from scipy.special import logit

from sherd.correspondence.confidence import measured_chance, share_laid_double
from sherd.correspondence.shared.relief_correlation import alike_where_laid
from sherd.correspondence.working_placement import WorkingPlacement

__all__ = ["alike_there", "log_odds_against", "lowered"]

# How alike the relief of the skin is, at least, where a piece lies right, and by how much less
# likely the less alike makes it, in log odds. Of a logistic regression of both sides of that bound,
# with the log odds of chances among the others as an offset, over 1,190 trials of 252 puzzles of 21
# animals and people in three and five pieces, 890 of the trials right (error below 0.05). What is
# more alike is no surer: a leg on another leg of its body is alike, too (docs/experiments.md).
ALIKE, LESS_ALIKE = 0.38, 7.5
# The same of the share that is laid double: none of those right ones has more than 0.11.
DOUBLE, MORE_DOUBLE = 0.1, 13.0


def alike_there(placement: WorkingPlacement) -> float | None:
    """How alike the skin of a piece is where it lies; see :func:`alike_where_laid`."""
    return alike_where_laid(placement.question, placement.deformation)


def log_odds_against(placement: WorkingPlacement, alike: float | None) -> float:
    """What speaks against a placement, to be added to the log odds of its chance; at most 0.

    A piece may be bent into any gap, and then neighbors and sizes speak for it. But bumps and
    hollows do not come to lie on bumps and hollows by that, as nothing is laid by them; and to fill
    a gap it may be folded.

    Parameters
    ----------
    placement
        Of a piece on a whole.
    alike
        How alike its skin is there, see `alike_there`.
    """
    skin = 0.0 if alike is None else min(LESS_ALIKE * (alike - ALIKE), 0.0)
    double = share_laid_double(placement.question.part, placement.deformation)
    return skin - MORE_DOUBLE * max(double - DOUBLE, 0.0)


def lowered(chance: float, against: float) -> float:
    """The chance of a place by all else, if what speaks against it is asked as well."""
    return measured_chance(float(logit(chance)) + against)
