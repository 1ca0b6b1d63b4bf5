"""The two shapes of a question, described in one unit."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Ints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.scan.intake import Intake, MeshSource
from sherd.spectral.denoising import denoised
from sherd.surface.described import DescribedSurface
from sherd.surface.template import Template
from sherd.surface.working import canonical, working_surface

__all__ = ["as_template", "described_part"]


def as_template(full: MeshSource | Intake | Template) -> Template:
    """The full shape, described; a template stays itself."""
    return full if isinstance(full, Template) else Template(full)


def described_part(
    part: TriangleMesh, length: float, *, sampled_at: Ints | None = None
) -> DescribedSurface:
    """The part in units of the full shape, its noise lowered.

    Parameters
    ----------
    part
        The repaired part.
    length
        What `sqrt(area)` of the full shape is in the unit of the part.
    sampled_at
        (p,) vertices of the part that must be among its sparse samples.
    """
    working = working_surface(denoised(canonical(part, length)))
    named = None if sampled_at is None else np.unique(working.working_vertices(sampled_at))
    return DescribedSurface(working, sampled_at=named)
