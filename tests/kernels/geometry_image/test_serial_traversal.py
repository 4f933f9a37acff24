import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.geometry_image import quadtree_lod
from lodbench.kernels.geometry_image.parameterisation import topology
from lodbench.kernels.geometry_image.serial_traversal import SYSTEM, Params
from lodbench.kernels.geometry_image.serial_traversal.reference import differing
from lodbench.kernels.opencl.device import Unsupported
from lodbench.kernels.system import run
from tests.kernels.geometry_image.test_quadtree_lod import bumpy_image


@pytest.mark.parametrize("n", [1, 2, 6])
@pytest.mark.parametrize("threshold", [0.0, 1e-3, 1e-2, 1.0])
def test_walk_draws_what_the_filter_draws(device, n, threshold):
    image = bumpy_image(n)
    drawn = []
    for system in (SYSTEM, quadtree_lod.SYSTEM):
        prepared = system.prepare(device, image, Params(threshold=threshold))
        run(device, prepared)
        assert prepared.check().passed
        drawn.append(prepared.result()[0])
    assert drawn[0].vertex_count == drawn[1].vertex_count
    assert differing(*drawn) == 0
    assert not topology(drawn[0].triangles).faults


def test_comparison_of_surfaces_sees_a_missing_and_a_turned_triangle():
    points = np.random.default_rng(0).random((4, 3))
    faces = np.array([(0, 1, 2), (1, 3, 2)])
    mesh = TriangleMesh(points, faces)
    order = np.array([2, 0, 3, 1])
    shuffled = TriangleMesh(points[order], np.argsort(order)[np.roll(faces[::-1], 1, axis=1)])
    assert differing(mesh, shuffled) == 0
    assert differing(mesh, TriangleMesh(points, faces[:1])) == 1
    assert differing(mesh, TriangleMesh(points, faces[:, ::-1])) > 0


def test_comparison_of_surfaces_is_not_misled_by_vertices_at_one_place():
    points = np.array([(0, 0, 0), (0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 0)])
    faces = np.array([(0, 1, 2), (3, 4, 1), (0, 1, 4), (2, 3, 4)])
    mesh = TriangleMesh(points, faces)
    order = np.array([4, 2, 1, 0, 3])
    shuffled = TriangleMesh(points[order], np.argsort(order)[np.roll(faces[::-1], 1, axis=1)])
    assert differing(mesh, shuffled) == 0
    assert differing(mesh, TriangleMesh(points, faces[:, ::-1])) > 0


def test_a_threshold_for_each_node_is_not_supported(device):
    with pytest.raises(Unsupported, match="one threshold for the whole model"):
        SYSTEM.prepare(device, bumpy_image(2), Params(view="node"))
