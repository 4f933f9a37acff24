import numpy as np
import pytest

from tests.kernels.common.calling import Caller
from tests.tolerances import QUADRIC_STEP, ROUNDING32

NAMES = ("xx", "xy", "xz", "yy", "yz", "zz", "x", "y", "z")


@pytest.fixture(scope="module")
def call(device, tmp_path_factory):
    return Caller(device, tmp_path_factory.mktemp("kernels"), "common/quadric.cl")


def step(call, A, b, ridge):
    """The steps (n, 3) and determinants (n,) of n quadrics, n a multiple of 8."""
    entries = [A[:, 0, 0], A[:, 0, 1], A[:, 0, 2], A[:, 1, 1], A[:, 1, 2], A[:, 2, 2], *b.T]
    found = call(
        "const quadric8 q = {"
        + ", ".join(f"vload8(i, {name}_)" for name in NAMES)
        + """};
    float8 d;
    const quadric_point8 s = quadric_step8(q, vload8(i, ridge), &d);
    vstore8(s.x, i, sx); vstore8(s.y, i, sy); vstore8(s.z, i, sz); vstore8(d, i, determinant);""",
        len(A) // 8,
        {name: (len(A), np.float32) for name in ("sx", "sy", "sz", "determinant")},
        ridge=ridge,
        **{f"{name}_": entry for name, entry in zip(NAMES, entries, strict=True)},
    )
    return np.stack([found["sx"], found["sy"], found["sz"]], axis=1), found["determinant"]


def test_step_solves_the_regularised_system(call):
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(64, 6, 3))
    A = np.einsum("nki,nkj->nij", normals, normals).astype(np.float32)
    b = rng.normal(size=(64, 3)).astype(np.float32)
    ridge = np.repeat(np.float32([0, 1e-3, 1e-1, 1]), 16)
    found, determinant = step(call, A, b, ridge)
    full = A.astype(float) + ridge[:, None, None] * np.eye(3)
    expected = -np.linalg.solve(full, b.astype(float)[..., None])[..., 0]
    spread = np.linalg.cond(full)
    apart = np.linalg.norm(found - expected, axis=1) / np.linalg.norm(expected, axis=1)
    assert (apart <= QUADRIC_STEP * spread).all()
    scale = np.abs(determinant / np.linalg.det(full) - 1)
    assert (scale <= QUADRIC_STEP * spread).all()


def test_ridge_gives_a_plane_its_nearest_point(call):
    direction = np.array([2, -1, 2]) / 3
    A = np.tile(np.outer(direction, direction), (8, 1, 1)).astype(np.float32)
    distance = np.linspace(-2, 2, 8)
    b = (-distance[:, None] * direction).astype(np.float32)
    found, _ = step(call, A, b, np.full(8, 1e-3, np.float32))
    expected = distance[:, None] * direction / 1.001
    assert np.abs(found - expected).max() < 1e3 * ROUNDING32, "the ridge divides roundings by 1e-3"


def test_step_is_short_within_its_limit_and_never_where_it_went_wrong(call):
    x = np.array([0, 1, 2.999, 3.001, np.nan, np.inf, -2, -4], np.float32)
    found = call(
        """const quadric_point8 s = {vload8(0, x), (float8)(0.0f), (float8)(0.0f)}, t = {s.y, s.z, s.x};
    vstore8(quadric_short8(s, 3.0f), 0, first);
    vstore8(quadric_short8(t, 3.0f), 0, second);""",
        1,
        {"first": (8, np.int32), "second": (8, np.int32)},
        x=x,
    )
    for mask in found.values():
        assert mask.tolist() == [-1, -1, -1, 0, 0, 0, -1, 0]


def test_all_lanes_are_asked(call):
    masks = -np.ones((9, 8), np.int32)
    masks[np.arange(8), np.arange(8)] = 0
    found = call("out[i] = quadric_all8(vload8(i, masks));", 9, {"out": (9, np.int32)}, masks=masks)
    assert found["out"].tolist() == [0] * 8 + [-1]
