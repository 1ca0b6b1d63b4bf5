"""The full shape fitted: coarse mesh first, then its own, faces that turned over mended."""

from __future__ import annotations

from sherd.fitting.as_rigid_as_possible import Elasticity
from sherd.fitting.crossing import without_new_crossings
from sherd.fitting.deformation import (
    Deformation,
    carried_up,
    coarse_deformation,
    fine_deformation,
)
from sherd.fitting.scan_surface import ScanSurface
from sherd.fitting.targets import Targets
from sherd.fitting.turned_faces import without_turned_faces
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
        own = Elasticity(shape)
        if shape.vertex_count <= 1.5 * COARSE:
            found = coarse_deformation(own, targets, scan, sizing=sizing)
        else:
            found = _through_coarse(shape, targets, scan, sizing=sizing)
        found = fine_deformation(own, found, targets, scan)
        found = without_new_crossings(own, without_turned_faces(own, found), targets.seen)
        return without_turned_faces(own, found)


def _through_coarse(
    shape: TriangleMesh, targets: Targets, scan: ScanSurface, *, sizing: Sizing
) -> Deformation:
    small, points = decimate(shape, max(COARSE, len(shape.boundary_vertices) + 1))
    corners = targets.seen[shape.faces[points.faces]] | (points.barycentric == 0)
    thinned = Targets(
        points.interpolate(shape, targets.positions),
        points.interpolate(shape, targets.confidence) * corners.all(axis=1),
    )
    found = coarse_deformation(Elasticity(small), thinned, scan, sizing=sizing)
    return carried_up(small, found, closest_points(small, shape.vertices), shape.vertices)
