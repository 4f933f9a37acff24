import numpy as np
import pytest

from lodbench.kernels.stages import raster_reference
from tests.kernels.common.calling import Caller
from tests.tolerances import ROUNDING32

GUARD = float(raster_reference.GUARD)
MOST = 9  # corners, as CLIP_CORNERS


@pytest.fixture(scope="module")
def call(device, tmp_path_factory):
    return Caller(device, tmp_path_factory.mktemp("kernels"), "common/clip.cl")


def clipped(call, triangles):
    """Of (n, 3, 4) corners the polygons that are left, each (corners, 4)."""
    n = len(triangles)
    found = call(
        """float4 corners[CLIP_CORNERS];
    for (int k = 0; k < 3; ++k) corners[k] = vload4(3 * i + k, triangles);
    counts[i] = clip_polygon(corners);
    for (int k = 0; k < counts[i]; ++k) vstore4(corners[k], CLIP_CORNERS * i + k, out);""",
        n,
        {"counts": (n, np.int32), "out": (n * MOST * 4, np.float32)},
        triangles=triangles.astype(np.float32),
    )
    rows = found["out"].reshape(n, MOST, 4)
    return [row[:count] for row, count in zip(rows, found["counts"], strict=True)]


def crossing(count=200):
    """Triangles before the eye, of which many cross the near plane or the guard band; x and y are times w."""
    rng = np.random.default_rng(0)
    w = rng.uniform(0.5, 4, (count, 3, 1))
    xy = rng.normal(0, 1.2 * GUARD, (count, 3, 2)) * w
    z = rng.uniform(-0.5, 1, (count, 3, 1))
    return np.concatenate([xy, z, w], axis=2).astype(np.float32)


def test_triangles_are_cut_as_the_reference_cuts_them(call):
    triangles = crossing()
    sizes = set()
    for triangle, polygon in zip(triangles, clipped(call, triangles), strict=True):
        expected = np.array(raster_reference.clip(list(triangle))).reshape(-1, 4)
        assert len(polygon) == len(expected)
        scale = np.abs(triangle).max(axis=0)
        assert (np.abs(polygon - expected) <= ROUNDING32 * scale).all()
        sizes.add(len(polygon))
    assert {0, 3, 4, 5} <= sizes


def test_what_is_left_lies_within_the_planes(call):
    for polygon in clipped(call, crossing()):
        slack = 4 * ROUNDING32 * GUARD * polygon[:, 3:].max(initial=1)
        assert (np.abs(polygon[:, :2]) <= GUARD * polygon[:, 3:] + slack).all()
        assert (polygon[:, 2] >= -ROUNDING32).all()


def test_triangle_within_the_planes_comes_back_as_it_was(call):
    inside = np.array([[[0, 0, 0, 1], [9, -5, 0.5, 2], [-GUARD, GUARD, 1, 1]]], np.float32)
    (polygon,) = clipped(call, inside)
    np.testing.assert_array_equal(polygon, inside[0])


def test_triangles_that_share_an_edge_get_the_same_corners_on_it(call):
    a, b = np.array([0, 0, 0.5, 1]), np.array([3 * GUARD, 77, -0.3, 1.7])
    pair = np.array([[a, b, [0, 9, 0.2, 1]], [b, a, [0, -9, 0.2, 1]]])
    one, other = clipped(call, pair)
    on_edge = [
        {row.tobytes() for row in polygon if row[0] > 0 and row[2] >= 0} for polygon in (one, other)
    ]
    assert on_edge[0] & on_edge[1], "the edge's own cut is in both, to the bit"


@pytest.mark.parametrize("odd", [np.nan, np.inf])
def test_corner_that_is_not_a_number_leaves_nothing(call, odd):
    for place in range(3):
        triangle = np.array([[[0, 0, 0.5, 1], [9, 0, 0.5, 1], [0, 9, 0.5, 1]]])
        triangle[0, place, 3] = odd
        (polygon,) = clipped(call, triangle)
        assert len(polygon) == 0


def test_corners_are_transformed_and_stored_as_the_vertex_stage_does(call):
    rng = np.random.default_rng(1)
    points, m = rng.normal(size=(64, 3)).astype(np.float32), rng.normal(size=16).astype(np.float32)
    m[12:] = 0, 0, 0.1, 2  # w stays positive
    m[:8] *= 1000
    found = call(
        """const float4 corner = screen_transform(vload3(i, points), vload16(0, m));
    vstore4(corner, i, out);
    vstore4(clip_corner(corner), i, stored);""",
        64,
        {"out": (256, np.float32), "stored": (256, np.int32)},
        points=points,
        m=m,
    )
    corners = found["out"].reshape(-1, 4)
    full = points.astype(float) @ m.reshape(4, 4)[:, :3].T.astype(float) + m.reshape(4, 4)[:, 3]
    scale = np.abs(m.reshape(4, 4)).sum(axis=1) * np.abs(points).max()
    assert (np.abs(corners - full) <= ROUNDING32 * scale).all()
    stored = found["stored"].reshape(-1, 4)
    for corner, row in zip(corners, stored, strict=True):
        x, y, z = raster_reference.place(corner)
        assert abs(row[0] - x) <= 1 and abs(row[1] - y) <= 1, "a quotient may round either way"
        depth, inverse = row[2:].view(np.float32)
        assert abs(depth - z) <= ROUNDING32 * abs(z) and depth >= 0
        assert abs(inverse * corner[3] - 1) <= ROUNDING32
