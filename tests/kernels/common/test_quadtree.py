import numpy as np
import pytest

from lodbench.kernels.geometry_image.parameterisation.octahedron import canonical
from lodbench.kernels.geometry_image.quadtree_lod.fit import anti_diagonal
from lodbench.kernels.geometry_image.quadtree_lod.reference import unpack
from tests.kernels.common.calling import Caller

LEVELS = (1, 2, 3, 5)


@pytest.fixture(scope="module")
def call(device, tmp_path_factory):
    return Caller(device, tmp_path_factory.mktemp("kernels"), "common/quadtree.cl")


def nodes(n):
    """(depth, x, y) of every node, level by level."""
    return np.array(
        [(d, x, y) for d in range(n + 1) for y in range(1 << d) for x in range(1 << d)], np.uint32
    )


@pytest.mark.parametrize("n", LEVELS)
def test_every_node_has_a_texel_of_its_own_where_the_packing_puts_it(call, n):
    depth, x, y = nodes(n).T
    found = call(
        """out[i] = quadtree_texel(depth[i], x[i], y[i], n);
    vstore3(quadtree_node(out[i], n), i, node);
    above[i] = depth[i] < n ? quadtree_column_depth(out[i] & ((1 << n) - 1)) : depth[i];""",
        len(depth),
        {name: (len(depth) * k, np.uint32) for name, k in (("out", 1), ("node", 3), ("above", 1))},
        depth=depth,
        x=x,
        y=y,
        n=n,
    )
    texels = np.arange(3 << (2 * n - 1), dtype=np.uint32)
    packed = unpack(texels, n)
    np.testing.assert_array_equal(found["out"], np.concatenate([level.ravel() for level in packed]))
    assert len(np.unique(found["out"])) == len(depth)
    size = (1 << n) >> depth
    np.testing.assert_array_equal(found["node"].reshape(-1, 3).T, [x * size, y * size, size])
    np.testing.assert_array_equal(found["above"], depth)


@pytest.mark.parametrize("n", LEVELS)
def test_border_samples_stand_for_their_folded_twins(call, n):
    side = (1 << n) + 1
    found = call(
        """const uint column = i % ((1 << n) + 1), row = i / ((1 << n) + 1);
    sample[i] = quadtree_sample(column, row, n);
    own[i] = quadtree_sample_is_own(column, row, n);""",
        side * side,
        {"sample": (side * side, np.uint32), "own": (side * side, np.uint8)},
        n=n,
    )
    np.testing.assert_array_equal(found["sample"], canonical(n).ravel())
    np.testing.assert_array_equal(found["own"], found["sample"] == np.arange(side * side))


@pytest.mark.parametrize("n", LEVELS)
def test_diagonals_run_along_the_octahedrons_edges(call, n):
    for depth in range(1, n + 1):
        size, across = 1 << (n - depth), 1 << depth
        found = call(
            "out[i] = quadtree_anti_diagonal(i % across * size, i / across * size, size, n);",
            across * across,
            {"out": (across * across, np.uint8)},
            across=across,
            size=size,
            n=n,
        )
        np.testing.assert_array_equal(found["out"], anti_diagonal(depth).ravel())


@pytest.mark.parametrize("stride", [1, 5, -3])
def test_next_corner_is_the_next_that_is_flagged(call, stride):
    rng, size = np.random.default_rng(0), 32
    steps = np.zeros(size + 1, np.uint8)

    def split(low, high):
        steps[[low, high]] = 1
        if high - low > 1 and rng.random() < 0.7:
            split(low, (low + high) // 2)
            split((low + high) // 2, high)

    split(0, size)
    assert 5 < steps.sum() < size
    start = 0 if stride > 0 else -stride * size
    flags = np.zeros(size * abs(stride) + 1, np.uint8)
    flags[start + stride * np.arange(size + 1)] = steps
    corners = np.flatnonzero(steps).astype(np.uint32)
    found = call(
        "out[i] = quadtree_next_corner(flags, start, stride, size, corners[i]);",
        len(corners) - 1,
        {"out": (len(corners) - 1, np.uint32)},
        flags=flags,
        corners=corners,
        start=start,
        stride=stride,
        size=size,
    )
    np.testing.assert_array_equal(found["out"], corners[1:])


@pytest.mark.parametrize(("n", "runs"), [(1, 1), (1, 2), (3, 1), (3, 4), (4, 2)])
def test_runs_share_a_row_and_keep_what_stands_for_itself(call, n, runs):
    side = (1 << n) + 1
    found = call(
        """const uint2 run = quadtree_row_run(i % runs, runs, n);
    vstore2(run, i, all);
    vstore2(quadtree_own_run(run, i / runs, n), i, own);""",
        side * runs,
        {"all": (2 * side * runs, np.uint32), "own": (2 * side * runs, np.uint32)},
        runs=runs,
        n=n,
    )
    is_own = (canonical(n).ravel() == np.arange(side * side)).reshape(side, side)
    parts = found["all"].reshape(side, runs, 2).astype(int)
    owned = found["own"].reshape(side, runs, 2).astype(int)
    for row in range(side):
        everything = [i for run in parts[row] for i in range(*run)]
        assert everything == list(range(side))
        mine = [i for run in owned[row] for i in range(*run)]
        assert mine == np.flatnonzero(is_own[row]).tolist()
