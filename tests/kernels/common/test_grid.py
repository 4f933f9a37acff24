import numpy as np
import pytest

from lodbench.kernels.cluster.grid import Grid
from tests.kernels.common.calling import Caller

POINTS = np.random.default_rng(0).normal(3, 2, (8 * 12 + 5, 3)).astype(np.float32)
STORE = (
    "vstore8(q.x, 0, out + 24 * i); vstore8(q.y, 1, out + 24 * i); vstore8(q.z, 2, out + 24 * i);"
)


@pytest.fixture(scope="module")
def call(device, tmp_path_factory):
    return Caller(device, tmp_path_factory.mktemp("kernels"), "common/grid.cl")


def planes(array):
    """Rows of what STORE wrote: (n, 3)."""
    return array.reshape(-1, 3, 8).transpose(0, 2, 1).reshape(-1, 3)


@pytest.mark.parametrize("count", [1, 7, 8, 9, 96, 101])
def test_eight_positions_are_loaded_and_past_the_last_it_is_repeated(call, count):
    groups = -(-count // 8)
    found = call(
        f"const grid_points8 q = grid_load8(positions, 8 * i, rows); {STORE}",
        groups,
        {"out": (24 * groups, np.float32)},
        positions=POINTS[:count],
        rows=count,
    )
    expected = np.minimum(np.arange(8 * groups), count - 1)
    np.testing.assert_array_equal(planes(found["out"]), POINTS[expected])


@pytest.mark.parametrize("scale", [1e-20, 1.0, 1e20])
@pytest.mark.parametrize("cells", [7, (3, 4, 5)])
def test_points_and_cells_are_those_of_the_grid_in_numpy(call, scale, cells):
    points = POINTS[:96] * np.float32(scale)
    grid = Grid.over(points.min(0), points.max(0), cells)
    given = grid.arguments
    found = call(
        f"""const float4 axes = vload4(0, per_axis);
    const grid_points8 q = grid_scale8(grid_load8(positions, 8 * i, 96), vload4(0, low), axes.w);
    {STORE} vstore8(grid_cell8(q, axes, vload4(0, cells)), i, cell);""",
        12,
        {"out": (96 * 3, np.float32), "cell": (96, np.int32)},
        positions=points,
        low=np.array(given["low"], np.float32),
        per_axis=np.array(given["per_axis"], np.float32),
        cells=np.array(given["cells"], np.uint32),
    )
    own = grid.points(points)
    np.testing.assert_array_equal(planes(found["out"]), own)
    np.testing.assert_array_equal(found["cell"], grid.cells_of(own))
    assert found["cell"].max() == grid.cell_count - 1 or np.unique(found["cell"]).size > 20


def test_no_float_names_a_cell_outside_the_grid(call):
    odd = np.array([np.nan, np.inf, -np.inf, 3e38, -3e38, -0.5, 2.9, 3.0], np.float32)
    found = call(
        """const float8 x = vload8(0, odd);
    const grid_points8 q = {x, (float8)(1.5f), (float8)(0.0f)};
    vstore8(grid_cell8(q, (float4)(1.0f), (uint4)(3, 2, 1, 0)), 0, cell);""",
        1,
        {"cell": (8, np.int32)},
        odd=odd,
    )["cell"]
    assert ((found >= 3) & (found < 6)).all(), "the second row of three cells"
    assert found[5:].tolist() == [3, 5, 5]
