"""What a surface sees of itself where part of it is hidden."""

from __future__ import annotations

import numpy as np

from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.surface.prepared import described_part


def test_hiding_what_stands_apart_changes_nothing(egg: TriangleMesh) -> None:
    far = egg.vertices + 10.0 * egg.length
    pair = TriangleMesh(
        np.concatenate([egg.vertices, far]),
        np.concatenate([egg.faces, egg.faces + egg.vertex_count]),
    )
    surface = described_part(pair, pair.length)
    places = surface.mesh.vertices
    along = places[:, np.ptp(places, axis=0).argmax()]
    one = along < along.mean()
    assert 0 < one.sum() < len(one)
    np.testing.assert_array_equal(surface.spectra_within(one), surface.spectra)


def test_what_lies_near_something_hidden_sees_less(egg: TriangleMesh) -> None:
    surface = described_part(egg, egg.length)
    upper = surface.mesh.vertices[:, 2] > 0
    seen = surface.spectra_within(upper)
    assert not np.array_equal(seen[:, upper], surface.spectra[:, upper])
    np.testing.assert_array_equal(seen[:, ~upper], surface.spectra[:, ~upper])
