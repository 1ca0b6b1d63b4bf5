"""Exhibit: two shapes with colored layers, a map between them and words, ready to be shown.

The report knows nothing of how a result was made: whoever has one fills an Exhibit.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sherd.arrays import Bools, Floats, Ints, frozen
from sherd.errors import InvalidMeshError, OptionError
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["Alternative", "Exhibit", "Layer", "LayerKind", "Partner", "SharedCurve", "Verdict"]

LayerKind = Literal["scalar", "mask", "color", "category"]
COLOR_MAPS = ("ember", "lagoon", "dusk", "balance")


@dataclass(frozen=True, eq=False)
class Layer:
    """One way to color a shape: values per vertex and how to read them.

    Parameters
    ----------
    name
        Shown on buttons and color bars. A layer of the full shape and one of the part with the
        same name are shown together.
    values
        (n,) float for "scalar" (NaN is unknown), (n,) bool for "mask", (n,) int >= 0 for
        "category" (negative is none), (n, 3) RGB in 0..255 for "color".
    kind
        How `values` are read.
    range
        Values at the ends of the color bar; the finite extremes when None.
    unit
        Written behind numbers, for example "l"; empty for pure numbers.
    color_map
        "ember" (light to dark orange), "lagoon" (dark blue over teal to yellow), "dusk" (dark
        violet to light) or "balance" (blue, white, orange).
    description
        One sentence for someone who never saw this quantity.
    labels
        Names of the categories by number.
    carried
        True for a layer of the full shape that the part shows as well, through its partner. If
        it consists of colors, points of the full shape outside the region are gray.
    palette
        Colors of the categories by number, 0..255; those that all pages share if empty. A page has
        one palette, so all layers that name one must name the same.

    Raises
    ------
    OptionError
        If the kind or the color map is unknown, or the range is empty.
    InvalidMeshError
        If the values have the wrong shape.
    """

    name: str
    values: NDArray[Any]
    kind: LayerKind = "scalar"
    range: tuple[float, float] | None = None
    unit: str = ""
    color_map: str = "lagoon"
    description: str = ""
    labels: tuple[str, ...] = ()
    carried: bool = False
    palette: tuple[tuple[int, int, int], ...] = ()

    def __post_init__(self) -> None:
        if self.kind not in get_args(LayerKind):
            raise OptionError(
                f"layer kind is {self.kind!r}, but must be one of {get_args(LayerKind)}"
            )
        if self.color_map not in COLOR_MAPS:
            raise OptionError(f"color_map is {self.color_map!r}, but must be one of {COLOR_MAPS}")
        types = {"scalar": np.float64, "mask": np.bool_, "color": np.uint8, "category": np.int64}
        values: NDArray[Any] = np.array(self.values).astype(types[self.kind])
        wanted = 2 if self.kind == "color" else 1
        if values.ndim != wanted or (wanted == 2 and values.shape[1] != 3):
            raise InvalidMeshError(
                f"layer {self.name!r} has shape {values.shape}, but kind {self.kind!r} needs "
                f"{'(n, 3)' if wanted == 2 else '(n,)'}"
            )
        object.__setattr__(self, "values", frozen(values))
        object.__setattr__(self, "labels", tuple(self.labels))
        if self.range is not None and not self.range[0] < self.range[1]:
            raise OptionError(f"range of layer {self.name!r} is {self.range}, but must ascend")

    @property
    def limits(self) -> tuple[float, float]:
        """Values at the ends of the color bar, never equal."""
        if self.range is not None:
            return (float(self.range[0]), float(self.range[1]))
        if self.kind != "scalar":
            return (0.0, 1.0)
        finite = self.values[np.isfinite(self.values)]
        if not len(finite):
            return (0.0, 1.0)
        low, high = float(finite.min()), float(finite.max())
        return (low, high) if low < high else (low, low + 1.0)


@dataclass(frozen=True, eq=False)
class Partner:
    """Where each part vertex lies on the full shape.

    Parameters
    ----------
    points
        One point of the full shape per part vertex, (p,).
    matched
        (p,) bool; False: the full shape has no such point, and the entry in `points` means
        nothing. All True when None.
    confidence
        (p,) float in [0, 1]; NaN (unknown) when None.

    Raises
    ------
    InvalidMeshError
        If the lengths differ.
    """

    points: SurfacePoints
    matched: Bools | None = None
    confidence: Floats | None = None

    def __post_init__(self) -> None:
        count = len(self.points)
        matched = np.ones(count) if self.matched is None else np.asarray(self.matched)
        confidence = (
            np.full(count, np.nan) if self.confidence is None else np.asarray(self.confidence)
        )
        for name, values in (("matched", matched), ("confidence", confidence)):
            if values.shape != (count,):
                raise InvalidMeshError(f"{name} has shape {values.shape}, but ({count},) is needed")
        object.__setattr__(self, "matched", frozen(matched.astype(bool)))
        object.__setattr__(self, "confidence", frozen(confidence.astype(np.float64)))

    @property
    def known(self) -> Bools:
        """`matched` as an array, (p,) bool."""
        return np.asarray(self.matched)

    def carry(self, full: TriangleMesh, values: ArrayLike) -> Floats:
        """Vertex values (n,) or (n, c) of the full shape seen on the part; NaN if unmatched."""
        carried = self.points.interpolate(full, values)
        carried[~self.known] = np.nan
        return carried


@dataclass(frozen=True)
class Verdict:
    """How far the answer as a whole can be trusted: what a reader must know first.

    Parameters
    ----------
    words
        A word or two, for example "Doubtful".
    trusted
        Shown calmly if True, as a warning if False.
    advice
        What that means, and what to do about it.

    Examples
    --------
    >>> Verdict.from_advice("doubtful: check the scale", trusted=False)
    Verdict(words='Doubtful', trusted=False, advice='Check the scale.')
    """

    words: str
    trusted: bool
    advice: str = ""

    @staticmethod
    def from_advice(sentence: str, *, trusted: bool) -> Verdict:
        """What stands before the first colon or semicolon of `sentence`, and the rest of it."""
        mark = ":" if ":" in sentence else ";"
        words, _, advice = sentence.partition(mark)
        advice = advice.strip()
        said = f"{advice[0].upper()}{advice[1:]}." if advice else ""
        return Verdict(words[:1].upper() + words[1:], trusted, said)


@dataclass(frozen=True)
class SharedCurve:
    """Share of the area of two shapes, `full` and `part`, against the accepted strain.

    Parameters
    ----------
    strains
        Ascending.
    first, second
        Shares by strain.
    chosen
        The strain that was accepted.
    """

    strains: tuple[float, ...]
    first: tuple[float, ...]
    second: tuple[float, ...]
    chosen: float


@dataclass(frozen=True, eq=False)
class Alternative:
    """Another place where the part may belong.

    Parameters
    ----------
    name
        For example "twin 1".
    score
        On the same scale as `Exhibit.score`; NaN is unknown.
    description
        One sentence.
    full_layers
        Layers that replace those of the exhibit that have the same name.
    part_layers
        The same for the part: what is true of one map is not true of another.
    partner
        The map of this placement, if there is one.
    region
        (n,) bool, the place; from the first mask layer when None, and None without one.
    """

    name: str
    score: float = float("nan")
    description: str = ""
    full_layers: tuple[Layer, ...] = ()
    partner: Partner | None = None
    part_layers: tuple[Layer, ...] = ()
    region: Bools | None = None

    def __post_init__(self) -> None:
        if self.region is None:
            object.__setattr__(self, "region", _first_mask(self.full_layers))


@dataclass(frozen=True, eq=False)
class Exhibit:
    """All that a page or a picture shows.

    Parameters
    ----------
    title
        One line.
    full, part
        The two shapes, as the user numbers them.
    full_layers, part_layers
        Colorings in the order of their buttons; the first one of `full_layers` is shown first.
    partner
        The map from part to full, if known.
    anchors
        (a, 2) int: part vertex, full vertex.
    score
        How good the placement shown first is; NaN is unknown.
    score_name
        What `score` means and which way is better, in a few words.
    alternatives
        Other placements, best first.
    verdict
        Whether to trust what is shown; stands above everything else.
    summary
        Plain sentences; the first one stands below the title.
    facts
        Numbers and words for tables, one table per key.
    command
        What to type to get the same result again; empty if there is no command.
    landmarks
        (k, 2) int: part vertex, full vertex, as the user gave them; vertices of the files, also
        where the exhibit shows fewer.
    ignored
        (i,) int, part vertices that the user had ignored, of the file as well.
    region
        (n,) bool, the place the camera must see; from the first mask layer when None.
    curve
        How what is shared grows with the accepted strain, if that was asked.
    names
        What `full` and `part` are called.
    up
        Which direction of the full shape's file points up; guessed when None.
    part_stands
        Whether the part is shown as its coordinates are, beside the full shape in its own; if not,
        it is turned toward its place first.
    part_numbers
        (n_part,) what vertices of the part are called; by their number when None.
    full_before
        (n, 3) where the vertices of the full shape were, if the page shall have a slider from there
        to where they are.
    overlaid
        Whether both shapes lie in one coordinate system, so that the part can be drawn over the
        full shape.
    unit_of
        The shape whose sqrt(area) is the unit of errors; the full shape when None.
    takes_hints
        Whether landmarks, and regions to ignore, can be given to the same question: the page then
        has tools for them.

    Raises
    ------
    InvalidMeshError
        If a layer, the map or an anchor does not fit its mesh.
    """

    title: str
    full: TriangleMesh
    part: TriangleMesh
    full_layers: tuple[Layer, ...] = ()
    part_layers: tuple[Layer, ...] = ()
    partner: Partner | None = None
    anchors: Ints | None = None
    score: float = float("nan")
    score_name: str = "score"
    alternatives: tuple[Alternative, ...] = ()
    verdict: Verdict | None = None
    summary: tuple[str, ...] = ()
    facts: Mapping[str, Any] = field(default_factory=dict)
    command: str = ""
    landmarks: tuple[tuple[int, int], ...] = ()
    ignored: tuple[int, ...] = ()
    region: Bools | None = None
    curve: SharedCurve | None = None
    names: tuple[str, str] = ("Full shape", "Part")
    up: tuple[float, float, float] | None = None
    part_stands: bool = False
    part_numbers: Ints | None = None
    takes_hints: bool = False
    full_before: Floats | None = None
    overlaid: bool = False
    unit_of: TriangleMesh | None = None

    def __post_init__(self) -> None:
        anchors = np.empty((0, 2)) if self.anchors is None else np.asarray(self.anchors)
        anchors = anchors.reshape(-1, 2).astype(np.int64)
        object.__setattr__(self, "anchors", frozen(anchors))
        for name in ("full_layers", "part_layers", "alternatives", "summary"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        counts = np.array([self.part.vertex_count, self.full.vertex_count])
        if len(anchors) and ((anchors < 0) | (anchors >= counts)).any():
            raise InvalidMeshError("anchors hold a vertex that is out of range")
        for layers, mesh in self._layers_and_meshes():
            for layer in layers:
                if len(layer.values) != mesh.vertex_count:
                    raise InvalidMeshError(
                        f"layer {layer.name!r} has {len(layer.values)} values, "
                        f"but {mesh.name} has {mesh.vertex_count} vertices"
                    )
        before = self.full_before
        if before is not None and before.shape != self.full.vertices.shape:
            raise InvalidMeshError(
                f"full_before has shape {before.shape}, but {self.full.vertices.shape} is needed"
            )
        for partner in (self.partner, *(placement.partner for placement in self.alternatives)):
            self._check_partner(partner)
        region = self._region()
        if region.shape != (self.full.vertex_count,):
            raise InvalidMeshError(
                f"region has shape {region.shape}, but one entry per vertex is needed"
            )
        object.__setattr__(self, "region", frozen(region))

    def _layers_and_meshes(self) -> list[tuple[tuple[Layer, ...], TriangleMesh]]:
        placed = [
            (tuple(layers), mesh)
            for place in self.alternatives
            for layers, mesh in ((place.full_layers, self.full), (place.part_layers, self.part))
        ]
        return [(self.full_layers, self.full), (self.part_layers, self.part), *placed]

    def _check_partner(self, partner: Partner | None) -> None:
        if partner is None:
            return
        if len(partner.points) != self.part.vertex_count:
            raise InvalidMeshError(
                f"the map has {len(partner.points)} points, but the part has "
                f"{self.part.vertex_count} vertices"
            )
        faces = partner.points.faces
        if len(faces) and not 0 <= faces.min() <= faces.max() < self.full.face_count:
            raise InvalidMeshError(f"the map names a face outside 0..{self.full.face_count - 1}")

    def _region(self) -> Bools:
        if self.region is not None:
            return np.asarray(self.region, dtype=bool)
        mask = _first_mask(self.full_layers)
        return np.ones(self.full.vertex_count, dtype=bool) if mask is None else mask


def _first_mask(layers: tuple[Layer, ...]) -> Bools | None:
    masks = (layer.values for layer in layers if layer.kind == "mask" and layer.values.any())
    return next((np.asarray(values, dtype=bool) for values in masks), None)
