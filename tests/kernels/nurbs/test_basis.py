"""Basis functions: stair against recursion, in float64 and on the device."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from lodbench.datasets_gen.nurbs_surface import NurbsModel, NurbsSurface
from lodbench.kernels.nurbs.params import BASES
from lodbench.kernels.nurbs.reference import basis, cox_de_boor, stair
from lodbench.kernels.nurbs.samples import by_side, by_span, first_knots, numbers
from lodbench.kernels.nurbs.uniform_nurbs import Params, UniformNurbs
from lodbench.kernels.system import run
from tests.kernels.nurbs.surfaces import random_knots

knot_vectors = st.builds(
    lambda degree, spans, seed: (degree, random_knots(degree, spans, np.random.default_rng(seed))),
    st.integers(1, 7), st.integers(1, 5), st.integers(0, 9999),
)  # fmt: skip


@settings(max_examples=60, deadline=None)
@given(knot_vectors, st.floats(0, 1))
def test_stair_is_the_recursion(curve, x):
    degree, knots = curve
    starts = first_knots(knots)
    span = int(starts[min(np.searchsorted(knots[starts], x, "right") - 1, len(starts) - 1)])
    expected = [cox_de_boor(knots, i, degree, x) for i in range(span - degree, span + 1)]
    got = stair(knots, span, degree, x)
    assert np.abs(got - expected).max() <= 1e-12
    assert got.sum() == pytest.approx(1, abs=1e-12)


@settings(max_examples=60, deadline=None)
@given(knot_vectors, st.integers(1, 9))
def test_reference_is_scipy_with_its_slopes(curve, segments):
    degree, knots = curve
    samples = by_span(knots, segments)
    values, slopes = basis(knots, degree, samples)
    x = numbers(knots, samples)
    count = len(knots) - degree - 1
    spline = BSpline(knots, np.eye(count), degree)
    assert np.abs(values - spline(x)).max() <= 1e-11
    inner = (samples.t > 0) & (samples.t < 1)  # at knots there may be two slopes
    width = np.diff(np.unique(knots))[samples.spans][inner, None]
    got = slopes @ np.diff(np.eye(count), axis=0)
    assert got[inner] == pytest.approx(spline.derivative()(x[inner]) * width, abs=1e-8)


def weights_on_device(device, knots, degree, segments, name):
    """All basis functions at samples as a kernel gives them, (n, p + 1), float32, and each one's first."""
    count = len(knots) - degree - 1
    net = np.zeros((count, 2, 3))
    net[..., 0], net[:, 1, 1] = np.linspace(0, 1, count)[:, None], 1
    surface = NurbsSurface(degree, 1, knots, [0, 0, 1, 1], net)
    level = int(np.log2(segments))
    prepared = UniformNurbs(device, NurbsModel((surface,)), Params(level, "span", basis=name))
    run(device, prepared)
    rows = len(prepared.grids[0].u)
    planes = device.read(prepared.buffers["weights"])
    return planes[: degree + 1, :rows].T, planes[8 : 8 + degree, :rows].T


@pytest.mark.parametrize("name", BASES)
@pytest.mark.parametrize("degree", range(1, 8))
def test_basis_on_the_device_is_that_of_the_reference(device, degree, name):
    for seed in range(3):
        knots = random_knots(degree, 4, np.random.default_rng(seed))
        got, slopes = weights_on_device(device, knots, degree, 8, name)
        samples = by_span(knots, 8)
        values, expected = basis(knots, degree, samples)
        first = first_knots(knots)[samples.spans] - degree
        at = np.arange(len(first))[:, None]
        assert np.abs(got - values[at, first[:, None] + np.arange(degree + 1)]).max() <= 1e-6
        wanted = expected[at, first[:, None] + np.arange(degree)]
        assert np.abs(slopes - wanted).max() <= 1e-5 * max(np.abs(wanted).max(), 1)
        assert np.abs(got.astype(np.float64).sum(axis=1) - 1).max() <= 1e-6
        assert (got >= 0).all()
        # the end belongs to the last span
        assert got[-1].tolist() == [0] * degree + [1]


def test_spans_of_very_uneven_length_lose_nothing(device):
    knots = np.array([0, 0, 0, 0, 1e-9, 1e-6, 0.5, 0.5 + 1e-7, 1, 1, 1, 1])
    got, _ = weights_on_device(device, knots, 3, 8, "stair")
    samples = by_span(knots, 8)
    first = first_knots(knots)[samples.spans] - 3
    values = basis(knots, 3, samples)[0]
    at = np.arange(len(first))[:, None]
    assert np.abs(got - values[at, first[:, None] + np.arange(4)]).max() <= 1e-6


def test_samples_of_a_side_stand_at_its_creases():
    knots = np.array([0, 0, 0, 0.3, 0.3, 0.31, 0.31, 0.7, 1, 1, 1])
    samples = by_side(knots, 2, 8)
    x = numbers(knots, samples)
    assert len(x) == 9 and (np.diff(x) > 0).all()
    assert x[0] == 0 and x[-1] == 1 and samples.t[-1] == 1
    assert {0.3, 0.31} <= set(x.tolist()) and 0.7 not in x
    assert len(by_side(knots, 2, 1)) == 2
