import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from lodbench.kernels.geometry_image.parameterisation import full_mesh, topology
from lodbench.kernels.geometry_image.uniform_grid import SYSTEM, Params
from lodbench.kernels.geometry_image.uniform_grid.reference import grid, sampled
from lodbench.kernels.system import run
from tests.kernels.geometry_image.test_quadtree_lod import bumpy_image


@pytest.mark.parametrize("n", [1, 4, 6])
def test_full_grid_is_the_full_image(device, n):
    image = bumpy_image(n)
    prepared = SYSTEM.prepare(device, image, Params())
    run(device, prepared)
    assert prepared.check().passed
    assert_array_equal(prepared.result()[0].positions, full_mesh(image).positions)
    assert_array_equal(prepared.result()[0].triangles, full_mesh(image).triangles)


@pytest.mark.parametrize("cells", [2, 6, 10, 22, 30])
def test_grids_between_the_levels_close(cells):
    mesh = grid(bumpy_image(4), cells)
    assert mesh.triangle_count == 2 * cells**2
    assert not topology(mesh.triangles).faults


def test_samples_between_are_interpolated():
    ramp = np.stack(np.meshgrid(np.arange(5.0), np.arange(5.0), [0.0]), -1)[:, :, 0]
    assert_array_equal(sampled(ramp.astype(np.float32), 8)[3, 5], (2.5, 1.5, 0))


def test_target_count_is_met_from_below(device):
    prepared = SYSTEM.prepare(device, bumpy_image(4), Params(target_count=300))
    assert prepared.counters()["triangles"] == 2 * 12**2


@pytest.mark.parametrize("name", ["positions", "normals", "triangles"])
def test_check_sees_a_changed_row_of_every_array(device, name):
    prepared = SYSTEM.prepare(device, bumpy_image(3), Params())
    run(device, prepared)
    mesh = prepared._expected
    changed = getattr(mesh, name).copy()
    changed[5] = changed[5][::-1]
    prepared._expected = dataclasses.replace(mesh, **{name: changed})
    assert not prepared.check().passed


def test_check_sees_a_surface_that_does_not_close(device):
    prepared = SYSTEM.prepare(device, bumpy_image(3), Params())
    run(device, prepared)
    mesh = prepared._expected
    triangles = mesh.triangles.copy()
    triangles[0] = triangles[1]
    prepared._expected = dataclasses.replace(mesh, triangles=triangles)
    prepared._triangles = device.upload("triangles", triangles)
    check = prepared.check()
    assert not check.passed
    assert check.value > 0


def test_target_reduction_is_of_what_is_given_and_ends_at_eight(device):
    image = bumpy_image(4)
    quarter = SYSTEM.prepare(device, image, Params(target_reduction=0.75))
    assert quarter.counters()["triangles"] == image.triangle_count / 4
    assert SYSTEM.prepare(device, image, Params(target_count=3)).counters()["triangles"] == 8


@pytest.mark.parametrize("wrong", [{"cells": 3}, {"cells": 0}, {"target_count": 0}, {"n": 0}])
def test_parameters_out_of_range_are_refused(wrong):
    with pytest.raises(ValueError, match="expected"):
        Params(**wrong)
