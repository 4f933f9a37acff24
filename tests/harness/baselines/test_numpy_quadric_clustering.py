import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.numpy_quadric_clustering import SYSTEM, Params
from lodbench.kernels.cluster.quadric_clustering import SYSTEM as KERNELS
from lodbench.kernels.system import run
from tests.kernels.cluster.meshes import (
    cube,
    flat_lattice,
    single_triangle,
    sphere,
    tetrahedron,
    wavy_sheet,
)


@pytest.mark.parametrize("placement", ["robust", "paper", "average"])
@pytest.mark.parametrize("cells", [1, 3, 9.5, (4, 7, 2), 200])
@pytest.mark.parametrize(
    "make", [single_triangle, tetrahedron, cube, sphere, wavy_sheet, lambda: flat_lattice(5)]
)
def test_numpy_quadric_clustering_agrees_with_reference(device, make, cells, placement):
    prepared = SYSTEM.prepare(device, make(), Params(cells, placement))
    run(device, prepared)
    check = prepared.check()
    assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"


@pytest.mark.parametrize("duplicates", [False, True])
def test_numpy_quadric_clustering_gives_the_kernels_triangles(device, duplicates):
    params = Params(7, remove_duplicates=duplicates)
    ours = KERNELS.prepare(device, wavy_sheet(), params.kernel())
    numpy_form = SYSTEM.prepare(device, wavy_sheet(), params)
    for prepared in (ours, numpy_form):
        run(device, prepared)
    assert np.array_equal(numpy_form.result()[0].triangles, ours.result()[0].triangles)


def test_numpy_quadric_clustering_no_triangles_in_none_out(device):
    mesh = TriangleMesh(np.zeros((4, 3)), np.zeros((0, 3), int))
    prepared = SYSTEM.prepare(device, mesh, Params(8))
    run(device, prepared)
    assert prepared.result()[0].triangle_count == 0
    assert prepared.check().passed


def test_numpy_quadric_clustering_refuses_what_the_kernels_refuse():
    with pytest.raises(ValueError, match="cells: expected"):
        Params(0)
    with pytest.raises(ValueError, match="placement: expected"):
        Params(placement="best")
