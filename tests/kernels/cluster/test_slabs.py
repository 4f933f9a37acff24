"""The cluster map by slabs of cells: private's bytes for any number of slabs, chunks and cores."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.quadric_clustering import Params
from lodbench.kernels.cluster.quadric_clustering import slabs as module
from lodbench.kernels.cluster.quadric_clustering.host import prepare
from lodbench.kernels.opencl.device import Device
from lodbench.kernels.system import run
from tests.kernels.cluster.meshes import cube, sphere, tetrahedron, wavy_sheet

COUNTS = (1, 2, 8, 64)


def cluster(device, mesh, **params):
    prepared = prepare(device, mesh, Params(**params))
    run(device, prepared)
    return prepared


def outcome(device, mesh, **params):
    (result,) = cluster(device, mesh, **params).result()
    return result.positions.tobytes(), result.triangles.tobytes()


@pytest.mark.parametrize(
    "more", [{}, {"strategy": "separate"}, {"remove_duplicates": True}], ids=str
)
@pytest.mark.parametrize("maps", [1, 2, 3, 4])
def test_slabs_give_the_bytes_of_private_maps_for_any_number_of_slabs(device, maps, more):
    for mesh in (sphere(40, 80), wavy_sheet(), tetrahedron()):
        expected = outcome(device, mesh, cells=9, accumulate="private", chunks=maps, **more)
        for slabs in COUNTS:
            params = {"cells": 9, "accumulate": "slabs", "slabs": slabs, "chunks": maps, **more}
            assert outcome(device, mesh, **params) == expected, slabs


def test_slabs_of_many_triangles_fill_blocks_and_give_the_same_bytes(device):
    # lists of more than one block, in the mesh's order and in none at all
    mesh = sphere(90, 180)
    order = np.random.default_rng(5).permutation(mesh.triangle_count)
    for one in (mesh, TriangleMesh(mesh.positions, mesh.triangles[order])):
        expected = outcome(device, one, cells=20, accumulate="private")
        for slabs in (*COUNTS, module.MOST_SLABS):
            assert outcome(device, one, cells=20, accumulate="slabs", slabs=slabs) == expected


@given(
    triangles=st.lists(st.tuples(*[st.integers(0, 29)] * 3), min_size=0, max_size=300),
    slabs=st.integers(1, 40),
    cells=st.sampled_from([1, 2, 5, 40]),
    scale=st.sampled_from([1.0, 1e-30, 1e30]),
    seed=st.integers(0, 99),
)
def test_slabs_of_any_soup_give_the_bytes_of_private_maps(
    device, triangles, slabs, cells, scale, seed
):
    points = np.random.default_rng(seed).uniform(-1, 1, (30, 3)) * scale
    mesh = TriangleMesh(points, np.array(triangles, np.uint32).reshape(-1, 3))
    expected = outcome(device, mesh, cells=cells, accumulate="private")
    assert outcome(device, mesh, cells=cells, accumulate="slabs", slabs=slabs) == expected


@pytest.mark.parametrize("slabs", COUNTS)
def test_each_slab_lists_the_triangles_that_touch_it_in_their_order(device, slabs):
    mesh = sphere(30, 60)
    prepared = cluster(device, mesh, cells=12, accumulate="slabs", slabs=slabs)
    bounds = device.read(prepared.slabs.bounds)
    assert bounds[0] == 0 and bounds[-1] == prepared.occupied
    assert (np.diff(bounds.astype(np.int64)) >= 0).all()
    ranks = device.read(prepared.points)[:, 3].view(np.uint32)[mesh.triangles]
    for slab in range(slabs):
        inside = (ranks >= bounds[slab]) & (ranks < bounds[slab + 1])
        expected = mesh.triangles[inside.any(1)]
        assert np.array_equal(prepared.slabs.listed(device, slab), expected)


def test_slabs_have_like_numbers_of_corners_where_cells_do_not(device):
    # a fine patch beside a coarse one: half of the corners lie in few of the cells
    fine, coarse = wavy_sheet(120), wavy_sheet(30)
    positions = np.concatenate([fine.positions * 0.2, coarse.positions + np.float32([30, 0, 0])])
    mesh = TriangleMesh(
        positions, np.concatenate([fine.triangles, coarse.triangles + fine.vertex_count])
    )
    prepared = cluster(device, mesh, cells=60, accumulate="slabs", slabs=8)
    corners = device.read(prepared.points)[:, 3].view(np.uint32)[mesh.triangles].ravel()
    counts = np.histogram(corners, device.read(prepared.slabs.bounds))[0]
    largest_cell = np.bincount(corners).max()
    assert counts.sum() == corners.size
    assert counts.max() <= 1.25 * corners.size / 8 + largest_cell


def test_one_cell_of_all_corners_is_one_slabs_alone(device):
    mesh = sphere()
    prepared = cluster(device, mesh, cells=1, accumulate="slabs", slabs=8)
    lengths = [len(prepared.slabs.listed(device, slab)) for slab in range(8)]
    assert sorted(lengths) == [0] * 7 + [mesh.triangle_count]
    assert prepared.check().passed


@pytest.mark.parametrize("cores", [1, 2, 4, 5, 64])
def test_auto_takes_slabs_where_there_would_be_more_than_twice_as_many_as_maps(cores):
    device = Device.open()
    device.facts = replace(device.facts, compute_units=cores)
    large, small = 10**6, 10**4
    few = cores <= 4
    assert module.chosen(device, Params(), large) == ("private" if few else "slabs")
    assert module.chosen(device, Params(), small) == "private", "too few triangles for slabs"
    assert module.chosen(device, Params(accumulate="private"), large) == "private"
    assert module.slab_count(device, Params(), large) == cores
    assert module.slab_count(device, Params(slabs=7), large) == 7


def test_auto_gives_the_same_bytes_on_any_number_of_cores():
    mesh, found = cube(70), set()
    for cores in (1, 2, 16, 300):
        device = Device.open()
        device.facts = replace(device.facts, compute_units=cores)
        prepared = cluster(device, mesh, cells=20)
        assert prepared.accumulate == ("slabs" if cores > 4 else "private")
        found.add(outcome(device, mesh, cells=20))
    assert len(found) == 1


@pytest.mark.parametrize("slabs", [-1, 257, 1.5])
def test_params_refuse_impossible_slabs(slabs):
    with pytest.raises((TypeError, ValueError), match="slabs: expected"):
        Params(slabs=slabs)
