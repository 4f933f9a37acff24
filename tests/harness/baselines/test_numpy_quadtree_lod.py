import numpy as np
import pytest
from numpy.testing import assert_array_equal

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.numpy_quadtree_lod import SYSTEM, Params
from lodbench.harness.baselines.numpy_quadtree_lod.walk import Walk
from lodbench.kernels.geometry_image import quadtree_lod
from lodbench.kernels.geometry_image.quadtree_lod.reference import fine_nodes, merge, node_states
from lodbench.kernels.geometry_image.quadtree_lod.view import LodCriterion
from lodbench.kernels.system import Frame, run
from tests.kernels.geometry_image.test_quadtree_lod import bumpy_image


@pytest.mark.parametrize("threshold", [0.0, 3e-4, 1e-2, 1.0])
def test_host_draws_what_the_kernels_draw(device, threshold):
    drawn = []
    for system, kind in ((SYSTEM, Params), (quadtree_lod.SYSTEM, quadtree_lod.Params)):
        prepared = system.prepare(device, bumpy_image(5), kind(threshold=threshold))
        run(device, prepared)
        assert prepared.check().passed
        drawn.append(prepared.result()[0])
    assert_array_equal(drawn[0].positions, drawn[1].positions)
    assert_array_equal(drawn[0].triangles, drawn[1].triangles)


@pytest.mark.parametrize("n", range(1, 8))
def test_walk_agrees_with_the_reference_on_any_choice_of_nodes(n):
    image = bumpy_image(n)
    rng = np.random.default_rng(n)
    for share in (0.02, 0.3, 0.7):
        errors = [
            rng.random((1 << depth, 1 << depth), np.float32) + np.float32(share - 0.5)
            for depth in range(n + 1)
        ]
        expected = merge(image, node_states(fine_nodes(errors, [], LodCriterion(0.5))))
        drawn = Walk(image, errors)(np.float32(0.5))
        assert drawn.triangles.dtype == np.uint32
        assert_array_equal(drawn.positions, expected.positions)
        assert_array_equal(drawn.normals, expected.normals)
        assert_array_equal(drawn.triangles, expected.triangles)


@pytest.mark.parametrize("name", ["positions", "normals", "triangles"])
def test_another_vertex_or_triangle_fails_the_check(device, name):
    prepared = SYSTEM.prepare(device, bumpy_image(4), Params(threshold=1e-2))
    right = prepared.call(Frame())
    values = getattr(right, name).copy()
    values[0] = values[0][[1, 2, 0]]
    prepared.call = lambda _: right._replace(**{name: values})
    run(device, prepared)
    check = prepared.check()
    assert not check.passed
    assert check.value == 1


def test_threshold_beyond_float32_draws_the_coarsest(device):
    prepared = SYSTEM.prepare(device, bumpy_image(4), Params(threshold=1e300))
    assert prepared.result()[0].triangle_count == 8
    assert prepared.check().passed


def test_no_triangles_in_none_out(device):
    prepared = SYSTEM.prepare(
        device, TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int)), Params()
    )
    run(device, prepared)
    assert prepared.result()[0].triangle_count == 0
    assert prepared.check().passed
