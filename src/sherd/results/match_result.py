"""MatchResult: which point is which, with the proof, and what people do with it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy import sparse

from sherd._version import __version__
from sherd.arrays import Bools, Floats, FrozenState, Ints
from sherd.drawing.colors import correspondence_layer
from sherd.drawing.exhibit import Exhibit, Partner
from sherd.errors import InvalidMeshError
from sherd.limits import require_finite
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.advice import UnfollowedLandmark
from sherd.results.display import picture_html, table_html
from sherd.results.distortion import Distortion, distortion
from sherd.results.match_options import MatchOptions
from sherd.results.placement import Placement
from sherd.results.status import Status
from sherd.results.transfer import TransferMethods, nearest_part_points
from sherd.scan.numbering import outward_normals
from sherd.threads import cached_property

if TYPE_CHECKING:
    import trimesh

__all__ = ["MatchCheck", "MatchResult"]

# The region is what the image covers, so its area differs from the part's by the stretch of the
# pose: some percent over half an animal, up to a tenth where a small part lies over a joint.
AREA_LIMIT = 0.15
# Half of the edges of a right answer are within a twentieth of their length; a map that slid or
# folded stretches half of them by more than a fifth.
STRETCH_LIMIT = 0.2
# Right answers turn over single faces in creases, at most a few percent; one limb laid on another
# inside out is a tenth of a body.
PRESERVED_LIMIT = 0.9


@dataclass(frozen=True)
class MatchCheck:
    """What :meth:`MatchResult.check` re-derives from the meshes.

    Attributes
    ----------
    area_ratio
        Area of the region over area of the part at the estimated scale.
    edge_stretch
        Median of `|log(mapped length / length)|` over the part's edges; nan if none is matched.
    preserved
        Share of the part's area whose mapped faces keep their orientation.
    passed
        Whether the area agrees within 15 %, stretch is below 0.2 and 9 faces of 10 are preserved.

    Examples
    --------
    >>> MatchCheck(area_ratio=1.02, edge_stretch=0.03, preserved=0.99, passed=True).passed
    True
    """

    area_ratio: float
    edge_stretch: float
    preserved: float
    passed: bool

    @property
    def failures(self) -> str:
        """What did not pass, in words; empty if all did."""
        said = []
        if not abs(self.area_ratio - 1) < AREA_LIMIT:
            said.append(f"the region has {self.area_ratio:.2f} times the area of the part")
        if math.isnan(self.edge_stretch):
            said.append("no edge of the part has a place")
        elif not self.edge_stretch < STRETCH_LIMIT:
            said.append(f"half of the edges are stretched by more than {self.edge_stretch:.2f}")
        if not self.preserved > PRESERVED_LIMIT:
            said.append(f"only {self.preserved:.0%} of the part keep their orientation")
        return ", ".join(said)


@dataclass(frozen=True, eq=False, repr=False)
class MatchResult(FrozenState, TransferMethods):
    """The answer of :func:`sherd.match`; all arrays are numbered as the user's shapes are.

    Attributes
    ----------
    full, part
        The shapes of the question. The faces of the part look outward as far as is known, even
        where the given ones did not.
    best
        The answer: a point of `full` for every vertex of `part`, which of them are matched, the
        confidence of each, and the region.
    alternatives
        Other plausible placements, best first.
    scale
        What lengths of the part were multiplied by: 1 for ``scale="same"`` without units.
    second_score, twin_score
        Score of the placement that was found the other time, and of the mirrored twin, which need
        not be plausible; None if unknown.
    status
        Whether the answer as a whole can be trusted, with advice.
    timings
        Seconds by stage.
    options, version
        As given, and of sherd.
    working_vertices
        Number of vertices of the meshes that were searched, by "full" and "part". Large or uneven
        shapes are searched on a mesh of moderate size; the answers are for the shapes themselves.
    notices
        What was adapted in the shapes, in sentences, by "full" and "part".
    advice
        What to do about the status, with the names of what is wrong; the status's own if empty.
    unfollowed_landmarks
        Landmarks that the answer does not follow or that contradict each other, farthest first.
    chance
        That the placement as a whole is right, in [0, 1]; None if unknown.
    min_confidence
        Vertices below it were made unmatched afterwards, by :meth:`with_min_confidence`.

    Examples
    --------
    >>> from sherd.match import match
    >>> from sherd.shapes import creature, cut_by_ball, whole
    >>> full = creature(5000)
    >>> result = match(full, cut_by_ball(whole(creature(5000, pose="walk"), full), 0, 0.5).mesh)
    >>> result.matrix().shape == (result.part.vertex_count, full.vertex_count)
    True
    """

    full: TriangleMesh
    part: TriangleMesh
    best: Placement
    alternatives: tuple[Placement, ...]
    scale: float
    second_score: float | None
    twin_score: float | None
    status: Status
    timings: Mapping[str, float]
    options: MatchOptions
    version: str = field(default=__version__)
    working_vertices: Mapping[str, int] = field(default_factory=dict)
    notices: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    advice: str = ""
    unfollowed_landmarks: tuple[UnfollowedLandmark, ...] = ()
    min_confidence: float = 0.0
    chance: float | None = None

    def __post_init__(self) -> None:
        if not self.advice:
            object.__setattr__(self, "advice", self.status.advice)
        for placement in (self.best, *self.alternatives):
            count = -1 if placement.points is None else len(placement.points)
            if count != self.part.vertex_count:
                raise InvalidMeshError(
                    f"a placement has {max(count, 0)} points, but the part has "
                    f"{self.part.vertex_count} vertices"
                )
        if self.best.matched is None or self.best.confidence is None:
            raise InvalidMeshError("the best placement of a match says what is matched, how surely")

    def __repr__(self) -> str:
        return (
            f"MatchResult({self.part.name!r} on {self.full.name!r}: {self.status.name.lower()}, "
            f"{self.matched.mean():.0%} matched, mean confidence {self.confidence.mean():.2f})"
        )

    def _repr_html_(self) -> str:
        covered = self.part.area * self.scale**2 / self.full.area
        rows = {
            "status": self.advice,
            "coverage": f"{covered:.1%} of the full shape",
            "matched": f"{int(self.matched.sum()):,} of {self.part.vertex_count:,} vertices",
            "mean confidence": f"{self.confidence.mean():.2f}",
            "score": f"{self.best.score:.3f}",
            "scale": f"{self.scale:.4g}",
            "alternatives": ", ".join(repr(other) for other in self.alternatives) or "none",
            "to see it": "sherd.show(result), sherd.plot(result)",
        }
        title = f"{self.part.name} on {self.full.name}"
        scene = Exhibit(
            title,
            self.full,
            self.part,
            full_layers=(correspondence_layer(self.full),),
            partner=Partner(self.points, self.matched),
            region=self.best.mask,
        )
        return table_html(title, rows) + picture_html(scene)

    @property
    def points(self) -> SurfacePoints:
        """The point of the full shape for every vertex of the part."""
        return _points(self.best)

    @property
    def matched(self) -> Bools:
        """(n_part,) bool, False where the full shape seems to have no such point."""
        return np.asarray(self.best.matched)

    @property
    def confidence(self) -> Floats:
        """(n_part,) chance that each point is within 0.05 sqrt(area of full) of the truth."""
        return np.asarray(self.best.confidence)

    @property
    def outward(self) -> Floats:
        """(n_full, 3) outward normals of the full shape, even where its own faces look inward."""
        return outward_normals(self.full)

    @property
    def positions(self) -> Floats:
        """(n_part, 3) where the part's vertices lie on the full shape, in its coordinates."""
        return self.points.positions(self.full)

    @property
    def nearest_vertices(self) -> Ints:
        """(n_part,) the vertex of the full shape nearest to each answer."""
        return self.points.nearest_vertices(self.full)

    def with_min_confidence(self, least: float) -> MatchResult:
        """The same, but vertices with a confidence below `least` are unmatched.

        Nothing else changes: their points and confidence stay, and so does the region. Once
        unmatched they stay so.

        Raises
        ------
        OptionError
            If `least` is not within 0 and 1.
        """
        require_finite("min_confidence", least, 0, 1, "it is a chance")
        sure = self.matched & (self.confidence >= least)
        return replace(
            self,
            best=replace(self.best, matched=sure),
            min_confidence=max(self.min_confidence, float(least)),
        )

    def matrix(self) -> sparse.csr_array:
        """(n_part, n_full) weights that carry values of the full shape to the part.

        Rows of unmatched vertices are empty, all others sum to 1.
        """
        matched = np.flatnonzero(self.matched)
        return _weights(self.points, self.full, matched, self.part.vertex_count)

    def inverse_matrix(self) -> sparse.csr_array:
        """(n_full, n_part) weights that carry values of the part to the full shape.

        Rows of vertices that the part does not reach are empty, all others sum to 1.
        """
        points, found = nearest_part_points(self)
        return _weights(points, self.part, np.flatnonzero(found), self.full.vertex_count)

    def to_trimesh(self) -> tuple[trimesh.Trimesh, trimesh.Trimesh]:
        """Both shapes, full and part, as trimesh objects with the same numbering."""
        import trimesh as library  # loads slowly  # noqa: PLC0415

        full, part = (
            library.Trimesh(mesh.vertices.copy(), mesh.faces.copy(), process=False)
            for mesh in (self.full, self.part)
        )
        return full, part

    @cached_property
    def distortion(self) -> Distortion:
        """Stretch of the part's edges and orientation of its faces under the map."""
        return self.distortion_by(self.points)

    def distortion_by(self, points: SurfacePoints) -> Distortion:
        """The same under another map, of which `points` (n_part,) are the places."""
        return distortion(self.part, self.full, points, outward=self.outward, scale=self.scale)

    def check(self) -> MatchCheck:
        """Re-derive area, distortion and orientation from the meshes; see :class:`MatchCheck`."""
        full, part, bent = self.full, self.part, self.distortion
        stretch = np.abs(bent.stretch[self.matched[part.edges].all(axis=1)])
        median = float(np.median(stretch)) if len(stretch) else float("nan")
        preserved = float(part.face_areas[bent.preserved].sum() / part.area)
        area = float(full.vertex_areas[self.best.mask].sum())
        area_ratio = area / (part.area * self.scale**2)
        passed = (
            abs(area_ratio - 1) < AREA_LIMIT
            and median < STRETCH_LIMIT
            and preserved > PRESERVED_LIMIT
        )
        return MatchCheck(area_ratio, median, preserved, passed)


def _points(placement: Placement) -> SurfacePoints:
    if placement.points is None:
        raise InvalidMeshError("this placement is a region only")
    return placement.points


def _weights(
    points: SurfacePoints, mesh: TriangleMesh, rows: Ints, row_count: int
) -> sparse.csr_array:
    columns = mesh.faces[points.faces[rows]]
    entries = (points.barycentric[rows].ravel(), (np.repeat(rows, 3), columns.ravel()))
    return sparse.coo_array(entries, shape=(row_count, mesh.vertex_count)).tocsr()
