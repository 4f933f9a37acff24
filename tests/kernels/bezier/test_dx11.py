import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen import patches
from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels.bezier import borders
from lodbench.kernels.bezier.dx11 import Dx11, Params
from lodbench.kernels.bezier.dx11.reference import cut, place, snapped
from lodbench.kernels.bezier.vst import Params as VstParams
from lodbench.kernels.bezier.vst import Vst
from lodbench.kernels.system import run
from tests.kernels.bezier.patches import NASTY, sheets

SPACINGS = ("integer", "odd", "even")


def made(device, surface, **params):
    prepared = Dx11(device, surface, Params(**params))
    run(device, prepared)
    check = prepared.check()
    assert check.passed, check
    return prepared, prepared.result()[0]


@pytest.mark.parametrize(
    ("factor", "spacing", "segments"),
    [
        (1, "integer", 1), (2.1, "integer", 3), (1, "odd", 1), (1.5, "odd", 3), (4.0, "odd", 5), (5.0, "odd", 5),
        (1, "even", 2), (2.1, "even", 4), (4.0, "even", 4), (4.1, "even", 6),
    ],
)  # fmt: skip
def test_dx11_segments_are_those_of_the_specification(factor, spacing, segments):
    used, found = cut(np.array(factor), spacing)
    assert found == segments
    ends = place(np.arange(segments + 1), float(used), segments)
    lengths = np.diff(ends)
    assert ends[0] == 0 and ends[-1] == 1 and (lengths > -1e-12).all()
    assert np.allclose(ends, 1 - ends[::-1])
    assert np.allclose(lengths[1:-1], 1 / used)  # n - 2 of equal length, two shorter
    assert lengths[0] <= 1 / used + 1e-12


@given(st.integers(1, 64), st.integers(1, 64))
def test_dx11_inside_comes_to_every_vertex_of_an_edge_in_order(segments, own):
    own = min(own, segments)
    found = snapped(segments, own)
    assert found[0] == 0 and found[-1] == own
    assert (np.diff(found) >= 0).all() and set(found) == set(range(own + 1))


@pytest.mark.parametrize("level", [0, 2, 4])
def test_dx11_with_whole_factors_is_the_map_of_vst(device, level):
    surface = patches.cup()
    _, mesh = made(device, surface, level=level)
    vst = Vst(device, surface, VstParams(level))
    run(device, vst)
    (expected,) = vst.result()
    assert np.array_equal(mesh.triangles, expected.triangles)
    size = np.ptp(mesh.positions)
    assert np.abs(mesh.positions - expected.positions).max() <= 1e-6 * size


@settings(max_examples=15, deadline=None)
@given(sheets, st.sampled_from(SPACINGS), st.floats(1, 9), st.sampled_from(["uniform", "length"]))
def test_dx11_neighbours_agree_to_the_bit_along_every_border(
    device, surface, spacing, factor, edges
):
    prepared, mesh = made(device, surface, factor=factor, spacing=spacing, edges=edges)
    side = prepared.counters()["segments"] + 1
    grid = mesh.positions.reshape(-1, side, side, 3)
    sides = np.stack([grid[:, 0], grid[:, -1], grid[:, :, 0], grid[:, :, -1]], axis=1)
    found = borders.borders_of(surface.points)
    for patch in range(len(grid)):
        for edge in range(4):
            other, other_edge = divmod(int(found.owner[patch, edge]), 4)
            here = {p.tobytes() for p in sides[patch, edge]}
            assert here == {p.tobytes() for p in sides[other, other_edge]}


def test_dx11_edges_by_length_have_fewer_segments_where_they_are_short(device):
    prepared, mesh = made(device, patches.cup(), factor=8.0, edges="length")
    uniform, _ = made(device, patches.cup(), factor=8.0)
    assert prepared.counters()["least_segments"] == 1 < uniform.counters()["least_segments"] == 8
    assert (
        prepared.counters()["triangles"] == uniform.counters()["triangles"] == mesh.triangle_count
    )


def test_dx11_vertices_move_smoothly_as_the_factor_grows(device):
    surface = patches.cup()
    before = made(device, surface, factor=4.999, spacing="odd")[1].positions
    after = made(device, surface, factor=5.0, spacing="odd")[1].positions
    assert np.abs(before - after).max() < 1e-3


@pytest.mark.parametrize("spacing", SPACINGS)
@pytest.mark.parametrize("name", NASTY)
def test_dx11_bears_nasty_patches(device, name, spacing):
    _, mesh = made(device, BezierPatches(NASTY[name]), factor=3.5, spacing=spacing, edges="length")
    assert np.isfinite(mesh.positions).all()


def test_dx11_refuses_factors_that_are_none():
    with pytest.raises(ValueError, match="factor: expected"):
        Params(factor=0.5)
    with pytest.raises(ValueError, match="spacing: expected one of integer, odd, even"):
        Params(spacing="fractional")
