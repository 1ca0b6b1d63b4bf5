"""A union that is nearly a whole: what is asked of it once, whichever limb is missing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sherd.arrays import Bools, Floats
from sherd.correspondence.confidence import LEAST, MOST
from sherd.correspondence.shared.told_placement import placed_where_told
from sherd.errors import InfeasibleError
from sherd.match import match_result
from sherd.mesh.surface_points import closest_points
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import Stages
from sherd.overlap import STRETCH, prepare_both_ways, queries_both_ways, questions_of
from sherd.place import placed_part
from sherd.puzzle.against import alike_there, log_odds_against, lowered
from sherd.puzzle.pairwise.answer import Meeting
from sherd.puzzle.pairwise.meeting import NOTHING_KNOWN
from sherd.results.match_options import MatchOptions
from sherd.results.match_result import MatchResult
from sherd.results.overlap_options import OverlapOptions
from sherd.scan.intake import scan_intake
from sherd.surface.described import DescribedSurface
from sherd.surface.prepared import described_part
from sherd.surface.template import Template
from sherd.surface.transformed import mirrored_mesh
from sherd.threads import cached_property, one_blas_thread

__all__ = ["Body", "Lying", "Told"]


@dataclass(frozen=True, eq=False)
class Told:
    """Where the vertices of a mesh lie on another one.

    Attributes
    ----------
    positions
        (n, 3) places, in the other mesh's own coordinates.
    known
        (n,) bool, of which of them this is known.
    """

    positions: Floats
    known: Bools


@dataclass(frozen=True, eq=False)
class Lying:
    """A surface matched with a body as its whole.

    Attributes
    ----------
    result
        Where it lies.
    against
        What speaks against that place, in log odds, at most 0; see :func:`log_odds_against`.
    """

    result: MatchResult
    against: float

    @property
    def chance(self) -> float:
        """That it lies right, by that as well."""
        return lowered(float(np.clip(self.result.chance or 0.0, LEAST, MOST)), self.against)


@dataclass(frozen=True, eq=False)
class Body:
    """A surface that asks all that are left, described once.

    Attributes
    ----------
    mesh
        Without what needs repair.
    seed
        Of all random choices.
    """

    mesh: TriangleMesh
    seed: int

    @cached_property
    def template(self) -> Template:
        """As a whole on which pieces are matched."""
        return Template(self.mesh)

    @cached_property
    def described(self) -> DescribedSurface:
        """As one of two that share something, in its own unit."""
        surface = described_part(self.mesh, self.mesh.length)
        prepare_both_ways(surface)
        return surface

    @one_blas_thread()
    def matched(self, second: TriangleMesh) -> Lying | None:
        """A surface as a piece of it; None where it cannot be, being larger, or a dot on it."""
        options, stages = MatchOptions(seed=self.seed), Stages(visible=False)
        try:
            placed = placed_part(self.template, scan_intake(second), options, stages)
        except InfeasibleError:
            return None
        against = log_odds_against(placed.best, alike_there(placed.best))
        return Lying(match_result(placed, stages), against)

    def image_matched(self, second: TriangleMesh) -> Lying | None:
        """The same of the mirror image of a surface; asked more than once, found once."""
        if second not in self._images:
            self._images[second] = self.matched(mirrored_mesh(second))
        return self._images[second]

    @cached_property
    def _images(self) -> dict[TriangleMesh, Lying | None]:
        return {}

    def met(self, second: TriangleMesh, told: Told) -> Meeting:
        """Both laid on each other where that is told; the chance is not known yet."""
        surfaces = (self.described, described_part(second, self.mesh.length))
        prepare_both_ways(surfaces[1])
        there, back = questions_of(surfaces, NOTHING_KNOWN, unknown=False)
        questions = (there.with_stretch(STRETCH), back.with_stretch(STRETCH))
        queries = queries_both_ways(questions, self.seed)
        own = closest_points(there.part.placed, there.part.mesh.vertices)
        feet = closest_points(self.mesh, told.positions).positions(there.full.placed)
        targets = own.interpolate(there.part.placed, feet)
        known = told.known[own.nearest_vertices(there.part.placed)]
        strain = OverlapOptions().strain
        placements = placed_where_told(questions, queries, targets, known, strain=strain)
        return Meeting(questions, queries, placements, self.mesh.length, LEAST, twin=False)
