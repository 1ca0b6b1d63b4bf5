"""WayBack: from the repaired part without ignored vertices to the numbering of the user."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Bools, Floats, Ints
from sherd.mesh.surface_points import SurfacePoints
from sherd.results.placement import Placement
from sherd.scan.intake import Intake
from sherd.scan.numbering import nearest_repaired, original_points
from sherd.threads import cached_property

__all__ = ["WayBack"]


@dataclass(frozen=True, eq=False)
class WayBack:
    """Carries answers for the kept vertices of the repaired part to all that the user gave.

    Attributes
    ----------
    full, part
        Both shapes as they came in.
    kept
        (k,) index among the repaired part's vertices of each vertex that was asked about.
    """

    full: Intake
    part: Intake
    kept: Ints

    @cached_property
    def _sources(self) -> tuple[Ints, Bools]:
        """For each repaired vertex the kept one that answers for it, and whether it is itself."""
        vertices = self.part.mesh.vertices
        known = np.zeros(len(vertices), dtype=bool)
        known[self.kept] = True
        source = np.empty(len(vertices), dtype=np.int64)
        source[self.kept] = np.arange(len(self.kept))
        if not known.all():
            source[~known] = cKDTree(vertices[self.kept]).query(vertices[~known])[1]
        return source, known

    def placement(
        self,
        points: SurfacePoints,
        mask: Bools,
        membership: Floats,
        *,
        score: float,
        mirrored: bool = False,
        matched: Bools | None = None,
        confidence: Floats | None = None,
    ) -> Placement:
        """The placement as the user counts; `points`, `matched`, `confidence` are of kept vertices.

        Vertices that were ignored or have no face are unmatched; their best guess is the nearest
        one's answer.
        """
        lift = self.full.report.to_original
        return Placement(
            mask=np.asarray(lift(mask, fill=False), dtype=np.bool_),
            membership=np.asarray(lift(membership, fill=0.0), dtype=np.float64),
            score=score,
            mirrored=mirrored,
            points=self._points(points),
            matched=None if matched is None else self._matched(matched),
            confidence=None if confidence is None else self._confidence(confidence),
        )

    def _points(self, points: SurfacePoints) -> SurfacePoints:
        found = original_points(self.full, points[self._sources[0]])
        return found[nearest_repaired(self.part)]

    def _matched(self, matched: Bools) -> Bools:
        source, known = self._sources
        lifted = self.part.report.to_original(matched[source] & known, fill=False)
        return np.asarray(lifted, dtype=np.bool_)

    def _confidence(self, confidence: Floats) -> Floats:
        source, known = self._sources
        here = np.where(known, confidence[source], 0.0)
        return np.asarray(self.part.report.to_original(here, fill=0.0), dtype=np.float64)
