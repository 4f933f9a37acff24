import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen import catalogue, patches
from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels import tessellate
from lodbench.kernels.bezier import lattice, reference
from lodbench.kernels.bezier.gst import Gst, Params
from lodbench.kernels.bezier.gst.reference import coefficients, sampled
from lodbench.kernels.bezier.gst.zones import largest_zone, zone_arrangement
from lodbench.kernels.bezier.vst import Params as VstParams
from lodbench.kernels.bezier.vst import Vst
from lodbench.kernels.system import run
from tests.kernels.bezier.patches import NASTY, sheets

REUSES = ("row", "zone", "none")


def made(device, kind, surface, params):
    prepared = kind(device, surface, params)
    run(device, prepared)
    assert prepared.check().passed, prepared.check()
    return prepared


def on_lattice(prepared):
    """Points and normals at each virtual vertex, once each of its slots is seen to be the same to the bit."""
    places, count = prepared.arrangement.places, len(prepared._patches.points)
    (mesh,) = prepared.result()
    found = []
    for values in (mesh.positions, mesh.normals):
        if values is None:
            continue
        slots = values.reshape(count, -1, 3).view(np.uint32)
        vertices = np.zeros((count, places.max() + 1, 3), np.uint32)
        vertices[:, places] = slots
        assert np.array_equal(vertices[:, places], slots)
        found.append(vertices.view(np.float32))
    return found


@given(st.integers(0, 10), st.sampled_from([4, 8]), st.integers(32, 5000))
def test_zone_never_emits_more_than_it_may(level, values, most):
    zone = largest_zone(level, values, most)
    assert zone.vertices * values <= most
    assert (1 << level) % zone.rows == (1 << level) % zone.columns == 0


@pytest.mark.parametrize(
    ("level", "values", "zones"),
    [(3, 4, 1), (4, 4, 4), (5, 4, 16), (6, 4, 64), (4, 8, 8), (5, 8, 32)],
)
def test_zones_are_as_many_as_1024_values_ask_for(level, values, zones):
    zone = largest_zone(level, values, 1024)
    assert 4**level == zones * zone.rows * zone.columns


@pytest.mark.parametrize("level", [0, 1, 2, 3, 4])
def test_zones_tile_the_map(level):
    zone = largest_zone(level, 8, 1024)
    arrangement = zone_arrangement(level, zone)
    triangles = arrangement.places[arrangement.triangles]
    expected = lattice.lattice_triangles(level)
    assert {tuple(t) for t in triangles.tolist()} == {tuple(t) for t in expected.tolist()}
    assert len(triangles) == len(expected)
    assert len(arrangement.places) % zone.vertices == 0


@pytest.mark.parametrize("level", [0, 2, 5])
@pytest.mark.parametrize("reuse", REUSES)
@pytest.mark.parametrize("normals", [True, False])
def test_gst_and_vst_have_the_same_vertices(device, reuse, level, normals):
    surface = patches.cup()
    own = on_lattice(made(device, Gst, surface, Params(level, normals, reuse)))
    other = on_lattice(made(device, Vst, surface, VstParams(level, normals)))
    diagonal = np.linalg.norm(np.ptp(surface.points.reshape(-1, 3), axis=0))
    assert len(own) == len(other) == 1 + normals
    assert np.abs(own[0] - other[0]).max() <= 1e-6 * diagonal
    border = lattice.edge_vertices(level)
    assert np.array_equal(own[0][:, border], other[0][:, border])
    if normals:
        _, certain = reference.normals_at(
            surface.points.astype(np.float64), *lattice.lattice_parameters(level)
        )
        assert np.linalg.norm(own[1] - other[1], axis=-1)[certain].max() < np.deg2rad(0.02)


@pytest.mark.parametrize("name", ["teapot", "elephant_gumbo"])
def test_gst_of_real_models_passes_its_check(device, data_folder, name):
    made(device, Gst, catalogue.load(name).surface, Params(4))


@settings(max_examples=8, deadline=None)
@given(sheets, st.sampled_from(REUSES), st.sampled_from([40, 200, 1024]))
def test_gst_is_the_same_surface_in_zones_of_any_size(device, surface, reuse, most):
    whole, own = (
        tessellate(surface, level=3, method="gst", reuse=reuse, most_values=n) for n in (4096, most)
    )
    assert np.array_equal(whole[0], own[0])
    assert sorted(whole[1].tolist()) == sorted(own[1].tolist())


@pytest.mark.parametrize("reuse", REUSES)
@pytest.mark.parametrize("name", NASTY)
def test_gst_bears_nasty_patches(device, name, reuse):
    for level in (0, 3):
        prepared = made(device, Gst, BezierPatches(NASTY[name]), Params(level, reuse=reuse))
        (mesh,) = prepared.result()
        assert np.isfinite(mesh.positions).all()
        assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-6)


def test_gst_past_the_caches_gives_the_same_bytes(device, monkeypatch):
    surface = patches.cup()
    expected = on_lattice(made(device, Gst, surface, Params(4)))
    monkeypatch.setattr("lodbench.kernels.launching.STREAM_BYTES", 0)
    for one, other in zip(expected, on_lattice(made(device, Gst, surface, Params(4))), strict=True):
        assert one.tobytes() == other.tobytes()


def test_gst_says_how_many_values_a_zone_emits(device):
    counters = made(device, Gst, patches.cup(), Params(4)).counters()
    assert counters["zones"] == 26 * 8
    assert counters["zone_values"] == 4 * 2 * 9 * 8
    assert counters["triangles"] == 26 * 2 * 4**4


def test_reference_by_powers_is_the_surface():
    P = patches.cup().points.astype(np.float64)
    points = reference.points_at(P, *lattice.lattice_parameters(3)).reshape(-1, 9, 9, 3)
    assert np.allclose(sampled(P, 3), points)
    assert np.allclose(
        coefficients(P)[:, 0, 0], reference.points_at(P, *np.array([[0.5], [0.5]]))[:, 0]
    )


def test_gst_refuses_what_it_cannot_do():
    with pytest.raises(ValueError, match="most_values: expected 32 to 65536"):
        tessellate(patches.cup(), method="gst", most_values=10)
    with pytest.raises(ValueError, match="reuse: expected one of row, zone, none"):
        tessellate(patches.cup(), method="gst", reuse="all")
