"""The bound of adaptive refinement: every patch near enough, with no segment to spare."""

import numpy as np
import pytest

from lodbench.datasets_gen.triangles import icosphere, torus
from lodbench.harness.baselines.curved import control_weights, controls
from lodbench.harness.baselines.uncoupled_pn_triangles import (
    Params,
    flat_weights,
    least_segments,
    prepare,
)
from lodbench.kernels.refine.lattice import lattice_weights


@pytest.mark.parametrize("segments", [1, 2, 3, 7])
def test_flat_pieces_meet_the_patch_at_the_lattice_and_are_flat_between(segments):
    at = lattice_weights(segments)
    np.testing.assert_allclose(flat_weights(segments, at), control_weights(at)[0], atol=1e-12)
    corners = np.sort(np.random.default_rng(0).permutation(segments)[:1])
    first = at[[r * (r + 1) // 2 for r in (*corners, *(corners + 1))]]
    ends = control_weights(first)[0]
    middle = flat_weights(segments, first.mean(axis=0, keepdims=True))
    np.testing.assert_allclose(middle[0], ends.mean(axis=0), atol=1e-12)


@pytest.mark.parametrize("doubling", [False, True])
def test_every_patch_is_within_tolerance_and_not_with_a_size_less(doubling):
    points = controls(torus(9, 7).with_normals())[0].astype(np.float64)
    sizes = Params(segments=32, doubling=doubling).sizes
    found = least_segments(points, 3e-3, sizes)
    assert len(np.unique(found)) > 1
    places = np.random.default_rng(1).dirichlet((1, 1, 1), 4000)
    patch = control_weights(places)[0]

    def worst(row, size):
        off = (patch - flat_weights(size, places)) @ points[row]
        return np.linalg.norm(off, axis=1).max()

    for row, size in enumerate(found):
        assert worst(row, size) <= 3e-3 * 1.05
        if size > 1:
            assert worst(row, sizes[sizes.index(size) - 1]) > 3e-3 * 0.9


def test_mesh_has_as_many_triangles_and_check_finds_a_missing_one(device):
    prepared = prepare(device, icosphere(1), Params(tolerance=1e-3, segments=16))
    assert prepared.check().passed
    mesh = prepared.result()[0]
    np.testing.assert_allclose(np.linalg.norm(mesh.positions, axis=1), 1, atol=0.05)
    _, triangles = prepared._last
    triangles[0] = triangles[0][1:]
    assert not prepared.check().passed
