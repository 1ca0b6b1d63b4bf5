"""match(full, part): where the part belongs, and which point is which."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sherd._version import __version__
from sherd.arrays import Bools, Floats, Ints, frozen
from sherd.correspondence.confidence import (
    LEAST,
    confidence_features,
    confidences,
    foreign_vertices,
    laid_double,
    matched_vertices,
)
from sherd.correspondence.correspond import Twin, anchored, looked_again, mirrored_twin
from sherd.correspondence.hypothesis import Hypothesis, part_queries, settled
from sherd.correspondence.labeling import EVEN_SETTINGS, SETTINGS
from sherd.correspondence.part_data import part_data
from sherd.correspondence.point_map import PointMap
from sherd.correspondence.scale import LARGEST, LARGEST_AREA, estimated_scale
from sherd.errors import InfeasibleError, OptionError
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import Stages
from sherd.region.coverage import covered_region
from sherd.template import Template, refuse_tiny_part

__all__ = [
    "Alternative",
    "MatchCheck",
    "MatchOptions",
    "MatchRegion",
    "MatchResult",
    "MatchStatus",
    "match",
]


# A twin whose score is this close to the best could be the right one without its handedness.
PLAUSIBLE = 0.1
# When answers are promised to be near for fewer than half of the vertices, another shape would do.
POOR = 0.5
# No place can be used twice; up to this share of the part it may be noise.
DOUBLE = 0.2


class MatchStatus(Enum):
    """How far the answer can be trusted as a whole; the value of each member is the advice."""

    GOOD = "good: neighborhoods agree and the part keeps its shape"
    DOUBTFUL = (
        "doubtful: the part fits the full shape hardly better than another shape would; look at "
        "the alternatives, check the scale, or give landmarks"
    )

    @property
    def advice(self) -> str:
        """What to do about it, in a sentence."""
        return self.value


@dataclass(frozen=True)
class MatchOptions:
    """Options of :func:`match`.

    Parameters
    ----------
    scale
        ``"same"``: both shapes have the same unit; ``"unknown"``: the part's scale is estimated
        within [1/2, 2] of the full shape's.
    landmarks
        Pairs (vertex of the part, vertex of the full shape) that belong together.
    ignore
        Vertices of the part to leave out: clothing, support, clutter.
    seed
        Seed of every random choice.

    Raises
    ------
    OptionError
        If a value is outside its range.
    """

    scale: str = "same"
    landmarks: tuple[tuple[int, int], ...] = ()
    ignore: tuple[int, ...] = ()
    seed: int = 0

    def __post_init__(self) -> None:
        if self.scale not in ("same", "unknown"):
            raise OptionError(f'scale is {self.scale!r}, but "same" or "unknown" is needed')
        landmarks = tuple((int(part), int(full)) for part, full in self.landmarks)
        if len({part for part, _ in landmarks}) < len(landmarks):
            raise OptionError("landmarks name a vertex of the part twice")
        ignore = tuple(sorted({int(vertex) for vertex in self.ignore}))
        if min([vertex for pair in landmarks for vertex in pair] + list(ignore), default=0) < 0:
            raise OptionError("landmarks and ignore count vertices from 0")
        clash = {part for part, _ in landmarks} & set(ignore)
        if clash:
            raise OptionError(f"vertex {min(clash)} of the part is a landmark and ignored")
        if self.seed < 0:
            raise OptionError(f"seed is {self.seed}, but it must not be negative")
        object.__setattr__(self, "landmarks", landmarks)
        object.__setattr__(self, "ignore", ignore)


@dataclass(frozen=True, eq=False)
class MatchRegion:
    """Where the part lies on the full shape: `mask` (n,) bool and `membership` (n,) in [0, 1]."""

    mask: Bools
    membership: Floats


@dataclass(frozen=True, eq=False)
class Alternative:
    """Another placement of the part: its answers, its region and its score."""

    name: str
    points: SurfacePoints
    mask: Bools
    score: float
    mirrored: bool


@dataclass(frozen=True)
class MatchCheck:
    """What :meth:`MatchResult.check` re-derives from the meshes.

    Attributes
    ----------
    area_ratio
        Area of the region over area of the part at the estimated scale.
    edge_stretch
        Median of `|log(mapped length / length)|` over the part's edges.
    preserved
        Share of the part's area whose mapped faces keep their orientation.
    passed
        Whether the area agrees within 15 %, stretch is below 0.2 and 9 faces of 10 are preserved.
    """

    area_ratio: float
    edge_stretch: float
    preserved: float
    passed: bool


@dataclass(frozen=True, eq=False)
class MatchResult:
    """The answer of :func:`match`.

    Attributes
    ----------
    full, part
        The meshes of the question; all arrays are numbered as theirs.
    point_map
        A point of `full` for every vertex of `part`.
    region
        Where the part lies.
    alternatives
        Other plausible placements, best first.
    scale
        Factor that the part was enlarged by: 1 for ``scale="same"``.
    scores
        Score by placement: ``"best"``, ``"other"``, ``"mirrored twin"``. Mean similarity of the
        neighborhoods minus mean strain, at most 1.
    status
        Whether the answer as a whole can be trusted, with advice.
    timings
        Seconds by stage.
    options, version
        As given, and of sherd.
    working_vertices
        Number of vertices of the meshes that were searched, by "full" and "part". Large or uneven
        shapes are searched on a mesh of moderate size; the answers are for the shapes themselves.
    """

    full: TriangleMesh
    part: TriangleMesh
    point_map: PointMap
    region: MatchRegion
    alternatives: tuple[Alternative, ...]
    scale: float
    scores: Mapping[str, float]
    status: MatchStatus
    timings: Mapping[str, float]
    options: MatchOptions
    version: str = field(default=__version__)
    working_vertices: Mapping[str, int] = field(default_factory=dict)

    def check(self) -> MatchCheck:
        """Re-derive area, distortion and orientation from the meshes; see :class:`MatchCheck`."""
        full, part = self.full, self.part
        points = self.point_map.points
        image = points.positions(full)
        ends = part.edges[self.point_map.matched[part.edges].all(axis=1)]
        length = np.linalg.norm(part.vertices[ends[:, 0]] - part.vertices[ends[:, 1]], axis=1)
        mapped = np.linalg.norm(image[ends[:, 0]] - image[ends[:, 1]], axis=1)
        ratio = np.maximum(mapped, 1e-12 * full.length) / np.maximum(length * self.scale, 1e-300)
        stretch = float(np.median(np.abs(np.log(ratio)))) if len(ends) else float("nan")
        corners = image[part.faces]
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        up = points.interpolate(full, full.vertex_normals)[part.faces].sum(axis=1)
        kept = (cross * up).sum(axis=1) > 0
        preserved = float(part.face_areas[kept].sum() / part.area)
        area = float(full.vertex_areas[self.region.mask].sum())
        area_ratio = area / (part.area * self.scale**2)
        passed = abs(area_ratio - 1) < 0.15 and stretch < 0.2 and preserved > 0.9
        return MatchCheck(area_ratio, stretch, preserved, passed)


def match(
    full: TriangleMesh | Template,
    part: TriangleMesh,
    options: MatchOptions | None = None,
    *,
    stages: Stages | None = None,
) -> MatchResult:
    """Find for every vertex of the part its point on the full shape.

    Parameters
    ----------
    full
        The full shape, or its :class:`sherd.template.Template` when many parts are to be matched.
    part
        The part: deformed, incomplete, in any position and vertex order.
    options
        See :class:`MatchOptions`.
    stages
        Collects timings and shows progress; a silent one if None.

    Raises
    ------
    OptionError
        If a landmark or ignored vertex does not exist.
    InfeasibleError
        If the part is larger than the full shape or a dot on it, or everything is ignored.

    Examples
    --------
    >>> from sherd.shapes.creature import creature
    >>> from sherd.shapes.fragment import cut_by_ball, whole
    >>> full = creature(5000)
    >>> part = cut_by_ball(whole(creature(5000, pose="walk"), full), 0, 0.5).mesh
    >>> match(full, part).check().passed
    True
    """
    options = options or MatchOptions()
    template = full if isinstance(full, Template) else Template(full)
    rng = np.random.default_rng(options.seed)
    kept, kept_vertices = _without_ignored(template, part, options)
    stages = stages or Stages(visible=False)
    with stages("full shape"):
        template.prepare()
    pins = _pins(template, kept_vertices, options)
    with stages("part"):
        data = part_data(kept, template.length, pins=pins)
    with stages("scale"):
        scale = estimated_scale(template, data, rng) if options.scale == "unknown" else 1.0
        if scale != 1.0:
            data = part_data(kept, template.length / scale, pins=pins)
        queries = part_queries(data, rng)
    with stages("anchors"):
        settings = EVEN_SETTINGS if options.scale == "unknown" else SETTINGS
        labeling = anchored(template, data, rng, settings=settings)
    with stages("first placement"):
        first = settled(template, data, labeling, queries)
    with stages("second placement"):
        second = looked_again(template, data, first, queries, rng, settings=settings)
        best, other = sorted((first, second), key=lambda found: -found.score)
    with stages("mirrored twin"):
        twin = mirrored_twin(template, data, queries, rng, settings=settings)
    with stages("confidence"):
        features = confidence_features(data, queries, best, other)
        foreign = foreign_vertices(data, queries, best)
        matched = matched_vertices(features) & ~foreign
        confidence = np.where(foreign, LEAST, confidences(features))
        point_map = _for_all(part, kept_vertices, best.points, matched, confidence)
    with stages("region"):
        # its area is that in the pose of the full shape; the part may be some percent smaller
        share = float(data.placed.vertex_areas @ matched) / data.placed.area
        area = share * float(template.placed.vertex_areas @ best.mask)
        membership, mask = covered_region(template.placed, best.mask, area)
    return MatchResult(
        full=template.full,
        part=part,
        point_map=point_map,
        region=MatchRegion(_read_only(mask), _read_only(membership)),
        alternatives=_alternatives(part, kept_vertices, best, twin),
        scale=scale,
        scores=MappingProxyType(
            {"best": best.score, "other": other.score, "mirrored twin": twin.hypothesis.score}
        ),
        status=_status(point_map, laid_double(data, best.placement)),
        timings=MappingProxyType(dict(stages.seconds)),
        options=options,
        working_vertices=MappingProxyType(
            {"full": template.unit.vertex_count, "part": data.mesh.vertex_count}
        ),
    )


def _status(point_map: PointMap, double: float) -> MatchStatus:
    sure = float(point_map.confidence[point_map.matched].mean()) if point_map.matched.any() else 0.0
    return MatchStatus.GOOD if sure > POOR and double < DOUBLE else MatchStatus.DOUBTFUL


def _without_ignored(
    template: Template, part: TriangleMesh, options: MatchOptions
) -> tuple[TriangleMesh, Ints]:
    """The part without faces at ignored vertices, and the old index of each vertex."""
    _check_hints(template.full, part, options)
    largest = LARGEST_AREA * (LARGEST**2 if options.scale == "unknown" else 1.0)
    if part.area > largest * template.full.area:
        raise InfeasibleError(
            f"{part.name} has area {part.area:.4g}, but {template.full.name} only "
            f'{template.full.area:.4g}; swap them, or use scale="unknown" if the units differ'
        )
    refuse_tiny_part(part, template.full)
    dropped = np.zeros(part.vertex_count, dtype=bool)
    dropped[list(options.ignore)] = True
    keep = ~dropped[part.faces].any(axis=1)
    if not keep.any():
        raise InfeasibleError("every face of the part touches an ignored vertex")
    return part.submesh(keep)


def _check_hints(full: TriangleMesh, part: TriangleMesh, options: MatchOptions) -> None:
    wanted = [
        ("landmarks", "part", part.vertex_count, [pair[0] for pair in options.landmarks]),
        ("landmarks", "full shape", full.vertex_count, [pair[1] for pair in options.landmarks]),
        ("ignore", "part", part.vertex_count, list(options.ignore)),
    ]
    for name, shape, count, vertices in wanted:
        if vertices and max(vertices) >= count:
            raise OptionError(
                f"{name} names vertex {max(vertices)} of the {shape}, which has 0..{count - 1}"
            )


def _pins(template: Template, kept: Ints, options: MatchOptions) -> tuple[Ints, Floats]:
    """Landmarks in the numbering of the kept part, and their places in the template's frame."""
    new = {int(old): index for index, old in enumerate(kept)}
    pairs = [(new[part], full) for part, full in options.landmarks if part in new]
    table = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    return table[:, 0], template.unit.vertices[table[:, 1]]


