import numpy as np
import pytest

from lodbench.datasets_gen import nurbs
from lodbench.datasets_gen.nurbs_surface import NurbsModel
from lodbench.harness.baselines.nurbs_as_bezier import SYSTEM, Params, bezier_patches
from lodbench.kernels.nurbs.reference import points_at
from lodbench.kernels.nurbs.samples import by_span
from lodbench.kernels.system import Unsupported, run
from tests.kernels.nurbs.surfaces import random_surface


def test_patches_are_the_surface_with_repeated_knots_and_uneven_spans(device):
    surfaces = tuple(random_surface((3, 3), (k, 5 - k), k, rational=False) for k in (1, 2, 4))
    for surface in surfaces:
        patches = bezier_patches(surface)
        u, v = by_span(surface.knots_u, 1), by_span(surface.knots_v, 1)
        corners = points_at(surface, u, v)
        assert patches[:, :, 0, 0] == pytest.approx(corners[:-1, :-1], abs=1e-12)
        assert patches[:, :, 3, 3] == pytest.approx(corners[1:, 1:], abs=1e-12)
        assert patches.shape[:2] == (len(u) - 1, len(v) - 1)
    prepared = SYSTEM.prepare(device, NurbsModel(surfaces), Params(2))
    run(device, prepared)
    assert prepared.check().passed, prepared.check()
    assert prepared.counters()["quads"] == prepared.counters()["patches"]


def test_check_sees_patches_that_are_not_the_surface(device):
    prepared = SYSTEM.prepare(device, nurbs.quilt(1, 2, 2), Params(1))
    prepared._model = nurbs.quilt(1, 2, 2, seed=1)
    run(device, prepared)
    assert not prepared.check().passed


@pytest.mark.parametrize("model", [nurbs.ball(), nurbs.mixed_degrees()])
def test_other_degrees_and_weights_are_unsupported_in_a_line(device, model):
    with pytest.raises(
        Unsupported, match=r"needs bicubic surfaces that are not rational, has one of \d x \d"
    ):
        SYSTEM.prepare(device, model, Params(1))


def test_no_surfaces_are_no_patches(device):
    prepared = SYSTEM.prepare(device, NurbsModel(()), Params(1))
    run(device, prepared)
    assert prepared.result()[0].triangle_count == 0 and prepared.check().passed
    assert np.isfinite(prepared.check().value)
