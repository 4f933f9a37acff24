import numpy as np
import pytest
from numpy.testing import assert_array_equal

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.numpy_quadtree_lod import SYSTEM, Params
from lodbench.kernels.geometry_image import quadtree_lod
from lodbench.kernels.system import run
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


def test_no_triangles_in_none_out(device):
    prepared = SYSTEM.prepare(
        device, TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int)), Params()
    )
    run(device, prepared)
    assert prepared.result()[0].triangle_count == 0
    assert prepared.check().passed
