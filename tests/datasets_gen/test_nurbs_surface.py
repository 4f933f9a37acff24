import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from lodbench.datasets_gen import nurbs
from lodbench.datasets_gen.nurbs_surface import NurbsModel, NurbsSurface, cut

FLAT = np.stack(np.meshgrid(np.arange(4.0), np.arange(3.0), [0.0], indexing="ij"), -1)[:, :, 0]
GOOD = {
    "degree_u": 3, "degree_v": 2, "knots_u": [0, 0, 0, 0, 1, 1, 1, 1], "knots_v": [0, 0, 0, 1, 1, 1],
    "points": FLAT, "weights": np.ones((4, 3)),
}  # fmt: skip


@st.composite
def curves(draw):
    """Degree, knots that may repeat and need not be clamped, control points (n, 2)."""
    degree = draw(st.integers(1, 7))
    count = degree + 1 + draw(st.integers(0, 6))
    steps = draw(st.lists(st.integers(0, 3), min_size=count + degree, max_size=count + degree))
    knots = np.concatenate([[0.0], np.cumsum(steps)])
    knots[-1] = max(knots[-1], knots[0] + 1)
    inner = knots[degree : count + 1]
    repeated = np.unique(inner[1:-1], return_counts=True)[1]
    seed = draw(st.integers(0, 1000))
    usable = inner[0] < inner[-1] and repeated.max(initial=0) <= degree
    return degree, knots, np.random.default_rng(seed).normal(size=(count, 2)), usable


@settings(max_examples=150, deadline=None)
@given(curves(), st.floats(0, 0.4), st.floats(0.6, 1))
def test_cut_leaves_the_curve_as_it_is(curve, first, last):
    degree, knots, points, usable = curve
    if not usable:
        return
    count = len(points)
    low, high = knots[degree], knots[count]
    low, high = low + first * (high - low), low + last * (high - low)
    made, rows = cut(knots, points, degree, low, high)
    assert len(made) == len(rows) + degree + 1
    assert (made[: degree + 1] == low).all() and (made[-degree - 1 :] == high).all()
    inside = low + (high - low) * np.linspace(0.001, 0.999, 23)
    expected, got = BSpline(knots, points, degree)(inside), BSpline(made, rows, degree)(inside)
    assert got == pytest.approx(expected, abs=1e-9)
    assert rows[0] == pytest.approx(BSpline(knots, points, degree)(low), abs=1e-9)


def test_unclamped_surface_becomes_clamped_and_stays_the_same():
    random = np.random.default_rng(3)
    points, weights = random.normal(size=(7, 6, 3)), random.uniform(0.5, 2, (7, 6))
    knots_u, knots_v = np.arange(11.0), np.sort(random.uniform(0, 9, 9))
    surface = NurbsSurface(3, 2, knots_u, knots_v, points, weights)
    assert surface.knots_u.tolist() == [3, 3, 3, 3, 4, 5, 6, 7, 7, 7, 7]
    t = np.linspace(0.01, 0.99, 9)

    def sample(ku, kv, P, W):
        u, v = ku[3] + t * (ku[-4] - ku[3]), kv[2] + t * (kv[-3] - kv[2])
        Pw = np.concatenate([P * W[..., None], W[..., None]], 2)
        rows = BSpline(ku, Pw, 3)(u)
        found = BSpline(kv, rows.transpose(1, 0, 2), 2)(v)
        return found[..., :3] / found[..., 3:]

    expected = sample(knots_u, knots_v, points, weights)
    got = sample(surface.knots_u, surface.knots_v, surface.points, surface.weights)
    assert got == pytest.approx(expected, abs=1e-11)


def test_part_of_a_surface_keeps_its_shape_and_its_range():
    whole = nurbs.ball().surfaces[0]
    part = whole.within(0.5, 3.25, -9.0, 1.5)
    assert (part.knots_u[0], part.knots_u[-1], part.knots_v[0], part.knots_v[-1]) == (
        0.5,
        3.25,
        0,
        1.5,
    )
    corners = part.points[[0, 0, -1, -1], [0, -1, 0, -1]]
    assert np.linalg.norm(corners, axis=1) == pytest.approx(1)
    with pytest.raises(ValueError, match="range: expected low below high"):
        whole.within(3, 3, 0, 1)


def test_knots_parted_by_roundings_are_one():
    surface = NurbsSurface(**GOOD | {"knots_v": [0, 1e-17, 0, 1, 1 - 1e-17, 1]})
    assert surface.span_count == 1


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"degree_u": 0}, "degree_u: expected 1 to 7, got 0"),
        ({"degree_u": 8}, "degree_u: expected 1 to 7, got 8"),
        ({"degree_u": 3.0}, "degree_u: expected a whole number"),
        ({"degree_v": 4}, "points: expected more than 4 along v"),
        ({"knots_v": [0, 0, 0, 1, 1]}, "knots_v: expected 6 knots for 3 points of degree 2, got 5"),
        ({"knots_v": [0, 0, 1, 0.5, 1, 1]}, "knots_v: expected knots that do not fall, got 1 before 0.5"),
        ({"knots_v": [0, 0, 0, 0, 0, 0]}, "knots_v: expected a range that is not empty"),
        ({"knots_v": [0, 0, 0, np.nan, 1, 1]}, "knots_v: expected finite numbers"),
        ({"knots_u": ["a"]}, "knots_u: expected numbers"),
        ({"weights": np.ones((3, 4))}, r"weights: expected shape \(4, 3\)"),
        ({"weights": np.zeros((4, 3))}, "weights: expected positive numbers, got 0"),
        ({"weights": np.full((4, 3), np.inf)}, "weights: expected finite"),
        ({"points": FLAT * np.nan}, "points: expected finite"),
        ({"points": FLAT[..., :2]}, r"points: expected \(n_u, n_v, 3\)"),
        ({"points": [[1, 2], [3]]}, "points: expected numbers in rows of one length"),
    ],
)  # fmt: skip
def test_wrong_surface_is_refused_by_name(change, text):
    with pytest.raises((ValueError, TypeError), match=text):
        NurbsSurface(**GOOD | change)


def test_inner_knots_at_which_a_surface_tears_are_refused():
    knots = [0, 0, 0, 1, 1, 1, 2, 2, 2]
    points = np.zeros((4, 6, 3))
    with pytest.raises(
        ValueError, match=r"knots_v: expected an inner knot at most 2 times, .* got 1 3 times"
    ):
        NurbsSurface(**GOOD | {"points": points, "weights": None, "knots_v": knots})


def test_model_names_its_surfaces_and_knows_its_box():
    (ball,) = nurbs.ball().surfaces
    model = NurbsModel((ball, ball, ball), ("a", "a", ""))
    assert model.names == ("a", "a_1", "surface_2")
    assert model.diagonal == pytest.approx(np.sqrt(12))
    with pytest.raises(ValueError, match="names: expected 3"):
        dataclasses.replace(model, names=("a",))
    assert NurbsModel(()).diagonal == 0
    far = NurbsModel((dataclasses.replace(ball, points=ball.points + 1e6),))
    near, origin = far.recentred()
    assert np.abs(near.surfaces[0].points).max() < 2 and origin.tolist() == [1e6] * 3
    assert model.recentred() == (model, None)
