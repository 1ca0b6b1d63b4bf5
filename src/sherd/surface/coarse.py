"""A template in few numbers: its labels alone, for evidence that must be cheap.

Of 10,000 vertices 600 stay, each with its own neighborhood. Their geodesic distances and directions
are those of the template, so a labeling on them means the same; it only cannot point between them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from sherd.arrays import Ints
from sherd.descriptors.principal_spectra import PrincipalAxes
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.surface.described import DescribedSurface, Known
from sherd.surface.samples import COARSE_COUNT, Samples
from sherd.surface.working import WorkingSurface

__all__ = ["coarse_arrays", "coarse_from_arrays", "coarse_surface"]

# Arrays of a coarse surface and how many axes each has.
AXES = {"vertices": 2, "faces": 2, "between": 2, "directions": 2, "axes": 3, "spectra": 3}


def coarse_surface(surface: DescribedSurface) -> DescribedSurface:
    """The labels that lie farthest apart as a surface of their own; asked for labels only.

    Its mesh joins labels whose cells meet, three at a face.
    """
    labels = surface.dense.thinned(COARSE_COUNT)
    corners = labels.cells[surface.mesh.faces]
    return _surface(
        TriangleMesh(
            surface.mesh.vertices[labels.vertices], _meeting(corners), name=surface.mesh.name
        ),
        Samples.of(np.arange(len(labels)), np.asarray(labels.between), labels.directions),
        surface.axes,
        np.ascontiguousarray(surface.spectra[:, labels.vertices]),
    )


def coarse_arrays(surface: DescribedSurface) -> dict[str, ArrayLike]:
    """What a file keeps of a coarse surface: 4 MB."""
    return {
        "vertices": surface.mesh.vertices,
        "faces": surface.mesh.faces,
        "between": surface.dense.distances,
        "directions": surface.dense.directions,
        "axes": surface.axes.axes,
        "spectra": surface.spectra,
    }


def coarse_from_arrays(arrays: Mapping[str, Any], name: str) -> DescribedSurface:
    """The coarse surface that :func:`coarse_arrays` were made of.

    Raises
    ------
    KeyError, ValueError
        If an array is missing or does not fit the others.
    """
    count = len(np.atleast_1d(arrays["vertices"]))
    for each, axes in AXES.items():
        if arrays[each].ndim != axes or arrays[each].dtype.kind not in "fiu":
            raise ValueError(f"{each} has a wrong shape")
    if {arrays["between"].shape, arrays["directions"].shape} != {(count, count)}:
        raise ValueError("distances do not fit the labels")
    fits = arrays["spectra"].shape[1:] == (count, 2 * arrays["axes"].shape[2])
    if not fits or not 0 <= arrays["faces"].min() <= arrays["faces"].max() < count:
        raise ValueError("spectra or faces do not fit the labels")
    return _surface(
        TriangleMesh(arrays["vertices"], arrays["faces"], name=name),
        Samples.of(np.arange(count), arrays["between"], arrays["directions"]),
        PrincipalAxes(arrays["axes"]),
        arrays["spectra"],
    )


def _surface(
    mesh: TriangleMesh, labels: Samples, axes: PrincipalAxes, spectra: Any
) -> DescribedSurface:
    known = Known(dense=labels, axes=axes, spectra=spectra)
    return DescribedSurface(WorkingSurface(mesh, mesh, None), known=known)


def _meeting(corners: Ints) -> Ints:
    """(f, 3) labels whose cells meet in a face, each three once, turned as the face is."""
    a, b, c = corners.T
    rows = corners[(a != b) & (b != c) & (c != a)]
    if not len(rows):  # fewer than three cells meet anywhere: any three labels will do
        return np.array([[0, 1, 2]], dtype=np.int64) % (int(corners.max()) + 1)
    first = rows.argmin(axis=1)
    rows = np.take_along_axis(rows, (first[:, None] + np.arange(3)) % 3, axis=1)
    found: Ints = np.unique(rows, axis=0)
    return found
