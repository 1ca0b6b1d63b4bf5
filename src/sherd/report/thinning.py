"""A lighter exhibit for the page when a mesh is too large to turn smoothly."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Bools, Ints
from sherd.drawing.exhibit import Exhibit, Layer, Partner
from sherd.errors import OptionError
from sherd.mesh.surface_points import closest_points
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.sampling import decimate

__all__ = ["LARGEST_SHOWN", "Thinned", "thinned"]

# Two shapes of this size still turn at 30 frames a second on an office laptop.
LARGEST_SHOWN = 200_000


@dataclass(frozen=True, eq=False)
class Thinned:
    """What the page shows, and how it counts.

    Parameters
    ----------
    exhibit
        The exhibit itself, or one on decimated meshes.
    full_numbers, part_numbers
        For decimated meshes, the original vertex whose values each shown vertex has; else None.
    full_owners, part_owners
        For decimated meshes, the shown vertex nearest to each original vertex; else None.
    notice
        A sentence for the reader; empty if nothing was changed.
    """

    exhibit: Exhibit
    full_numbers: Ints | None = None
    part_numbers: Ints | None = None
    full_owners: Ints | None = None
    part_owners: Ints | None = None
    notice: str = ""


def thinned(exhibit: Exhibit, *, largest: int = LARGEST_SHOWN) -> Thinned:
    """Decimate shapes above `largest` vertices, with values of the nearest original vertices.

    A shape that cannot be decimated because nearly all of it is border is left as it is.
    """
    full, full_numbers = _light(exhibit.full, largest)
    part, part_numbers = _light(exhibit.part, largest)
    if full_numbers is None and part_numbers is None:
        return Thinned(exhibit)

    def partner_of(partner: Partner | None) -> Partner | None:
        return _moved(partner, exhibit.full, full, full_numbers, part_numbers)

    full_owners = _owners(exhibit.full, full, full_numbers)
    part_owners = _owners(exhibit.part, part, part_numbers)
    anchors = np.array(exhibit.anchors)
    for column, owners in enumerate((part_owners, full_owners)):
        if owners is not None:
            anchors[:, column] = owners[anchors[:, column]]
    light = replace(
        exhibit,
        full=full,
        part=part,
        full_layers=_picked(exhibit.full_layers, full_numbers),
        part_layers=_picked(exhibit.part_layers, part_numbers),
        partner=partner_of(exhibit.partner),
        anchors=anchors,
        alternatives=tuple(
            replace(
                place,
                full_layers=_picked(place.full_layers, full_numbers),
                part_layers=_picked(place.part_layers, part_numbers),
                partner=partner_of(place.partner),
                region=_picked_mask(place.region, full_numbers),
            )
            for place in exhibit.alternatives
        ),
        region=_picked_mask(exhibit.region, full_numbers),
        full_before=exhibit.full_before
        if exhibit.full_before is None or full_numbers is None
        else exhibit.full_before[full_numbers],
    )
    counts = [
        f"{mesh.vertex_count:,} of the {before.vertex_count:,} vertices of {before.name}"
        for mesh, before in ((full, exhibit.full), (part, exhibit.part))
        if mesh is not before
    ]
    notice = (
        f"The 3D view is decimated so that it turns smoothly: it shows {' and '.join(counts)}. "
        "Each shown vertex has the number and the values of the original vertex nearest to it; "
        "the other files hold every vertex."
    )
    return Thinned(light, full_numbers, part_numbers, full_owners, part_owners, notice)


def _light(mesh: TriangleMesh, largest: int) -> tuple[TriangleMesh, Ints | None]:
    if mesh.vertex_count <= largest:
        return mesh, None
    try:
        light, points = decimate(mesh, largest)
    except OptionError:  # nearly all border: nothing can be left out, so it turns slowly but whole
        return mesh, None
    return light, points.nearest_vertices(mesh)


def _picked(layers: tuple[Layer, ...], numbers: Ints | None) -> tuple[Layer, ...]:
    if numbers is None:
        return layers
    return tuple(
        replace(layer, values=layer.values[numbers], range=layer.limits) for layer in layers
    )


def _picked_mask(mask: Bools | None, numbers: Ints | None) -> Bools | None:
    return mask if mask is None or numbers is None else np.asarray(mask)[numbers]


def _owners(before: TriangleMesh, after: TriangleMesh, numbers: Ints | None) -> Ints | None:
    if numbers is None:
        return None
    _, nearest = cKDTree(after.vertices).query(before.vertices)
    return np.asarray(nearest, dtype=np.int64)


def _moved(
    partner: Partner | None,
    before: TriangleMesh,
    full: TriangleMesh,
    full_numbers: Ints | None,
    part_numbers: Ints | None,
) -> Partner | None:
    """Map between the shown shapes: partners of the original vertices, put onto the new faces."""
    if partner is None:
        return None
    points, matched, confidence = partner.points, partner.known, np.asarray(partner.confidence)
    if part_numbers is not None:
        points, matched = points[part_numbers], matched[part_numbers]
        confidence = confidence[part_numbers]
    if full_numbers is not None:
        points = closest_points(full, points.positions(before))
    return Partner(points, matched, confidence)
