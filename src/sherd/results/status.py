"""Status: how far an answer as a whole can be trusted."""

from __future__ import annotations

from enum import Enum

__all__ = ["Status"]


class Status(Enum):
    """How far the answer can be trusted as a whole; the value of each member is the advice.

    Wrong input is an exception, never a status.

    Examples
    --------
    >>> Status.GOOD.advice
    'good: neighborhoods agree and the part keeps its shape'
    """

    GOOD = "good: neighborhoods agree and the part keeps its shape"
    DOUBTFUL = (
        "doubtful: the part fits the full shape hardly better than another shape would; look at "
        "the alternatives, check the scale, or give landmarks"
    )
    FOREIGN = (
        "does not belong here: what was found is no more alike than chance; ask with another "
        "shape, check the scale, or give landmarks"
    )

    @property
    def advice(self) -> str:
        """What to do about it, in a sentence."""
        return self.value
