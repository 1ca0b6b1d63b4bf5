"""What speaks against an answer as a whole, and what to do about it, in words."""

from __future__ import annotations

from dataclasses import dataclass

from sherd.results.status import Status

__all__ = ["Doubts", "OverlapDoubts", "UnfollowedLandmark"]

# So many landmarks are named in the advice; the result has them all.
NAMED = 5
# Calibrated chances: what is called good is right in two cases of three at the least, and what is
# said not to belong in one case of ten at the most.
SURE, FOREIGN = 0.65, 0.1
FACTOR = "a factor (scale=FACTOR, --scale FACTOR)"
UNLIKE = (
    "the part fits the full shape hardly better than another shape would; look at the "
    "alternatives, give the scale if you know it, or give landmarks"
)


@dataclass(frozen=True)
class UnfollowedLandmark:
    """A landmark that the answer does not follow, or that others contradict.

    Attributes
    ----------
    part_vertex, full_vertex
        The landmark.
    distance
        On the full shape from `full_vertex` to the answer for `part_vertex`, in sqrt(area).
    contradicts
        Vertices of the part whose landmarks cannot be true together with this one: on the full
        shape they lie farther apart than the part allows.
    """

    part_vertex: int
    full_vertex: int
    distance: float
    contradicts: tuple[int, ...] = ()


@dataclass(frozen=True)
class Doubts:
    """What speaks against an answer; nothing by default.

    Attributes
    ----------
    chance
        That the placement as a whole is right.
    featureless
        Whether the part looks the same everywhere, as a plane, a sphere or a tube does.
    elsewhere
        Whether the part fits about as well in another place.
    twin
        Whether the mirror image of the part fits better than the part.
    unchecked
        What did not pass the check that is re-derived from the meshes; nothing if it passed.
    unlike
        Whether another shape would fit about as well.
    doubled
        Share of the part that is laid where another place of it is, if that is too much.
    scale_unknown
        Whether the scale was estimated.
    scale_bound
        The scale, if it stands at its bound.
    scale_rival
        Another scale at which it fits about as well, if there is one.
    unfollowed
        Landmarks that were not followed or contradict each other.
    units
        A sentence that proposes units, or nothing.

    Examples
    --------
    >>> Doubts().status.name, Doubts(scale_bound=2.0).status.name
    ('GOOD', 'DOUBTFUL')
    """

    chance: float = 1.0
    featureless: bool = False
    elsewhere: bool = False
    twin: bool = False
    unchecked: str = ""
    unlike: bool = False
    doubled: float = 0.0
    scale_unknown: bool = False
    scale_bound: float | None = None
    scale_rival: float | None = None
    unfollowed: tuple[UnfollowedLandmark, ...] = ()
    units: str = ""

    @property
    def status(self) -> Status:
        """Good if nothing speaks against it."""
        if self.chance < FOREIGN:
            return Status.FOREIGN
        doubtful = (
            self.chance < SURE
            or self.featureless
            or self.elsewhere
            or self.twin
            or self.unchecked
            or self.unlike
            or self.doubled > 0
            or self.scale_bound is not None
            or self.scale_rival is not None
            or self.unfollowed
        )
        return Status.DOUBTFUL if doubtful else Status.GOOD

    @property
    def advice(self) -> str:
        """What to do, with the names of what is wrong."""
        if self.status is Status.GOOD:
            return Status.GOOD.advice
        said = self._said_of_fit()
        if self.unlike and not said:
            plain = not self._said_of_scale() and not self.unfollowed and not self.units
            if plain and not self.scale_unknown:
                return Status.DOUBTFUL.advice
            said = [UNLIKE]
        said += self._said_of_scale()
        if self.unfollowed:
            said.append(_said_of_landmarks(self.unfollowed))
        if self.units:
            said.append(self.units)
        words = "does not belong here" if self.status is Status.FOREIGN else "doubtful"
        return f"{words}: {'; '.join(said)}"

    def _said_of_scale(self) -> list[str]:
        return _said_of_scale(
            self.scale_bound, self.scale_rival, f"the units of both shapes or {FACTOR}"
        )

    def _said_of_fit(self) -> list[str]:
        said = []
        if self.chance < SURE:
            said.append(
                f"the chance that the placement is right is {self.chance:.2f}; look at it in the "
                "report, ask with another full shape, or give landmarks"
            )
        if self.featureless:
            said.append(
                "the part looks the same everywhere and fits anywhere; give a larger part or "
                "landmarks"
            )
        if self.elsewhere:
            said.append(
                "the part fits about as well in another place, as one of several that are alike; "
                "look at the alternative, give a larger part or landmarks"
            )
        if self.twin:
            said.append(
                "its mirror image fits better than the part itself; look at the alternative, or "
                "give landmarks on one side"
            )
        if self.doubled > 0:
            said.append(
                f"{self.doubled:.0%} of the part lie where another place of it does, as two legs "
                "on one leg or two layers on one; look at it in the report, or give landmarks"
            )
        if self.unchecked:
            said.append(f"the answer does not pass its check: {self.unchecked}")
        return said


