"""Convergence: why a solver stopped, with advice."""

from __future__ import annotations

from enum import Enum

__all__ = ["Convergence"]


class Convergence(Enum):
    """Why a solver stopped; the value of each member is the advice to the user.

    Wrong input is an exception, never a status. A question without answer, such as a part
    larger than the full shape, raises :class:`sherd.errors.InfeasibleError`.

    Examples
    --------
    >>> Convergence.CONVERGED.succeeded, Convergence.ITERATION_LIMIT.succeeded
    (True, False)
    """

    CONVERGED = "converged: the optimality conditions hold within the tolerance"
    ITERATION_LIMIT = (
        "iteration limit reached: the answer is feasible but may improve; allow more iterations"
    )
    STALLED = (
        "stalled: no step lowers the energy at this precision; loosen the tolerance, or raise "
        "the regularity if the membership looks rough"
    )
    NUMERICAL = "numerical failure of the solver; use another solver or rescale the descriptors"

    @property
    def succeeded(self) -> bool:
        """True if the answer satisfies its optimality conditions."""
        return self is Convergence.CONVERGED

    @property
    def advice(self) -> str:
        """What to do about it, in a sentence."""
        return self.value
