"""Units of length, and which of them would explain that two shapes differ in size."""

from __future__ import annotations

from typing import Literal, TypeAlias, get_args

__all__ = ["UNITS", "Unit", "likely_units", "unit_factor", "unit_proposal", "units_of_two"]

Unit: TypeAlias = Literal["mm", "cm", "m", "in", "ft"]
UNITS: tuple[Unit, ...] = get_args(Unit)

METERS: dict[Unit, float] = {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254, "ft": 0.3048}
NAMES: dict[Unit, str] = {
    "mm": "millimeters", "cm": "centimeters", "m": "meters", "in": "inches", "ft": "feet",
}  # fmt: skip
# Pairs that files are mistaken between, the most usual first: numbers in the first unit are 1000,
# 100, 10, 25.4, 39.37, 304.8 and 3.281 times as large as in the second.
MISTAKEN: tuple[tuple[Unit, Unit], ...] = (
    ("mm", "m"), ("cm", "m"), ("mm", "cm"), ("mm", "in"), ("in", "m"), ("mm", "ft"), ("ft", "m"),
)  # fmt: skip
# Parts have between 4 % and, with some stretch, 120 % of the area of the full shape; in length:
LEAST, MOST = 0.2, 1.1


def unit_factor(part_unit: Unit, full_unit: Unit) -> float:
    """By what to multiply lengths in the unit of the part to have them in that of the full shape.

    Examples
    --------
    >>> unit_factor("mm", "m")
    0.001
    """
    return METERS[part_unit] / METERS[full_unit]


def likely_units(ratio: float) -> tuple[tuple[Unit, Unit], ...]:
    """Units of the part and of the full shape that would explain their sizes; none if they agree.

    Parameters
    ----------
    ratio
        sqrt of the area of the part over that of the full shape, as their files say.

    Examples
    --------
    >>> likely_units(650.0), likely_units(0.7)
    ((('mm', 'm'),), ())
    """
    if LEAST <= ratio <= MOST:
        return ()
    pairs = MISTAKEN if ratio > 1 else tuple((full, part) for part, full in MISTAKEN)
    return tuple(pair for pair in pairs if LEAST <= ratio * unit_factor(*pair) <= MOST)


def unit_proposal(ratio: float, *, options: bool = True) -> str:
    """The likely units in a sentence that says what to type; empty if there are none.

    Parameters
    ----------
    ratio
        As for :func:`likely_units`.
    options
        Whether the question has options for units; if not, the vertices are to be scaled.
    """
    said = [
        f"if the part is in {NAMES[part]} and the full shape in {NAMES[full]}, "
        + (
            f'give part_unit="{part}", full_unit="{full}" (--part-unit {part} --full-unit {full})'
            if options
            else f"multiply the vertices of the part by {unit_factor(part, full):.6g}"
        )
        for part, full in likely_units(ratio)
    ]
    return f"the sizes would fit {'; or '.join(said)}" if said else ""


def units_of_two(one: str, other: str, ratio: float) -> str:
    """The most usual units of two pieces in a sentence; empty if none would explain their sizes.

    Either may be the larger one.

    Parameters
    ----------
    one, other
        Their names.
    ratio
        sqrt of the area of the first over that of the second, as their files say.

    Examples
    --------
    >>> units_of_two("a", "b", 0.0012)
    'if a is in meters and b in millimeters, multiply the vertices of a by 1000 or those of b by 0.001'
    """  # noqa: E501 - a line that is said
    pairs = MISTAKEN if ratio > 1 else tuple((there, here) for here, there in MISTAKEN)
    for here, there in pairs:
        if LEAST <= ratio * unit_factor(here, there) <= 1 / LEAST:
            return (
                f"if {one} is in {NAMES[here]} and {other} in {NAMES[there]}, multiply the "
                f"vertices of {one} by {unit_factor(here, there):.6g} or those of {other} by "
                f"{unit_factor(there, here):.6g}"
            )
    return ""
