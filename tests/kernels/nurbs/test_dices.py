"""The sampler of rpns: KSDices by the screen, borders without cracks, room that grows."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from lodbench.datasets_gen import catalogue, nurbs
from lodbench.datasets_gen.nurbs_surface import NurbsModel
from lodbench.harness.measure.exact_bezier import open_edges
from lodbench.harness.measure.exact_views import (
    around,
    border_pixels,
    holes_at,
    shared_curves,
)
from lodbench.kernels import tessellate_surface
from lodbench.kernels.nurbs.rpns import Params, Rpns
from lodbench.kernels.nurbs.rpns.reference import visible
from lodbench.kernels.nurbs.rpns.sampling import lengths, segments
from lodbench.kernels.nurbs.tolerance import diagonal
from lodbench.kernels.stages.camera import fit_box, look_at, moved
from lodbench.kernels.stages.raster import Raster
from lodbench.kernels.stages.shading import Shading
from lodbench.kernels.system import Frame, run
from tests.kernels.nurbs.surfaces import models

BODY, TORUS = nurbs.body(2, 3, (4, 5)), nurbs.torus()
CLOSED = {"body": BODY, "torus": TORUS, "ball": nurbs.ball()}
SIZE = (240, 200)
AREAS = (1.0, 8.0, 16.0)
FINE = Params(6, culling="none", sampling="adaptive", pixel_area=0.2)


def made(device, model, view, **options):
    given = {"sampling": "adaptive", "level": 6, "culling": "none"} | options
    prepared = Rpns(device, model, Params(**given))
    run(device, prepared, Frame(view))
    return prepared


def small(view):
    """The same view in a small image."""
    return type(view)(view.eye, view.world_to_clip, *SIZE)


@pytest.mark.parametrize("sampling", ["adaptive", "non_uniform", "level", "one"])
@pytest.mark.parametrize("name", CLOSED)
def test_closed_models_have_no_open_edge_in_any_view(device, name, sampling):
    for view in around(CLOSED[name], 2):
        level = {"level": 2}.get(sampling, 6)
        prepared = made(device, CLOSED[name], view, sampling=sampling, level=level)
        assert not len(open_edges(prepared.result()[0]))
        assert not len(open_edges(prepared.welded()))
        assert prepared.check().passed


@pytest.mark.parametrize("area", AREAS)
def test_closed_models_are_drawn_without_a_hole(device, area):
    """Each pixel is covered as often by what faces the eye as by what faces away."""
    for model in (BODY, TORUS):
        for view in map(small, around(model, 2)):
            prepared, covered = made(device, model, view, pixel_area=area), []
            for cull in (False, True):
                raster = Raster(
                    device, prepared.output, *SIZE, Shading(cull=cull), view=view, count=True
                )
                run(device, prepared, Frame(view), raster)
                covered.append(raster.coverage())
            if (prepared.sampled().segments < 64).all():  # nothing is behind the eye
                assert covered[0].max() >= 2 and np.array_equal(covered[0], 2 * covered[1])


@pytest.mark.parametrize("area", AREAS)
def test_no_background_shows_between_surfaces_that_share_borders(device, area):
    model = nurbs.quilt(2, 2, 3)
    prepared, looked_at = made(device, model, None, pixel_area=area), 0
    for view, places in border_pixels(device, model, Rpns, FINE, 5, SIZE):
        assert holes_at(device, prepared, view, places) == 0
        looked_at += len(places)
    assert looked_at > 50


@pytest.mark.parametrize("area", AREAS)
def test_no_background_shows_between_surfaces_of_the_killeroo(device, data_folder, area):
    """All surfaces, five views."""
    model = catalogue.load("killeroo").surface
    prepared, looked_at = made(device, model, None, pixel_area=area), 0
    for view, places in border_pixels(device, model, Rpns, FINE, 5, SIZE):
        assert holes_at(device, prepared, view, places) == 0
        looked_at += len(places)
    assert looked_at > 50  # pixels on shared borders


def test_the_killeroo_is_open_where_its_surfaces_share_nothing(device, data_folder):
    model = catalogue.load("killeroo").surface.recentred()[0]
    _, alone = shared_curves(model)
    mesh = made(device, model, fit_box(*model.box)).result()[0]
    middles = open_edges(mesh).mean(axis=1)
    assert len(middles) and cKDTree(alone).query(middles)[0].max() <= 5e-3 * diagonal(model)


@settings(max_examples=4, deadline=None)
@given(models(), st.integers(0, 9999), st.sampled_from(["adaptive", "non_uniform"]))
def test_random_surfaces_are_cut_where_float64_says(device, model, seed, sampling):
    way = np.random.default_rng(seed).normal(size=3)
    low, high = model.box
    view = small(look_at((low + high) / 2 + 3 * way / np.linalg.norm(way), (low + high) / 2))
    prepared = made(
        device, model, view, sampling=sampling, culling="certified", dice_culling=True, level=5
    )
    assert prepared.check().passed
    again = made(
        device, model, view, sampling=sampling, culling="certified", dice_culling=True, level=5
    )
    assert again.result()[0].positions.tobytes() == prepared.result()[0].positions.tobytes()


@pytest.mark.parametrize("model", [BODY, TORUS, nurbs.mixed_degrees()])
def test_as_many_segments_as_lengths_on_the_screen_ask_for(device, model):
    for view in around(model, 3):
        params = Params(6, sampling="adaptive", culling="none", edges="tolerant")
        prepared = made(device, model, view, edges="tolerant")
        found, first = prepared.sampled().segments, 0
        for surface in model.surfaces:
            wanted = segments(surface, view, params)
            count = wanted.shape[0] * wanted.shape[1]
            border = np.ones(wanted.shape[:2], bool)
            border[1:-1, 1:-1] = False
            wanted = wanted * np.where(border, 2, 1)[..., None]
            own = found[first : first + count].reshape(wanted.shape)
            exact = np.stack([n.max(axis=2) for n in lengths(surface, view)], axis=2) / 8**0.5
            sure = np.abs(exact - np.round(exact)) > 1e-3 * np.maximum(exact, 1)
            assert np.array_equal(own[sure], wanted[sure])
            first += count


def test_dices_cover_no_more_than_they_may(device):
    view = fit_box(*BODY.box)
    for area in AREAS:
        prepared = made(device, BODY, view, pixel_area=area, level=8)
        (mesh,) = prepared.result()
        clip = np.column_stack([mesh.positions, np.ones(mesh.vertex_count)]) @ view.world_to_clip.T
        at = clip[:, :2] / clip[:, 3:] * (view.width / 2, view.height / 2)
        a, b, c = (at[mesh.triangles[:, k]] for k in range(3))
        (x, y), (z, w) = (b - a).T, (c - a).T
        sizes = np.abs(x * w - y * z) / 2
        assert 0.1 * area <= np.median(2 * sizes[sizes > 0]) <= area
        assert np.quantile(2 * sizes, 0.95) <= 1.5 * area


def test_dice_culling_leaves_out_what_the_raster_would(device):
    for view in map(small, around(BODY, 3)):
        images, counts = [], []
        for dices in (False, True):
            prepared = made(device, BODY, view, dice_culling=dices)
            raster = Raster(device, prepared.output, *SIZE, Shading(cull=True), view=view)
            run(device, prepared, Frame(view), raster)
            images.append(raster.keys()[0])
            counts.append(prepared.counters()["triangles"])
        assert counts[1] < 0.8 * counts[0]
        assert (images[0] != images[1]).mean() <= 1e-3  # dices that are seen edge on


def test_frames_that_overflow_grow_and_then_fit(device):
    far, close = (look_at((0, 0, d), (0, 0, 0), up=(0, 1, 0)) for d in (6, 1.5))
    prepared = made(device, TORUS, far, level=7)
    before = prepared.output[0].vertex_count
    run(device, prepared, Frame(close))
    assert prepared.output[0].vertex_count > before and not prepared.overflowed()
    assert prepared.check().passed
    expected = made(device, TORUS, close, level=7)
    assert np.array_equal(prepared.result()[0].positions, expected.result()[0].positions)
    run(device, prepared, Frame(far))
    again = made(device, TORUS, far, level=7)
    assert np.array_equal(prepared.result()[0].triangles, again.result()[0].triangles)


def test_what_lies_beside_the_image_is_culled_and_nothing_seen_is(device):
    for target in ((1, 0.3, 0), (-1, 0.5, 0.2)):  # from within the ring
        view = small(look_at((0, 0, 0.2), target))
        seen = visible(BODY, view)
        for culling in ("strong", "light", "certified"):
            prepared = made(device, BODY, view, culling=culling, level=3)
            assert prepared.kept().mean() < 0.6
        assert not (seen[~prepared.kept()] > 0).any() and prepared.lost()[1:] == (0, 0.0)


def test_all_surfaces_are_parts_and_the_origin_is_kept(device):
    away = (1000.0, -2000.0, 500.0)
    far = NurbsModel(
        tuple(
            type(s)(s.degree_u, s.degree_v, s.knots_u, s.knots_v, s.points + away, s.weights)
            for s in BODY.surfaces
        )
    )
    view = small(fit_box(*BODY.box))
    found = [
        tessellate_surface(device, model, method="rpns", pixel_area=4, view=seen)
        for model, seen in ((BODY, view), (far, moved(view, away)))
    ]
    assert len(found[0].parts) == len(BODY.surfaces)
    assert found[0].mesh.triangle_count == found[1].mesh.triangle_count
    at = [r.mesh.positions + (0 if r.mesh.origin is None else r.mesh.origin) for r in found]
    assert np.abs(at[1] - away - at[0]).max() <= 1e-5
    assert sum(len(p.triangles) for p in found[0].parts.values()) == found[0].mesh.triangle_count
    assert np.allclose(np.linalg.norm(found[0].mesh.normals, axis=1), 1, atol=1e-5)
