"""locate(full, part): the region of the full shape where the part belongs."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np
from threadpoolctl import threadpool_limits

from sherd._version import __version__
from sherd.energy.problem import LARGEST_AREA_RATIO
from sherd.errors import InfeasibleError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import Stages
from sherd.region.integral_matching import locate_by_integrals
from sherd.region.lift import Lift
from sherd.region.options import LocateOptions
from sherd.region.region import Placement, Region
from sherd.region.voting import locate_by_voting
from sherd.template import refuse_tiny_part, working_mesh

__all__ = ["locate"]


def locate(
    full: TriangleMesh,
    part: TriangleMesh,
    options: LocateOptions | None = None,
    *,
    stages: Stages | None = None,
) -> Region:
    """Find where on `full` the deformed, incomplete `part` belongs.

    Rotation, translation, vertex order, meshing and the common unit do not matter; the part's
    scale is that of the full shape.

    Parameters
    ----------
    full
        The whole shape.
    part
        A deformed piece of it; at most 1.05 times its area.
    options
        The defaults of :class:`LocateOptions` if None.
    stages
        Collects timings and shows progress; a silent one if None.

    Returns
    -------
    Region
        Membership, mask, phase field, score, alternatives; ``region.check()`` proves it.

    Raises
    ------
    InfeasibleError
        If the part is larger than 1.05 times the full shape or a dot on it, or a shape has no
        area.

    Notes
    -----
    About 4 s for 10,000 + 5,000 vertices on two cores. Larger meshes are decimated for the
    search, and the answer is carried back to every vertex.

    References
    ----------
    Hurtado-Jauregui, *Piece-wise partial matching of non-rigid shapes*: energy, subspace and, as
    future work there, the logistic membership. The votes are our own, see
    :mod:`sherd.region.soft_match`.
    """
    options = options or LocateOptions()
    stages = stages or Stages(visible=False)
    _check_areas(full, part)
    # At area 1 and at the origin, so that no number below depends on the unit of the files, and on
    # meshes of moderate size, so that the time does not depend on how finely they were sampled.
    placed = _moved(full, full.length)
    unit_full, unit_part = working_mesh(placed), working_mesh(_moved(part, full.length))
    method = locate_by_voting if options.method == "voting" else locate_by_integrals
    # Two BLAS threads are slower than one at these sizes, and their order of sums may vary.
    with threadpool_limits(limits=1, user_api="blas"):
        found = method(unit_full, unit_part, options, stages)
    with stages("numbering"):
        lift = Lift(unit_full, placed, min(part.area / full.area, 1.0))
        membership, mask = lift.region(found.membership, found.mask)
        alternatives = tuple(
            Placement(
                other.name, *lift.region(other.membership, other.mask), other.score, other.mirrored
            )
            for other in found.alternatives
        )
    return Region(
        full=full,
        part=part,
        membership=membership,
        mask=mask,
        phase_field=lift.values(found.phase_field),
        score=found.score,
        energy=found.energy,
        status=found.status,
        alternatives=alternatives,
        options=replace(
            options,
            regularity=found.weights.regularity,
            smoothness=found.weights.smoothness,
            boundary=found.weights.boundary,
            phase_width=found.weights.phase_width,
        ),
        timings=dict(stages.seconds),
        version=__version__,
        working_vertices=MappingProxyType(
            {"full": unit_full.vertex_count, "part": unit_part.vertex_count}
        ),
    )


def _check_areas(full: TriangleMesh, part: TriangleMesh) -> None:
    for mesh in (full, part):
        if not (np.isfinite(mesh.area) and mesh.area > 0):
            raise InfeasibleError(
                f"{mesh.name}: the surface has area {mesh.area}, so nothing can be matched; "
                "its faces are degenerate or its coordinates too small"
            )
    if part.area > LARGEST_AREA_RATIO * full.area:
        raise InfeasibleError(
            f"{part.name} has {part.area / full.area:.4g} times the area of {full.name}, but a "
            f"part is at most {LARGEST_AREA_RATIO} times as large as the full shape; are the two "
            "swapped, or in different units?"
        )
    refuse_tiny_part(part, full)


def _moved(mesh: TriangleMesh, unit: float) -> TriangleMesh:
    center = (mesh.vertices.max(axis=0) + mesh.vertices.min(axis=0)) / 2
    return mesh.with_vertices((mesh.vertices - center) / unit)
