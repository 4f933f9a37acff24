import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen import catalogue, nurbs
from lodbench.datasets_gen.nurbs_surface import NurbsModel
from lodbench.harness.measure.exact_views import around
from lodbench.kernels.nurbs.rpns import Params, Rpns
from lodbench.kernels.nurbs.rpns.params import CULLING
from lodbench.kernels.nurbs.rpns.reference import beside, faces_away, facing, visible
from lodbench.kernels.nurbs.uniform_nurbs import Params as UniformParams
from lodbench.kernels.nurbs.uniform_nurbs import UniformNurbs
from lodbench.kernels.stages.camera import fit_box, look_at
from lodbench.kernels.system import Frame, run
from tests.kernels.nurbs.surfaces import models
from tests.kernels.nurbs.test_uniform_nurbs import MODELS

BODY = nurbs.body(3, 4, (5, 6))


def culled(device, model, view, culling, level=0):
    prepared = Rpns(device, model, Params(level, culling=culling))
    run(device, prepared, Frame(view))
    return prepared


@pytest.mark.parametrize("culling", ["strong", "light"])
def test_culling_by_control_nets_is_that_of_the_reference(device, culling):
    for model in (BODY, nurbs.torus(), nurbs.mixed_degrees(), nurbs.cylinder()):
        for view in around(model):
            prepared = culled(device, model, view, culling)
            away = [
                (faces_away(s, view.eye, culling == "light") | beside(s, view)).ravel()
                for s in model.surfaces
            ]
            differ = np.concatenate(away) != ~prepared.kept()
            assert differ.sum() <= 0.01 * len(differ)  # control quads that are seen edge on


def test_certified_culling_loses_nothing_and_leaves_little(device):
    gone = there = 0
    for view in around(BODY, 8):
        prepared = culled(device, BODY, view, "certified")
        seen = visible(BODY, view)
        assert prepared.lost()[1] == 0 and prepared.check().passed
        gone, there = gone + prepared.lost()[0], there + int((seen == 0).sum())
    assert gone >= 0.9 * there > 0


@settings(max_examples=25, deadline=None)
@given(models(), st.integers(0, 9999), st.floats(0.2, 5))
def test_certified_culling_loses_nothing_of_any_surface(device, model, seed, far):
    way = np.random.default_rng(seed).normal(size=3)
    low, high = model.box
    view = look_at((low + high) / 2 + way * far, (low + high) / 2)
    kept = culled(device, model, view, "certified").kept()
    seen = [facing(s, view, samples=16).ravel() for s in model.surfaces]
    assert not (np.concatenate(seen)[~kept] > 0).any()


def test_certified_culling_loses_nothing_of_ten_thousand_random_spans(device):
    model, culled_spans = nurbs.random_spans(), 0
    prepared = Rpns(device, model, Params(0, normals=False))
    for view in around(model, 4):
        run(device, prepared, Frame(view))
        culled_quads, wrong, share = prepared.lost()
        culled_spans += culled_quads
        assert (wrong, share) == (0, 0.0)
    assert model.span_count == 10_000 and culled_spans > 4_000


@pytest.mark.parametrize("name", MODELS)
def test_certified_culling_loses_nothing_of_real_models(device, data_folder, name):
    model = catalogue.load(name).surface.recentred()[0]
    for view in around(model, 1):
        assert culled(device, model, view, "certified").lost()[1] == 0


@pytest.mark.parametrize("culling", CULLING)
def test_triangles_are_those_of_the_quads_that_stay(device, culling):
    view = fit_box(*BODY.box)
    prepared = culled(device, BODY, view, culling, level=1)
    (mesh,) = prepared.result()
    (whole,) = culled(device, BODY, None, culling, level=1).result()
    kept = prepared.kept()
    assert mesh.triangle_count == 8 * kept.sum() and whole.triangle_count == 8 * len(kept)
    corners = mesh.positions.reshape(-1, 9, 3)
    assert np.array_equal(corners, whole.positions.reshape(-1, 9, 3)[kept])
    expected = mesh.triangles[:8] + 9 * np.arange(kept.sum(), dtype=np.uint32)[:, None, None]
    assert np.array_equal(mesh.triangles.reshape(-1, 8, 3), expected)
    counters = prepared.counters()
    assert counters["quads_kept"] + counters["quads_culled"] == counters["quads"] == 12 * 30
    assert (counters["quads_culled"] > 0) == (culling != "none")


def test_without_a_view_all_stay_and_are_the_surfaces_of_uniform_tessellation(device):
    model = nurbs.quilt(1, 2, 3)
    made = culled(device, model, None, "certified", level=2).welded()
    uniform = UniformNurbs(device, model, UniformParams(2, "span"))
    run(device, uniform)
    expected = uniform.welded()
    assert (made.vertex_count, made.triangle_count) == (
        expected.vertex_count, expected.triangle_count,
    )  # fmt: skip
    order = [np.lexsort(np.round(m.positions, 4).T) for m in (made, expected)]
    off = made.positions[order[0]] - expected.positions[order[1]]
    assert np.abs(off).max() <= 4e-7
    turned = made.normals[order[0]] - expected.normals[order[1]]
    assert np.linalg.norm(turned, axis=1).max() <= 1e-5


def test_a_plane_is_seen_from_one_side_alone(device):
    model = NurbsModel(nurbs.quilt(1, 1, 2).surfaces)
    flat = nurbs.NurbsSurface(
        3, 3, model.surfaces[0].knots_u, model.surfaces[0].knots_v,
        model.surfaces[0].points * (1, 1, 0),
    )  # fmt: skip
    for height, kept in ((2, 4), (-2, 0)):
        view = look_at((0.5, 0.5, height), (0.5, 0.5, 0), up=(0, 1, 0))
        for culling in ("strong", "light", "certified"):
            assert culled(device, NurbsModel((flat,)), view, culling).kept().sum() == kept
