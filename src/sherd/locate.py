"""locate(full, part): the region of the full shape where the part belongs."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from types import MappingProxyType
from typing import Unpack

import numpy as np

from sherd.arrays import Bools, Floats, frozen
from sherd.correspondence.plausibility import (
    FEATURELESS,
    belonging_chance,
    first_energy_ratio,
    self_likeness,
)
from sherd.energy.cleanup import raised_to_area, threshold_to_area
from sherd.mesh.sides import bulge
from sherd.mesh.sizes import check_sizes
from sherd.output import Stages
from sherd.region.found import Found
from sherd.region.voting import locate_by_voting
from sherd.results.keywords import options_of
from sherd.results.locate_options import LocateKeywords, LocateOptions
from sherd.results.locate_result import LocateResult
from sherd.results.placement import Placement
from sherd.scan.either_side import SURE_BULGE, better_side
from sherd.scan.intake import Intake, MeshSource, ScanSource, scan_intake
from sherd.scan.numbering import turned_as_repaired
from sherd.surface.described import DescribedSurface
from sherd.surface.prepared import as_template, described_part
from sherd.surface.template import Template
from sherd.threads import begun, one_blas_thread

__all__ = ["STAGES", "locate", "locate_one_side"]

# Of the default method.
STAGES = (
    "descriptors", "eigenbasis", "samples", "votes", "region", "alternatives", "belonging",
    "numbering",
)  # fmt: skip


def locate(
    full: MeshSource | Template,
    part: ScanSource,
    options: LocateOptions | None = None,
    *,
    stages: Stages | None = None,
    **keywords: Unpack[LocateKeywords],
) -> LocateResult:
    """Find where on `full` the deformed, incomplete `part` belongs.

    Rotation, translation, vertex order, meshing and the common unit do not matter; the part's
    scale is that of the full shape.

    Parameters
    ----------
    full
        The whole shape: a mesh, the path of a file, a pair (vertices, faces), a
        ``trimesh.Trimesh``, or a :class:`sherd.Template` when many parts are to be located.
    part
        A deformed piece of it, at most 1.3 times its area; points will do.
    options
        The defaults of :class:`LocateOptions` if None.
    stages
        Collects timings and shows progress; a silent one if None.
    keywords
        The fields of :class:`LocateOptions`, instead of `options`.

    Returns
    -------
    LocateResult
        Membership, mask, phase field, score, alternatives; ``result.check()`` proves it.

    Raises
    ------
    OptionError
        If a keyword is unknown, or both `options` and keywords are given.
    InfeasibleError
        If the part is larger than 1.3 times the full shape or a dot on it, or a shape has no
        area.
    MeshFileError, InvalidMeshError, InputError
        If a shape cannot be read or is no mesh.

    Notes
    -----
    About 3 s for 10,000 + 5,000 vertices on two cores, a fifth of it to tell whether the part
    belongs at all; with a template that is kept, less. Larger meshes are decimated for the
    search, and the answer is carried back to every vertex.

    References
    ----------
    Hurtado-Jauregui, *Piece-wise partial matching of non-rigid shapes*: energy, subspace and, as
    future work there, the logistic membership. The votes are our own, see
    :mod:`sherd.region.soft_match`.

    Examples
    --------
    >>> from sherd.shapes import creature, cut_by_ball, whole
    >>> full = creature(5000)
    >>> part = cut_by_ball(whole(creature(5000, pose="walk"), full), 0, 0.5).mesh
    >>> locate(full, part).check().passed
    True
    """
    options = options_of(LocateOptions, options, keywords)
    stages = stages or Stages(visible=False)
    template = as_template(full)
    return better_side(
        scan_intake(part),
        options.side,
        lambda side: locate_one_side(template, side, options, stages),
        score=lambda result: result.score,
        # a surface that bulges outward clearly is as it should be; of others the side of more
        # similar neighborhoods is taken
        sure=lambda side, _: side.side_known and bulge(side.mesh) >= SURE_BULGE,
    )


def locate_one_side(
    template: Template, part: Intake, options: LocateOptions, stages: Stages
) -> LocateResult:
    """Locate a part whose faces look outward; see :func:`locate`."""
    check_sizes(template.intake.mesh, part.mesh)
    described = described_part(part.mesh, template.length)
    with one_blas_thread():  # sums over 10,000 vertices would depend on how many there are
        if options.method == "voting":
            found, chance, featureless = _voted(template, described, options, stages)
        else:
            # loads slowly, and rarely asked for
            from sherd.region.integral_matching import locate_by_integrals  # noqa: PLC0415

            found = locate_by_integrals(template, described, options, stages)
            chance, featureless = None, False
    with stages("numbering"):
        area = min(described.placed.area, template.placed.area)
        return LocateResult(
            full=template.full,
            part=turned_as_repaired(part),
            best=_as_given(template, found.best, area),
            alternatives=tuple(_as_given(template, other, area) for other in found.alternatives),
            phase_field=_phase_field(template, found),
            energy=found.energy,
            convergence=found.convergence,
            options=replace(
                options,
                regularity=found.weights.regularity,
                smoothness=found.weights.smoothness,
                boundary=found.weights.boundary,
                phase_width=found.weights.phase_width,
            ),
            timings=MappingProxyType(dict(stages.seconds)),
            working_vertices=_working_vertices(template, described),
            notices=MappingProxyType({"full": template.intake.notices, "part": part.notices}),
            chance=chance,
            featureless=featureless,
        )


def _voted(
    full: Template, part: DescribedSurface, options: LocateOptions, stages: Stages
) -> tuple[Found, float, bool]:
    """Where the part lies, the chance that it belongs there, and whether it has no features."""
    eigenvectors = begun(partial(full.basis, options.basis_size))  # asked for after the others
    with stages("descriptors"):
        _ = full.spread
    with stages("samples"):
        _ = part.sparse
    judged = begun(partial(_belonging, full, part, options.seed))
    try:
        found = locate_by_voting(full, part, options, stages)
    finally:  # nothing is left to other threads
        eigenvectors()
        with stages("belonging"):
            chance, featureless = judged()
    return found, chance, featureless


def _belonging(full: Template, part: DescribedSurface, seed: int) -> tuple[float, bool]:
    """The chance that the part belongs on the full shape, and whether it has no features."""
    ratio = first_energy_ratio(full, part, np.random.default_rng(seed))
    share = part.placed.area / full.placed.area
    return belonging_chance(ratio, share), self_likeness(part) > FEATURELESS


def _working_vertices(full: DescribedSurface, part: DescribedSurface) -> MappingProxyType[str, int]:
    counts = {"full": full.mesh.vertex_count, "part": part.mesh.vertex_count}
    return MappingProxyType(counts)


def _as_given(template: Template, place: Placement, area: float) -> Placement:
    """A placement on the working mesh as one on the vertices that the user gave."""
    membership, mask = _at_own_vertices(template, place.membership, place.mask, area)
    lift = template.intake.report.to_original
    return replace(
        place,
        mask=np.asarray(lift(mask, fill=False), dtype=np.bool_),
        membership=np.asarray(lift(membership, fill=0.0), dtype=np.float64),
    )


def _at_own_vertices(
    template: Template, membership: Floats, mask: Bools, area: float
) -> tuple[Floats, Bools]:
    """Membership and mask on the vertices of the placed shape, both of the part's area."""
    working = template.working
    if working.own_vertices is None:
        return membership, mask
    inside = working.at_own_vertices(mask.astype(np.float64))
    areas = template.placed.vertex_areas
    # interpolation changes the integral by the curvature of the mesh; a power puts it right
    soft = np.clip(working.at_own_vertices(membership), 0.0, 1.0)
    lifted = raised_to_area(soft, areas, area)
    return lifted, threshold_to_area(inside + 1e-3 * lifted, areas, area)


def _phase_field(template: Template, found: Found) -> Floats:
    field = np.clip(template.working.at_own_vertices(found.phase_field), 0.0, 1.0)
    lifted = template.intake.report.to_original(field, fill=1.0)
    return frozen(np.asarray(lifted, dtype=np.float64))
