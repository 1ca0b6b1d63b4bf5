"""The template file: smaller than its arrays, and the same bits when read."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from sherd.errors import MeshFileError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.surface.template import Template


def test_template_files_are_small_and_lose_nothing(tmp_path) -> None:
    ball = trimesh.creation.icosphere(subdivisions=3)
    shape = TriangleMesh(ball.vertices * [1.0, 1.3, 1.9], ball.faces, name="egg")
    template, path = Template(shape), tmp_path / "egg.npz"
    template.save(path)
    loaded = Template.load(path)
    for name in ("vertices", "distances", "directions", "between"):
        one, other = getattr(template.dense, name), getattr(loaded.dense, name)
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(template.spectra, loaded.spectra)
    dense = template.dense
    plain = template.spectra.nbytes + dense.distances.nbytes + dense.directions.nbytes
    assert path.stat().st_size < 0.8 * plain
    with np.load(path) as stored:
        content = dict(stored)
    np.savez(path, **{**content, "dense_distances": template.dense.distances})
    with pytest.raises(MeshFileError, match="no template of this version"):
        Template.load(path)
