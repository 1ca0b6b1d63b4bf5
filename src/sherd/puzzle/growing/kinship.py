"""Whether pieces have the same skin, wherever on them that is.

A place needs labels that fit together, and most of what belongs and has none is bent where it would
be seen. But bumps and hollows of the same skin, or of that of a twin, are more alike than those of
two things ever are, on the stiff parts of a limb in every pose. So each node of a piece is compared
with all places of the others, as it is and mirrored. How alike the best one is by accident goes
with how much is seen, how smooth it is and how many places there are; the same surface turned
inside out has all of that, and its skin is nobody's.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import cache

import numpy as np

from sherd.arrays import Singles
from sherd.descriptors.relief_patches import ReliefPatches, similarity_anywhere
from sherd.surface.described import DescribedSurface
from sherd.threads import one_blas_thread

__all__ = ["KIN", "Kinship"]

# The node that counts: nine in ten may be less alike, as they lie where a pose bends, at the cut,
# or where there is little to see.
TELLING = 0.9
# Where reversed skin is more alike than this there is too little relief to tell by. Of animals and
# people it is 0.758 at most, of animals made of round cones 0.81 to 0.89: to these a limb of
# another one is as alike as an own one.
PLAIN = 0.78
# Who is more alike than reversed by so much has their skin. Of 573 pieces of other species, on the
# pieces of 30 puzzles of people, cats, horses, wolves, dogs, cows, lions and foxes, 97 in a hundred
# have less than 0.1 and the most is 0.150 (a lion's leg on a dog). Of 180 own ones, asked of the
# other five, 88 have this and more: of people nearly all, of horses most, of cats few. But so have
# 26 of 42 pieces of other people; of 30 of other animals of the same kind none has more than 0.102.
KIN = 0.16


class Kinship:
    """How much more alike the skin of some pieces is to that of others than to its reverse.

    Parameters
    ----------
    described
        The piece with a number; all in one unit, sqrt(area) of what may be their whole.
    """

    def __init__(self, described: Callable[[int], DescribedSurface]) -> None:
        @cache
        def nodes(number: int) -> ReliefPatches:
            surface = described(number)
            return surface.patches_at(surface.sparse.vertices)

        @cache
        def places(number: int) -> ReliefPatches:
            surface = described(number)
            return surface.patches_at(surface.dense.vertices)

        @cache
        def alike(number: int, other: int) -> tuple[Singles, Singles]:
            """Of each node, as it is or mirrored, whichever is more alike."""
            own = nodes(number)
            seen = [similarity_anywhere(places(other), each) for each in (own, own.mirrored())]
            best, reverse = np.max(seen, axis=0)
            return best, reverse

        self._alike = alike

    @one_blas_thread()
    def of(self, numbers: Collection[int], others: Collection[int]) -> float:
        """Of what tells most of pieces; 0 where that is too plain to tell anything."""
        best, reverse = np.zeros((2, 1), dtype=np.float32)
        for other in others:
            here = np.concatenate([self._alike(k, other) for k in numbers], axis=1)
            best, reverse = np.maximum(best, here[0]), np.maximum(reverse, here[1])
            if np.quantile(reverse, TELLING) > PLAIN:  # it only grows with more others
                return 0.0
        return float(np.quantile(best - reverse, TELLING))
