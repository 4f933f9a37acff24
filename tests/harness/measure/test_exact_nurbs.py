from types import SimpleNamespace

import numpy as np
import pytest

from lodbench.datasets_gen import nurbs
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.measure import exact_nurbs
from lodbench.harness.measure.figure import Seen
from lodbench.kernels.nurbs.uniform_nurbs import Params, UniformNurbs
from lodbench.kernels.opencl import Unsupported
from lodbench.kernels.system import run

FOUR = Params(2, "span")


def seen(device, model, params=FOUR, kind=UniformNurbs):
    prepared = kind(device, model, params)
    run(device, prepared)
    return Seen(device, prepared, model, params, prepared.check())


def moved(found, by):
    """The same with one point elsewhere."""
    (mesh,) = found.prepared.result()
    points = mesh.positions.copy()
    points[7] += np.float32(by)
    found.prepared.result = lambda: [TriangleMesh(points, mesh.triangles, mesh.normals)]
    return found


def test_surfaces_are_scipys_and_a_point_that_moved_is_found(device):
    found = seen(device, nurbs.mixed_degrees())
    assert exact_nurbs.off_scipy(found).kept
    figure = exact_nurbs.off_scipy(moved(found, 0.01))
    assert not figure.kept
    assert figure.value == pytest.approx(0.01 / found.surface.diagonal, rel=1e-3)


@pytest.mark.parametrize("degree", [1, 3, 7])
def test_basis_functions_are_those_of_the_recursion(device, degree):
    found = seen(device, nurbs.sheets(degree, 4))
    for measure in (exact_nurbs.stair, exact_nurbs.basis, exact_nurbs.unity, exact_nurbs.end):
        figure = measure(found)
        assert figure.kept, (measure.__name__, figure)
        assert figure.looked_at.endswith(f"degree {degree}, a knot {degree} times")


def test_basis_functions_of_other_knots_are_found(device):
    found = seen(device, nurbs.sheets(3, 4))
    found.prepared.model = nurbs.sheets(3, 4, seed=1)
    assert not exact_nurbs.basis(found).kept and exact_nurbs.unity(found).kept


@pytest.mark.parametrize(
    ("name", "model"),
    [("cylinder", nurbs.cylinder()), ("sphere", nurbs.ball()), ("torus", nurbs.torus())],
)
def test_points_are_on_conics(device, name, model):
    found = seen(device, model)
    assert exact_nurbs.off_conic(name)(found).kept
    assert not exact_nurbs.off_conic(name)(moved(found, 0.01)).kept


def test_tolerance_is_measured_of_what_the_device_made(device):
    found = seen(device, nurbs.ball(), Params(tolerance=1e-2))
    figure = exact_nurbs.distance(found)
    assert figure.limit == 1e-2 and 3e-3 < figure.value <= 1e-2
    assert not exact_nurbs.distance(moved(found, 0.1)).kept


def test_subjects_without_grids_are_left_out():
    found = SimpleNamespace(prepared=object())
    with pytest.raises(Unsupported, match="needs surfaces on grids"):
        exact_nurbs.off_scipy(found)
