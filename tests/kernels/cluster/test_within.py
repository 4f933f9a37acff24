import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.measure.quality import measure
from lodbench.kernels.cluster.within import Within
from tests.kernels.cluster.meshes import flat_lattice, sphere


def moved(mesh, by):
    return TriangleMesh(mesh.positions + np.asarray(by, np.float32), mesh.triangles)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10_000), share=st.floats(0.2, 3.0))
def test_what_is_far_agrees_with_measured_distances(device, seed, share):
    rng = np.random.default_rng(seed)
    meshes = [
        TriangleMesh(rng.normal(size=(9, 3)), rng.integers(0, 9, (int(rng.integers(1, 9)), 3)))
        for _ in range(2)
    ]
    largest = measure(*meshes, samples=20_000)["max_error"]
    if not largest:
        return
    found = any(flags.any() for flags in Within(device, meshes[0]).far(meshes[1], share * largest))
    if share < 1:
        assert found
    elif share > 1.2:
        assert not found


def test_a_sheet_over_another_is_as_far_as_it_is_high(device):
    sheet = flat_lattice(9)
    within = Within(device, sheet)
    other = moved(sheet, (0, 0, 0.01 * sheet.diagonal))
    assert [f.all() for f in within.far(other, 0.0099)] == [True, True]
    assert [f.any() for f in within.far(other, 0.0102)] == [False, False]


def test_what_bulges_between_corners_is_found_by_cutting(device):
    # a square bent along one diagonal, and along the other
    corners = [[0, 0, 0], [1, 0, 0.3], [1, 1, 0], [0, 1, 0.3]]
    one = TriangleMesh(corners, [[0, 1, 2], [0, 2, 3]])
    other = TriangleMesh(corners, [[0, 1, 3], [1, 2, 3]])
    within = Within(device, one)
    assert [f.all() for f in within.far(other, 0.1)] == [True, True]
    largest = measure(one, other)["max_error"]
    assert [f.any() for f in within.far(other, 1.02 * largest)] == [False, False]


@pytest.mark.parametrize("scale", [1e-30, 1e30])
def test_scale_changes_nothing(device, scale):
    ball = sphere()
    big = TriangleMesh(ball.positions.astype(np.float64) * scale, ball.triangles)
    other = TriangleMesh(ball.positions.astype(np.float64) * 1.02 * scale, ball.triangles)
    within = Within(device, big)
    assert all(flags.all() for flags in within.far(other, 0.004))
    assert not any(flags.any() for flags in within.far(other, 0.009))
