"""What a fit is worth: distances, strain, chances, hidden regions, in the user's numbering."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.fitting.as_rigid_as_possible import Elasticity
from sherd.fitting.chance import chances, distances_beyond
from sherd.fitting.completion import completed
from sherd.fitting.deformation import Deformation, area_kept
from sherd.fitting.mending.self_intersection import intersecting_faces
from sherd.fitting.mending.turned_faces import turned_faces
from sherd.fitting.scan_surface import REACH, ScanSurface
from sherd.fitting.sizes import mean_growth
from sherd.fitting.targets import Targets, matched_surface
from sherd.mesh.surface_finder import SurfaceFinder
from sherd.mesh.topology import component_labels
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import Stages
from sherd.results.fitted.fit_options import FitOptions
from sherd.results.fitted.fit_result import Fit, FitCheck, FittedPiece, HiddenRegion
from sherd.results.match_result import MatchResult
from sherd.results.status import Status
from sherd.scan.intake import Intake
from sherd.scan.numbering import nearest_repaired, original_points

__all__ = ["Solved", "fit_of"]

# A fit that promises more is refused: issue and aim of the checks, see FitCheck.
LEAST_AREA, MOST_AREA = 0.95, 1.05
MOST_INTERSECTIONS = 0.001
# A hidden region below this share of the area is a hole in a scan, no limb.
LEAST_REGION = 0.002
# Mean strain of what was seen: right fits of poses have 0.02 to 0.1, of other people up to 0.2.
STRAINED = 0.25
# Of the matched area of a piece; a right map leaves a few percent that elasticity does not follow.
MOST_LOST = 0.2


@dataclass(frozen=True, eq=False)
class Solved:
    """A solved fit, before anything is said of it.

    Attributes
    ----------
    matches
        What was fitted to.
    intake
        The full shape.
    shape
        The same, repaired and at unit area.
    targets
        For the vertices of `shape`.
    deformation
        Of `shape`.
    """

    matches: tuple[MatchResult, ...]
    intake: Intake
    shape: TriangleMesh
    targets: Targets
    deformation: Deformation


def fit_of(solved: Solved, options: FitOptions, stages: Stages) -> Fit:
    """The answer in the numbering and the unit of the user."""
    matches, deformation = solved.matches, solved.deformation
    full = matches[0].full
    unit = full.length / matches[0].scale
    elasticity = Elasticity(solved.shape)
    with stages("distances"):
        scan = ScanSurface(matched_surface(matches))
        feet, found = scan.feet(deformation.positions, solved.shape.faces)
        seen = found & solved.targets.seen
        off = np.linalg.norm(feet - deformation.positions, axis=1)
        beyond = distances_beyond(solved.shape, seen)
        confidence = solved.targets.confidence
        chance = chances(
            beyond,
            confidence,
            near=options.near,
            placed=_placed(matches),
            grown=mean_growth(elasticity, deformation.positions, confidence * seen),
        )
        strain = elasticity.strains(deformation.positions, deformation.turns)
        fitted = TriangleMesh(deformation.positions, solved.shape.faces, name=full.name)
        pieces = tuple(_piece(match, fitted, solved.intake) for match in matches)
    with stages("intersections"):
        check = _check(elasticity, deformation, seen)
    hidden = _hidden(solved.shape, deformation, seen, beyond)
    back = nearest_repaired(solved.intake)
    completion = None
    if options.merge:
        with stages("completion"):
            placed = fitted.with_vertices(unit * fitted.vertices)
            completion = completed(placed, seen, pieces, reach=REACH * unit)
    status, advice = _advice(matches, check, _lost(pieces, unit), _mean_strain(strain, seen))
    return Fit(
        full=full,
        pieces=pieces,
        positions=_positions(solved, back) * unit,
        seen=seen[back],
        chance=chance[back],
        distances=np.where(seen, off, np.nan)[back] * unit,
        strain=strain[back],
        sizes=deformation.sizes[back],
        check=check,
        hidden=tuple(
            HiddenRegion(
                each.area,
                each.kept,
                int(solved.intake.report.original_vertices[each.vertex]),
                each.vertex_count,
            )
            for each in hidden
        ),
        status=status,
        advice=advice,
        timings=stages.seconds,
        options=options,
        notices=solved.intake.notices,
        completion=completion,
    )


def _placed(matches: tuple[MatchResult, ...]) -> float:
    """The chance that all pieces belong where they are; what has no chance is believed."""
    known = [match.chance for match in matches if match.chance is not None]
    return min(known, default=1.0)


def _positions(solved: Solved, back: Ints) -> Floats:
    """Of all vertices of the user: those that repair left out move with the nearest one."""
    deformation = solved.deformation
    arms = solved.intake.original.vertices / solved.matches[0].full.length
    arms = arms - solved.shape.vertices[back]
    moved = np.einsum("nij,nj->ni", deformation.turns[back], arms)
    positions: Floats = deformation.positions[back] + moved
    return positions


def _piece(match: MatchResult, fitted: TriangleMesh, intake: Intake) -> FittedPiece:
    """How far each vertex of a piece lies from the fit, and where on it."""
    unit = match.full.length / match.scale
    part = match.part
    places = part.vertices / unit
    points = SurfaceFinder(fitted).closest(places, part.vertex_normals)
    off = np.linalg.norm(points.positions(fitted) - places, axis=1)
    original = original_points(intake, points)
    return FittedPiece(part, original, match.matched, off * unit, match.scale)


def _check(elasticity: Elasticity, deformation: Deformation, seen: Bools) -> FitCheck:
    faces, rest = elasticity.mesh.faces, elasticity.rest
    rotations = elasticity.fitted_rotations(deformation.positions)
    turned = int(turned_faces(rest, deformation.positions, rotations, faces).sum())
    hidden: Bools = np.all(~seen[faces], axis=1)
    kept = area_kept(elasticity.mesh, deformation, hidden)
    before = intersecting_faces(rest, faces)
    after = intersecting_faces(deformation.positions, faces)
    fresh = int((after & ~before).sum())
    passed = (
        turned == 0 and LEAST_AREA <= kept <= MOST_AREA and fresh <= MOST_INTERSECTIONS * len(faces)
    )
    return FitCheck(turned, kept, fresh, int(before.sum()), passed)


def _hidden(
    shape: TriangleMesh, deformation: Deformation, seen: Bools, beyond: Floats
) -> tuple[HiddenRegion, ...]:
    hidden = ~seen
    inside = hidden[shape.faces].all(axis=1)
    if not inside.any():
        return ()
    labels = component_labels(shape.faces[inside], shape.vertex_count)
    regions = []
    for label in np.unique(labels[shape.faces[inside][:, 0]]):
        vertices = np.flatnonzero(hidden & (labels == label))
        area = float(shape.vertex_areas[vertices].sum() / shape.area)
        if area < LEAST_REGION:
            continue
        deepest = vertices[np.where(np.isfinite(beyond[vertices]), beyond[vertices], 0.0).argmax()]
        kept = area_kept(
            shape, deformation, np.logical_and(inside, labels[shape.faces[:, 0]] == label)
        )
        regions.append(HiddenRegion(area, kept, int(deepest), len(vertices)))
    return tuple(sorted(regions, key=lambda region: -region.area))


def _lost(pieces: Sequence[FittedPiece], unit: float) -> tuple[str, ...]:
    """Names of the pieces of which much that is matched does not lie on the fit."""
    lost = []
    for piece in pieces:
        areas = piece.part.vertex_areas * piece.matched
        far = areas @ (piece.distances > REACH * unit)
        if far > MOST_LOST * areas.sum():
            lost.append(piece.part.name)
    return tuple(lost)


def _mean_strain(strain: Floats, seen: Bools) -> float:
    return float(strain[seen].mean()) if seen.any() else np.inf


def _advice(
    matches: tuple[MatchResult, ...], check: FitCheck, lost: tuple[str, ...], strain: float
) -> tuple[Status, str]:
    """Whether to trust the fit; a fit is no better than its map."""
    doubted = [match for match in matches if match.status is not Status.GOOD]
    if doubted:
        worst = next((m for m in doubted if m.status is Status.FOREIGN), doubted[0])
        return worst.status, f"{worst.part.name}: {worst.advice}"
    if lost:
        return Status.DOUBTFUL, (
            f"doubtful: much of {', '.join(lost)} does not lie on the fit; do all pieces lie in "
            "one coordinate system and pose, in one unit?"
        )
    if strain > STRAINED:
        return Status.DOUBTFUL, (
            f"doubtful: what was seen is strained by {strain:.0%} on average; do all pieces lie in "
            "one coordinate system, and is this the right full shape?"
        )
    if not check.passed:
        said = []
        if check.turned_faces:
            said.append(f"{check.turned_faces} faces are turned over")
        if not LEAST_AREA <= check.hidden_area_kept <= MOST_AREA:
            said.append(f"what was not seen has {check.hidden_area_kept:.2f} times its area")
        if check.new_intersections:
            said.append(f"{check.new_intersections} faces pierce others that did not before")
        return Status.DOUBTFUL, f"doubtful: {', '.join(said)}; look at the report"
    return Status.GOOD, "good: the full shape lies on what was seen and kept its shape beyond"
