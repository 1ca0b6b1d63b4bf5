"""Candidate: a full shape that a part may belong to, cheap to ask, loaded in full when needed."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from sherd.errors import InputError
from sherd.scan.intake import MeshSource
from sherd.surface.coarse import coarse_surface
from sherd.surface.described import DescribedSurface
from sherd.surface.prepared import as_template
from sherd.surface.template import Template

__all__ = ["Candidate", "candidates_of"]


@dataclass(frozen=True, eq=False)
class Candidate:
    """One of several full shapes.

    Attributes
    ----------
    name
        Unlike the names of the others.
    area
        In its own unit, squared.
    coarse
        Its labels alone.
    template
        Gives the shape with all that matching needs.
    """

    name: str
    area: float
    coarse: DescribedSurface
    template: Callable[[], Template]

    @property
    def length(self) -> float:
        """sqrt(area) in its own unit."""
        return float(self.area**0.5)


def candidates_of(fulls: Iterable[MeshSource | Template]) -> tuple[Candidate, ...]:
    """Each full shape as a candidate; shapes of one name are numbered.

    Raises
    ------
    InputError
        If there is none; otherwise as :func:`sherd.match` does for a full shape.
    """
    templates = [as_template(full) for full in fulls]
    if not templates:
        raise InputError("no full shape is given; name one at least, or a library of some")
    names = [template.full.name for template in templates]
    return tuple(
        _candidate(template, name if names.count(name) == 1 else f"{name} ({number})")
        for number, (name, template) in enumerate(zip(names, templates, strict=True))
    )


def _candidate(template: Template, name: str) -> Candidate:
    return Candidate(name, template.length**2, coarse_surface(template), lambda: template)