def _for_all(
    part: TriangleMesh, kept: Ints, points: SurfacePoints, matched: Bools, confidence: Floats
) -> PointMap:
    """Answers for every vertex of the part; those left out take the nearest one, unmatched."""
    source, known = _sources(part, kept)
    return PointMap(
        points.faces[source],
        points.barycentric[source],
        matched[source] & known,
        np.where(known, confidence[source], 0.0),
    )


def _sources(part: TriangleMesh, kept: Ints) -> tuple[Ints, Bools]:
    """For each vertex the kept vertex that answers for it, and whether it is itself."""
    known = np.zeros(part.vertex_count, dtype=bool)
    known[kept] = True
    source = np.empty(part.vertex_count, dtype=np.int64)
    source[kept] = np.arange(len(kept))
    if not known.all():
        source[~known] = cKDTree(part.vertices[kept]).query(part.vertices[~known])[1]
    return source, known


def _alternatives(
    part: TriangleMesh, kept: Ints, best: Hypothesis, twin: Twin
) -> tuple[Alternative, ...]:
    """The mirrored twin, if its score is near the best."""
    found = twin.hypothesis
    if found.score < best.score - PLAUSIBLE:
        return ()
    points = found.points[_sources(part, kept)[0]]
    mask: Bools = _read_only(found.mask)
    return (Alternative("mirrored twin", points, mask, found.score, mirrored=True),)


def _read_only(array: NDArray) -> NDArray:  # type: ignore[type-arg]
    result: NDArray = frozen(array)  # type: ignore[type-arg]
    return result