NOTHING = (
    "does not belong: nothing that both shapes share was found; they may share too little, differ "
    "in scale, or be different things; give landmarks if you know some"
)


@dataclass(frozen=True)
class OverlapDoubts:
    """What speaks against an overlap; nothing by default.

    Attributes
    ----------
    chance
        That the answer as a whole is right.
    shared
        Whether anything is shared.
    checked
        Whether the answer passes the check that is re-derived from the meshes.
    twin
        Whether the mirror image of one shape is more alike the other, at the same place too.
    scale_bound
        The scale, if it stands at its bound.
    scale_rival
        Another scale at which it fits about as well, if there is one.
    unfollowed
        Landmarks that were not followed.
    """

    chance: float = 1.0
    shared: bool = True
    checked: bool = True
    twin: bool = False
    scale_bound: float | None = None
    scale_rival: float | None = None
    unfollowed: tuple[UnfollowedLandmark, ...] = ()

    @property
    def status(self) -> Status:
        """Good if nothing speaks against it."""
        if not self.shared or self.chance < FOREIGN:
            return Status.FOREIGN
        doubtful = (
            self.chance < SURE
            or not self.checked
            or self.twin
            or self.scale_bound is not None
            or self.scale_rival is not None
            or self.unfollowed
        )
        return Status.DOUBTFUL if doubtful else Status.GOOD

    @property
    def advice(self) -> str:
        """What to do, with the names of what is wrong."""
        if self.status is Status.GOOD:
            return "good: both directions agree and neighborhoods are alike"
        if not self.shared:
            return NOTHING
        said = []
        if self.chance < SURE:
            said.append(
                f"the chance that the answer is right is {self.chance:.2f}; look at both shapes in "
                "the report, or give landmarks"
            )
        if not self.checked:
            said.append("areas, or there and back, do not agree; look at both shapes in the report")
        if self.twin:
            said.append(
                "the mirror image of one is more alike the other, as a left limb and a right one "
                "are; look at both, or give landmarks"
            )
        said += _said_of_scale(self.scale_bound, self.scale_rival, FACTOR)
        if self.unfollowed:
            said.append(_said_of_landmarks(self.unfollowed))
        words = "does not belong" if self.status is Status.FOREIGN else "doubtful"
        return f"{words}: {'; '.join(said)}"


def _said_of_scale(bound: float | None, rival: float | None, give: str) -> list[str]:
    said = []
    if bound is not None:
        said.append(f"the scale stands at its bound, {bound:.4g}; give {give}")
    if rival is not None:
        said.append(f"the part fits about as well at another scale, {rival:.4g}; give {give}")
    return said


def _said_of_landmarks(landmarks: tuple[UnfollowedLandmark, ...]) -> str:
    named = []
    for each in landmarks[:NAMED]:
        text = (
            f"part vertex {each.part_vertex} on full vertex {each.full_vertex} "
            f"({each.distance:.2f} sqrt(area) from the answer"
        )
        if each.contradicts:
            others = ", ".join(str(vertex) for vertex in each.contradicts[:NAMED])
            more = ", ..." if len(each.contradicts) > NAMED else ""
            text += f", contradicts that of part vertex {others}{more}"
        named.append(f"{text})")
    if len(landmarks) > NAMED:
        named.append(f"{len(landmarks) - NAMED} more")
    return (
        f"landmarks that are not followed or contradict each other: {', '.join(named)}; correct "
        "them or leave them out"
    )
