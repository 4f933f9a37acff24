import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen import catalogue, nurbs
from lodbench.datasets_gen.nurbs_surface import NurbsModel, NurbsSurface
from lodbench.kernels import tessellate_surface
from lodbench.kernels.nurbs.borders import borders_of
from lodbench.kernels.nurbs.tolerance import diagonal, distances, within
from tests.kernels.nurbs.surfaces import models
from tests.kernels.nurbs.test_borders import swapped, turned
from tests.kernels.nurbs.test_uniform_nurbs import MODELS


def counted(samples):
    return [np.bincount(side.spans[:-1]) for side in samples]


def assert_kept(model, tolerance):
    """By a finer measure than that which chose."""
    samples, largest = within(model, borders_of(model), tolerance)
    size = diagonal(model)
    assert largest <= tolerance
    for surface, sides in zip(model.surfaces, samples, strict=True):
        off = distances(surface, counted(sides), parts=7)[0]
        assert off.max() <= tolerance * size
    return samples


GENERATED = {
    "ball": nurbs.ball(),
    "torus": nurbs.torus(),
    "mixed": nurbs.mixed_degrees(),
    "body": nurbs.body(2, 3, (4, 5)),
}


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3])
@pytest.mark.parametrize("name", GENERATED)
def test_tolerance_is_kept(name, tolerance):
    assert_kept(GENERATED[name], tolerance)


@pytest.mark.parametrize("name", MODELS)
def test_tolerance_is_kept_on_real_models(data_folder, name):
    assert_kept(catalogue.load(name).surface.recentred()[0], 3e-3)


@settings(max_examples=10, deadline=None)
@given(models(), st.sampled_from([1e-2, 1e-3]))
def test_tolerance_is_kept_on_any_degrees_knots_and_weights(model, tolerance):
    assert_kept(model, tolerance)


def test_flat_surfaces_take_one_segment_to_a_span():
    x, y = np.meshgrid(np.arange(4.0), np.arange(4.0), indexing="ij")
    knots = [0, 0, 1, 2, 3, 3]
    flat = NurbsModel((NurbsSurface(1, 1, knots, knots, np.stack([x, y, 0 * x], 2)),))
    ((u, v),) = assert_kept(flat, 1e-6)
    assert len(u) == len(v) == 4


def test_a_finer_tolerance_takes_more_by_its_root():
    sizes = [len(assert_kept(nurbs.torus(), tolerance)[0][0]) for tolerance in (1e-2, 1e-4)]
    assert 8 <= sizes[1] / sizes[0] <= 14


def test_borders_have_the_same_samples_on_both_sides(device):
    a, b, c, d = nurbs.quilt(2, 2, 3).surfaces
    rough = turned(b)  # bends more than the others, far from its borders
    points = rough.points.copy()
    points[2:-2, 2:-2, 2] += 0.5
    rough = NurbsSurface(3, 3, rough.knots_u, rough.knots_v, points)
    model = NurbsModel((a, rough, swapped(c), turned(swapped(d))))
    result = tessellate_surface(device, model, tolerance=1e-3)
    assert result.counters["largest_distance"] <= 1e-3
    ends = np.stack([result.mesh.triangles, np.roll(result.mesh.triangles, -1, axis=1)], -1)
    ends = np.sort(ends.reshape(-1, 2).astype(np.int64), axis=1)
    edges, counts = np.unique(ends, axis=0, return_counts=True)
    open_ends = result.mesh.positions[edges[counts == 1]]
    at_rim = np.abs(np.abs(open_ends[..., :2] - 1) - 1) < 1e-6
    assert counts.max() == 2 and at_rim.any(axis=2).all()  # nothing inside is open


def test_tolerance_refuses_what_it_cannot_keep(monkeypatch):
    with pytest.raises(ValueError, match="tolerance: expected 1e-06 to 1, got 0"):
        tessellate_surface(None, nurbs.ball(), tolerance=0)
    monkeypatch.setattr("lodbench.kernels.nurbs.tolerance.MOST_VERTICES", 1000)
    with pytest.raises(
        ValueError, match="tolerance: expected one that at most 1,000 vertices keep"
    ):
        tessellate_surface(None, nurbs.ball(), tolerance=1e-4)
