"""Models as small and as large as float32 holds: the same pictures, no warning and no infinity."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.plan import registry
from lodbench.kernels import refine, render, simplify
from lodbench.kernels.opencl.device import Unsupported
from lodbench.kernels.system import run

BALL = TriangleMesh(icosphere(2).positions, icosphere(2).triangles)
SIZE = (48, 48)


@pytest.fixture(autouse=True)
def warnings_are_errors():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def scaled(power: int, along: int | None = None) -> TriangleMesh:
    """A ball of radius 2^power; of radius 1 but for one axis where that is given."""
    points = BALL.positions.astype(np.float64)
    where = slice(None) if along is None else slice(along, along + 1)
    points[:, where] = np.ldexp(points[:, where], power)
    return TriangleMesh(points, BALL.triangles)


@pytest.mark.parametrize("power", [-100, -64, 64, 127])
@pytest.mark.parametrize("shading", [{}, {"colour": "flat"}, {"wireframe": True}], ids=str)
def test_picture_does_not_depend_on_the_unit(device, power, shading):
    expected = render(BALL, size=SIZE, device=device, **shading)
    image = render(scaled(power), size=SIZE, device=device, **shading)
    np.testing.assert_array_equal(image, expected)


@pytest.mark.parametrize("power", [-149, -126, 126])
@pytest.mark.parametrize("along", [None, 1])
def test_calls_take_any_scale_without_a_warning(device, power, along):
    mesh = scaled(power, along)
    for points, faces in (
        simplify(mesh, cells=7, device=device),
        simplify(mesh, target_count=40, device=device),
        refine(mesh, segments=2, device=device),
    ):
        assert np.isfinite(points).all()
        assert len(faces)
    assert render(mesh, size=SIZE, device=device).shape == (48, 48, 3)


@pytest.mark.parametrize("power", [-149, 127])
@pytest.mark.parametrize("name", ["numpy_pattern", "numpy_quadric_clustering", "manifold3d"])
def test_host_subjects_take_any_scale_without_a_warning(device, name, power):
    system = registry.systems().get(name)
    if system is None:
        pytest.skip(registry.registry().missing[name])
    params = next(iter(system.cases.values()))
    if hasattr(params, "segments"):
        params = replace(params, segments=2)
    try:
        prepared = system.prepare(device, scaled(power), params)
    except Unsupported as error:  # a peer that is not installed
        pytest.skip(str(error))
    run(device, prepared)
    prepared.check()
    for mesh in prepared.result():
        assert np.isfinite(mesh.positions).all()


def test_normals_that_cancel_have_no_direction_and_are_finite(device):
    positions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    normals = [[0, 0, 1], [0, 0, -1], [0, 0, 1]]
    mesh = TriangleMesh(positions, [[0, 1, 2]], normals)
    system = registry.system("numpy_pattern")
    prepared = system.prepare(device, mesh, replace(next(iter(system.cases.values())), segments=2))
    run(device, prepared)
    assert np.isfinite(prepared.result()[0].normals).all()


def test_values_across_all_of_float64_are_coloured(device):
    ends = np.where(np.arange(BALL.vertex_count) % 2, 1.7e308, -1.7e308)
    unit = np.where(np.arange(BALL.vertex_count) % 2, 1.0, 0.0)
    image = render(BALL, size=SIZE, colour=ends, device=device)
    np.testing.assert_array_equal(image, render(BALL, size=SIZE, colour=unit, device=device))


def test_fitted_image_stays_within_float32(device):
    points, _ = simplify(
        scaled(127), target_count=50, method="quadtree_lod", cache=False, device=device
    )
    assert np.isfinite(points).all()
