import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen import patches
from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.harness.measure.quality import distance_from
from lodbench.kernels.bezier import borders, dabt, vst
from lodbench.kernels.bezier.candidates import CELL, CORNERS, nodes_of, ways_of
from lodbench.kernels.bezier.grids import (
    FIRST_HALF,
    PIECES,
    edge_levels,
    grid_masks,
    half_strips,
    piece_levels,
    piece_triangles,
    rings,
)
from lodbench.kernels.bezier.measures import inverse_diagonal
from lodbench.kernels.bezier.strips import strips
from lodbench.kernels.system import Frame, run
from tests.kernels.bezier.patches import bicubic, sheets

levels = st.integers(0, 3)


def triangles_of(mask):
    half = mask >> 60 >= FIRST_HALF
    return half_strips(mask) if half else strips(mask & ((1 << 45) - 1))


@settings(max_examples=150, deadline=None)
@given(st.tuples(levels, levels, st.integers(0, 1)), st.tuples(levels, levels, levels, levels))
def test_both_pieces_tile_the_cell_between_any_edges(wish, more):
    u, v, other = wish
    edges = np.maximum(more, [v, v, u, u])
    masks = grid_masks(np.array([u + 4 * v + 16 * other]), edges[None])[0]
    total, doubled, ends = 0, 0, []
    for mask in masks:
        nodes, way = np.flatnonzero(nodes_of(mask)), int(ways_of(mask))
        place = np.stack(np.divmod(PIECES[way, nodes], CELL + 1), axis=1)
        triangles = np.array(triangles_of(int(mask)))
        assert len(triangles) == piece_triangles(mask[None])[0]
        assert set(triangles.ravel().tolist()) == set(range(len(nodes)))
        a, b, c = (place[triangles[:, k]] for k in range(3))
        (down, across), (more_down, more_across) = (b - a).T, (c - a).T
        area = down * more_across - across * more_down
        assert (area > 0).all()  # turning from u to v
        total, doubled = total + len(triangles), doubled + area.sum()
        around = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1).reshape(-1, 2)
        ends += [tuple(map(tuple, place[end].tolist())) for end in around]
    assert doubled == 2 * CELL * CELL
    assert total == 2 * 2 ** (u + v) + (2**edges).sum() - 2 * (2**u + 2**v)
    assert len(set(ends)) == len(ends)
    alone = {end for end in ends if end[::-1] not in set(ends)}
    for k, (axis, at) in enumerate([(0, 0), (0, CELL), (1, 0), (1, CELL)]):
        on = [end for end in alone if end[0][axis] == end[1][axis] == at]
        assert len(on) == 2 ** edges[k]  # each edge is cut where its level says, and nowhere else
    assert len(alone) == (2**edges).sum()
    assert piece_levels(masks).max() == max(u, v, *edges)


def test_the_ways_of_halves_turn_as_triangles_do():
    assert len(PIECES) == 16
    assert (PIECES[:12, [0, 36, 44]] == CORNERS).all()
    assert PIECES[12, [0, 8, 44]].tolist() == [0, 8, 44]
    assert PIECES[15, [0, 8, 44]].tolist() == [76, 4, 8]


@settings(max_examples=20, deadline=None)
@given(sheets, st.integers(0, 2))
def test_rings_join_the_edges_of_cells_that_are_one(surface, base):
    found, n = borders.borders_of(surface.points), 1 << base
    ring = rings(found, base)
    assert np.array_equal(np.sort(ring), np.arange(4 * len(surface.points) * n * n))
    twice = ring[ring]
    inner = ring != np.arange(len(ring))
    assert (twice[inner] == np.arange(len(ring))[inner]).all()  # a sheet: two at the most
    outer = (
        found.curve == np.flatnonzero(np.bincount(found.curve.ravel()) == 1)[:, None, None]
    ).sum()
    assert (~inner).sum() == outer * n
    wishes = np.random.default_rng(base).integers(0, 16, len(ring) // 4)
    edges = edge_levels(wishes, ring).ravel()
    assert np.array_equal(edges, edges[ring])


def made(device, surface, **options):
    prepared = dabt.prepare(device, surface, dabt.Params(test="mean", **options))
    run(device, prepared, Frame())
    return prepared


def test_a_cylinder_is_cut_along_its_bend_alone(device):
    surface = bicubic(np.array([0, 1, 1, 0])[:, None] / 2)
    prepared = made(device, surface, level=3, threshold=1e-5)
    (wish,) = set(prepared.wishes().tolist())
    assert wish >> 2 & 3 == 0 and wish & 3 > 0
    assert prepared.live()[1] == 2 * 2 ** (wish & 3)
    flat = made(device, bicubic(0.0), level=3, threshold=1e-9)
    assert flat.live()[1] == 2


def test_a_twisted_patch_is_cut_along_its_valley(device):
    height = np.outer(np.arange(4), np.arange(4)) / 9
    for sign, other in ((1, 0), (-1, 1)):
        x = np.arange(4) / 3
        bowl = 0.2 * ((x - 0.5) ** 2)[:, None] + 0.2 * ((x - 0.5) ** 2)
        surface = bicubic(bowl - sign * 0.1 * height)
        wishes = made(device, surface, level=3, threshold=1e-6).wishes()
        assert (wishes >> 4 == other).all()


def test_mean_needs_fewer_triangles_than_one_level_for_all(device):
    surface = patches.pot(8)

    def error(mesh):
        prepared = vst.Vst(device, surface, vst.Params(6, normals=False))
        run(device, prepared, Frame())
        finer = prepared.result()[0]
        return distance_from(finer, mesh, finer.diagonal)["mean_difference"]

    other = vst.Vst(device, surface, vst.Params(4))
    run(device, other, Frame())
    prepared = made(device, surface, level=5, threshold=1e-8)
    assert error(prepared.result()[0]) <= error(other.result()[0])
    assert prepared.live()[1] < 0.7 * other.live()[1]


def test_prices_are_those_of_the_whole_surface(device):
    one = made(device, patches.pot(8), level=4, threshold=1e-8)
    far = patches.pot(8).points * np.float32(1024)
    other = made(device, BezierPatches(far), level=4, threshold=1e-8)
    assert np.array_equal(one.masks(), other.masks())
    assert one.area == pytest.approx(other.area)
    assert inverse_diagonal(far) == pytest.approx(one._inverse / 1024)
