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
    Wish,
    edges_of,
    grid_masks,
    piece_levels,
    piece_triangles,
    rings,
)
from lodbench.kernels.bezier.half_strips import half_strips
from lodbench.kernels.bezier.measures import inverse_diagonal
from lodbench.kernels.bezier.strips import strips
from lodbench.kernels.system import Frame, run
from tests.kernels.bezier.patches import bicubic, sheets

PLACES = np.arange(CELL + 1)
parts = st.tuples(st.integers(0, 2), st.integers(0, 3), st.integers(0, 1))
wishes = st.builds(
    lambda cut, *halves: (
        cut + sum(a + 4 * b + 16 * c << 2 + 5 * k for k, (a, b, c) in enumerate(halves))
    ),
    st.integers(0, 2),
    parts,
    parts,
)
nested = st.integers(0, 127).map(lambda bits: closed(np.array([bits >> k & 1 for k in range(7)])))


def closed(places):
    """With each place those between which it lies, and both ends."""
    on = np.concatenate([[1], places, [1]]).astype(bool)
    for step in (1, 2):
        for middle in range(2 * step, CELL, 4 * step):
            on[middle] |= on[middle - step] | on[middle + step]
    return on


def triangles_of(mask):
    half = mask >> 60 >= FIRST_HALF
    return half_strips(mask) if half else strips(mask & ((1 << 45) - 1))


@settings(max_examples=200, deadline=None)
@given(wishes, st.tuples(nested, nested, nested, nested))
def test_both_pieces_tile_the_cell_between_any_edges(wish, more):
    alone = np.arange(0, 8, 2, dtype=np.uint32)  # a ring for each edge
    own = edges_of(np.array([wish]), alone)[0]
    edges = own | np.array(more)
    masks = grid_masks(np.array([wish]), edges[None])[0]
    doubled, ends = 0, []
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
        doubled += area.sum()
        around = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1).reshape(-1, 2)
        ends += [tuple(map(tuple, place[end].tolist())) for end in around]
    assert doubled == 2 * CELL * CELL
    assert len(set(ends)) == len(ends)
    outside = {end for end in ends if end[::-1] not in set(ends)}
    for k, (axis, at) in enumerate([(0, 0), (0, CELL), (1, 0), (1, CELL)]):
        on = {end[0][1 - axis] for end in outside if end[0][axis] == end[1][axis] == at}
        on |= {end[1][1 - axis] for end in outside if end[0][axis] == end[1][axis] == at}
        assert on == set(PLACES[edges[k]].tolist())  # cut there, and nowhere else
    assert len(outside) == edges.sum() - 4
    assert 0 <= piece_levels(masks).min() <= piece_levels(masks).max() <= 3


@given(st.integers(1, 3), st.integers(0, 3))
@settings(max_examples=12, deadline=None)
def test_halves_alike_are_a_grid(u, v):
    half = u - 1 | v << 2
    wish = np.array([1 | half << 2 | half << 7])
    edges = edges_of(wish, np.arange(0, 8, 2, dtype=np.uint32))
    masks = grid_masks(wish, edges)
    assert piece_triangles(masks[0]).sum() == 2 ** (1 + u + v)
    assert (edges.sum(-1)[0] == [2**v + 1, 2**v + 1, 2**u + 1, 2**u + 1]).all()
    assert piece_levels(masks[0]).max() == max(u, v)


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
    turned, after = ring & 1, ring >> 1
    assert np.array_equal(np.sort(after), np.arange(4 * len(surface.points) * n * n))
    inner = after != np.arange(len(ring))
    assert (after[after] == np.arange(len(ring))).all()  # a sheet: two at the most
    uses = np.bincount(found.curve.ravel(), minlength=found.curve.max() + 1)
    assert (~inner).sum() == (uses[found.curve] == 1).sum() * n
    wished = np.random.default_rng(base).integers(0, 2**12, len(ring) // 4)
    wished = np.where(
        (wished & 3 == 3) | (wished >> 2 & 3 == 3) | (wished >> 7 & 3 == 3), 0, wished
    )
    edges = edges_of(wished, ring).reshape(-1, CELL + 1)
    there = np.where((turned != turned[after])[:, None], edges[after, ::-1], edges[after])
    assert np.array_equal(edges, there)


def made(device, surface, **options):
    prepared = dabt.prepare(device, surface, dabt.Params(test="mean", **options))
    run(device, prepared, Frame())
    return prepared


def test_a_cylinder_is_cut_along_its_bend_alone(device):
    surface = bicubic(np.array([0, 1, 1, 0])[:, None] / 2)
    prepared = made(device, surface, level=3, threshold=1e-5)
    wish = Wish.of(prepared.wishes())
    assert (wish.cut == 1).all() and (wish.columns == 0).all()
    assert prepared.live()[1] == 2 * (2**wish.rows).sum()
    flat = made(device, bicubic(0.0), level=3, threshold=1e-9)
    assert flat.live()[1] == 2


def test_a_twisted_patch_is_cut_along_its_valley(device):
    height = np.outer(np.arange(4), np.arange(4)) / 9
    for sign, other in ((1, 0), (-1, 1)):
        x = np.arange(4) / 3
        bowl = 0.2 * ((x - 0.5) ** 2)[:, None] + 0.2 * ((x - 0.5) ** 2)
        surface = bicubic(bowl - sign * 0.1 * height)
        wish = Wish.of(made(device, surface, level=3, threshold=1e-6).wishes())
        assert (wish.cut > 0).all() and (wish.other == other).all()


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
