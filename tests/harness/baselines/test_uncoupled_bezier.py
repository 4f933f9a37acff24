"""The bound of adaptive tessellation: no cell's grid could be changed for a better one."""

import numpy as np
import pytest

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.patches import cup
from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.harness.baselines.uncoupled_bezier import Params, chosen_grids, least_share, prepare
from tests.kernels.bezier.patches import bicubic


def test_cells_curved_one_way_are_cut_one_way():
    ridge = bicubic(np.array([0, 1, 1, 0.0])[:, None] * np.ones(4)).points.astype(np.float64)
    params = Params(level=3, price=1e-4)
    along_u, along_v, _ = params.grids[chosen_grids(ridge, params)[0, 0, 0]]
    assert along_u > 1 and along_v == 1


def test_triangles_are_fewer_for_a_higher_price(device):
    counts = []
    for price in (1e-6, 1e-8, 1e-10):
        prepared = prepare(device, cup(), Params(level=4, price=price))
        assert prepared.check().passed
        counts.append(prepared.result()[0].triangle_count)
    assert counts == sorted(counts) and counts[0] < counts[-1] <= 26 * 2 * 4**4


def test_with_no_price_all_is_finest_but_what_is_flat(device):
    flat = bicubic(0.0)
    both = BezierPatches(np.concatenate([flat.points, cup().points[:1]]))
    prepared = prepare(device, both, Params(level=3, price=1e-15))
    assert prepared.result()[0].triangle_count == 2 + 2 * 4**3


@pytest.mark.parametrize("other", [False, True])
def test_cut_is_along_the_flatter_diagonal(other):
    # a saddle that is straight along one diagonal
    x, y = np.meshgrid(np.arange(4) / 3, np.arange(4) / 3, indexing="ij")
    height = (x - y) ** 2 if not other else (x + y - 1) ** 2
    params = Params(level=0, price=1e-9)
    P = bicubic(height).points.astype(np.float64)
    assert params.grids[chosen_grids(P, params)[0, 0, 0]] == (1, 1, other)


def test_grids_of_any_segments_need_a_share_that_is_known():
    # one curvature everywhere: nothing to gain but by the cells' aspect
    ridge = bicubic(np.array([0, 1, 1, 0.0])[:, None] * np.ones(4)).points.astype(np.float64)
    bowl = bicubic(0.01 * (np.array([0, 1, 1, 0.0])[:, None] + np.array([0, 1, 1, 0.0])))
    assert least_share(bowl.points.astype(np.float64)) == pytest.approx(1, abs=0.02)
    assert least_share(ridge) < 0.1
    assert least_share(bicubic(0.0).points.astype(np.float64)) == 1
    # flatter by a hundred in half of the patches: (1 + 0.1)^2 / 4 over (1 + 0.01) / 2
    both = np.concatenate([bowl.points, bowl.points * np.array([1, 1, 0.01])]).astype(np.float64)
    assert least_share(both) == pytest.approx(1.1**2 / 4 / (1.01 / 2), abs=0.02)


@pytest.mark.parametrize("name", ["teapot", "elephant_gumbo"])
def test_the_bound_holds_for_what_is_chosen(data_folder, name):
    P = catalogue.load(name).surface.points.astype(np.float64)
    assert 0.3 < least_share(P) < 0.5
    assert least_share(P * 1000) == pytest.approx(least_share(P))
