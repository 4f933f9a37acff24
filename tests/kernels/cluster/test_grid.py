import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.survivors import FILE
from lodbench.kernels.opencl.timeline import Timeline

# of every size that a float32 has, the smallest ones and zero among them
floats = st.one_of(
    st.floats(width=32, allow_nan=False, allow_infinity=False),
    st.builds(lambda m, e: float(np.float32(m * 2.0**e)), st.floats(-1, 1), st.integers(-149, 127)),
)
grids = st.one_of(st.floats(1, 400), st.tuples(*[st.integers(1, 400)] * 3))


def cells_on_device(device, grid, positions):
    ids = device.upload("cell_ids", np.full(len(positions), 0xFFFFFFFF, np.uint32))
    device.build(FILE).launch(
        "cluster_search_cells", 1, stage="cells", local=1, cell_ids=ids, chunk_count=1,
        positions=device.upload("positions", positions), vertex_count=len(positions),
        **grid.arguments,
    )(Timeline())  # fmt: skip
    return device.read(ids)


@pytest.mark.filterwarnings("error")
@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(points=st.lists(st.tuples(floats, floats, floats), min_size=2, max_size=12), cells=grids)
def test_grid_over_any_floats_is_finite_and_decided_alike_by_numpy_and_kernel(
    device, points, cells
):
    positions = np.array(points, np.float32)
    grid = Grid.over(positions.min(0), positions.max(0), cells)
    assert np.isfinite([*grid.per_axis, grid.inverse, grid.unit, grid.prescale, *grid.low]).all()
    assert grid.inverse > 0 and grid.unit > 0
    own = grid.points(positions)
    assert np.isfinite(own).all()
    cell = grid.cells_of(own)
    assert 0 <= cell.min() and cell.max() < grid.cell_count
    np.testing.assert_array_equal(cells_on_device(device, grid, positions), cell)
    back = grid.positions(own).astype(float)
    positions = np.clip(
        positions, -3.4e38, 3.4e38
    )  # positions end there: a step past it stays finite
    assert np.abs(back - positions).max() <= 1e-6 * np.abs(positions).max() + 1e-44


def test_axis_that_is_nothing_beside_the_longest_is_flat():
    box = np.zeros(3), np.array([9.0, 1e-39, 9 * 2.0**-98])
    assert Grid.over(*box, (4, 4, 4)).per_axis.tolist() == [1.0, 0.0, 2.0**98]


def test_whole_number_of_cells_is_not_one_more_by_its_rounding():
    # 7 / 25 * 25 is a little more than 7 in float64
    grid = Grid.over(np.zeros(3), np.array([25.0, 7.0, 14.0]), 25)
    assert grid.counts == (25, 7, 14)
    assert Grid.over(np.zeros(3), np.array([25.0, 7.001, 14.0]), 25).counts == (25, 8, 14)
