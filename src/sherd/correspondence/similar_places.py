"""Where near its present place each vertex of the part looks most alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sherd.arrays import Floats, Ints, Singles
from sherd.correspondence.similar_places_kernel import Sheet, Spectra, most_alike
from sherd.descriptors.rotation_shot import shift_table
from sherd.mesh.vertex_cells_kernel import sorted_into_cells
from sherd.surface.described import DescribedSurface
from sherd.threads import over_rows, search_threads

__all__ = ["Look", "similar_places"]


@dataclass(frozen=True, eq=False)
class Look:
    """Which neighborhoods are compared.

    Attributes
    ----------
    vertices
        (q,) vertices of the part that look for similar places.
    full_spectra, part_spectra
        Spectra of all vertices of the full shape, and of these vertices.
    trust
        (q,) weight of each in [0, 1].
    """

    vertices: Ints
    full_spectra: Singles
    part_spectra: Singles
    trust: Floats


def similar_places(
    full: DescribedSurface, positions: Floats, look: Look, *, reach: float
) -> tuple[Floats, Floats, Floats]:
    """Where near its place each query vertex looks most alike: soft maximum over a ball.

    `positions` (n', 3) are the places of all vertices of the part, `reach` the radius of the ball.

    Returns
    -------
    targets, confidence, similarity
        (q, 3) places, (q,) in [0, 1]: low where equally similar places are far apart, and (q,)
        the best similarity.
    """
    here = positions[look.vertices]
    # the nearest vertex is always compared, and says which sheet of the surface is meant
    workers = search_threads(len(here))
    nearest: Ints = np.asarray(full.vertex_tree.query(here, workers=workers)[1])
    mesh = full.mesh
    targets = np.empty((len(here), 3))
    confidence, similarity = np.empty(len(here)), np.empty(len(here))
    over_rows(
        most_alike, len(here), here, nearest, sorted_into_cells(mesh.vertices, reach),
        Sheet(mesh.vertices, full.normals, mesh.vertex_areas),
        Spectra(look.full_spectra, look.part_spectra, shift_table()), reach,
        targets, confidence, similarity,
    )  # fmt: skip
    return targets, confidence, similarity
