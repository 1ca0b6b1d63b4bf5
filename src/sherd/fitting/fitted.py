"""The full shape fitted: coarse mesh first, then its own, faces that turned over mended."""

from __future__ import annotations

from collections.abc import Iterator

from sherd.fitting.as_rigid_as_possible import Elasticity
from sherd.fitting.deformation import (
    Deformation,
    carried_up,
    coarse_deformation,
    continued_deformation,
    fine_deformation,
)
from sherd.fitting.drift import without_drift
from sherd.fitting.mending.crossing import MOST_CROSSINGS, new_crossings, without_new_crossings
from sherd.fitting.mending.turned_faces import still_turned, without_turned_faces
from sherd.fitting.scan_surface import ScanSurface
from sherd.fitting.targets import Targets
from sherd.mesh.surface_points import closest_points
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.fitted.fit_options import Sizing
from sherd.spectral.sampling import decimate
from sherd.threads import one_blas_thread

__all__ = ["fitted_shape"]

# Poses are decided on so many vertices: 0.04 s for a factorization and a solve, where 10,000 take
# 0.2 s, and joints are still a dozen edges around.
COARSE = 4000


def fitted_shape(
    shape: TriangleMesh, targets: Targets, surface: TriangleMesh, *, sizing: Sizing
) -> Deformation:
    """The deformation of a shape that was repaired, at unit area, onto the pieces.

    Parameters
    ----------
    shape
        n vertices, in units of sqrt(area of the full shape).
    targets
        For its vertices.
    surface
        The matched faces of the pieces, in the same unit.
    sizing
        As of :class:`sherd.FitOptions`.
    """
    scan = ScanSurface(surface)
    with one_blas_thread():
        targets = without_drift(shape, targets, surface)
        own = Elasticity(shape)
        tried: list[tuple[int, int, Deformation]] = []
        for start in _starts(own, targets, scan, sizing=sizing):
            found = fine_deformation(own, start, targets, scan)
            found = without_new_crossings(own, without_turned_faces(own, found), targets.seen)
            found = without_turned_faces(own, found)
            turned, crossings = still_turned(own, found), new_crossings(own, found)
            # a fit of which more pierce others, or with a face that stays turned over, is in doubt
            if turned == 0 and crossings <= MOST_CROSSINGS * shape.face_count:
                return found
            tried.append((turned, crossings, found))
        return min(tried, key=lambda each: each[:2])[2]


def _starts(
    own: Elasticity, targets: Targets, scan: ScanSurface, *, sizing: Sizing
) -> Iterator[Deformation]:
    """The continued deformation, nearer to the truth, and the smooth one, which crosses less."""
    shape = own.mesh
    if shape.vertex_count <= 1.5 * COARSE:
        smooth = coarse_deformation(own, targets, scan, sizing=sizing)
        yield continued_deformation(own, smooth, targets, scan)
        yield smooth
        return
    small, points = decimate(shape, max(COARSE, len(shape.boundary_vertices) + 1))
    thinned = targets.between(shape, points)
    elasticity, places = Elasticity(small), closest_points(small, shape.vertices)
    smooth = coarse_deformation(elasticity, thinned, scan, sizing=sizing)
    continued = continued_deformation(elasticity, smooth, thinned, scan)
    for found in (continued, smooth):
        yield carried_up(small, found, places, shape.vertices)
