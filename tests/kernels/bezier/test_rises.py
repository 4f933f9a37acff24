import numpy as np
import pytest
from hypothesis import given, settings

from lodbench.datasets_gen import patches
from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.harness.measure.quality import distance_from
from lodbench.kernels.bezier import borders, dabt, semi_adaptive, vst
from lodbench.kernels.bezier.rises import UNITS, corner_ring, held
from lodbench.kernels.system import Frame, run
from tests.kernels.bezier.patches import bicubic, sheets


def made(device, surface, system=dabt, **options):
    prepared = system.prepare(device, surface, system.Params(test="mean", **options))
    run(device, prepared, Frame())
    return prepared


@settings(max_examples=15, deadline=None)
@given(sheets)
def test_rings_join_the_corners_that_are_one(surface):
    found = borders.borders_of(surface.points)
    ring = corner_ring(found, 1)
    assert np.array_equal(np.sort(ring), np.arange(len(ring)))
    welded = borders.sharing(found, 1)[0].reshape(-1, 3, 3)
    each = [welded[:, i : 2 + i, j : 2 + j] for i in (0, 1) for j in (0, 1)]
    vertex = np.stack(each, axis=-1).ravel()
    assert np.array_equal(vertex[ring], vertex)
    at, size = ring.copy(), np.ones(len(ring), int)
    while (others := at != np.arange(len(ring))).any():
        size += others
        at = np.where(others, ring[at], at)
    assert np.array_equal(size, np.bincount(vertex)[vertex])  # all of them


def test_creases_and_poles_stay_on_the_surface(device):
    bent = bicubic(np.array([0, 1, 1, 0])[:, None] / 4).points
    other = bent[:, ::-1].copy()
    other[..., 0] = bent[..., 0] + 1  # begins where the first ends, and at an angle
    other[..., 2] = bent[..., 2]
    surface = BezierPatches(np.concatenate([bent, other]))
    stays = held(borders.borders_of(surface.points), 0)
    assert stays[0] >> 1 & 1 and stays[1] & 1
    mesh = made(device, surface, level=3, threshold=1e-6).result()[0]
    crease = np.isclose(mesh.positions[:, 0], 1, atol=1e-6)
    assert crease.any() and np.abs(mesh.positions[crease, 2]).max() == 0
    pot = borders.borders_of(patches.pot(8).points)
    collapsed = np.nonzero(pot.collapsed)
    assert (held(pot, 0)[collapsed[0]] >> collapsed[1] & 1).all()


def test_vertices_rise_to_the_outside_by_the_mean_sagitta(device):
    height = 0.2 * np.array([0, 1, 1, 0])[:, None] + 0.2 * np.array([0, 1, 1, 0])
    prepared = made(device, bicubic(height), level=3, threshold=1e-5)
    assert (prepared.rises() > 0).all() and prepared.rises().max() < UNITS / 50
    on = made(device, bicubic(height), level=3, threshold=1e-5, fitted=False)
    assert prepared.check().passed and on.check().passed


@pytest.mark.parametrize("surface", [patches.pot(8), patches.cup()], ids=["pot", "cup"])
def test_the_mean_error_is_less_than_on_the_surface(device, surface):
    finer = vst.Vst(device, surface, vst.Params(6, normals=False))
    run(device, finer, Frame())
    (reference,) = finer.result()

    def error(mesh):
        return distance_from(reference, mesh, reference.diagonal)["mean_difference"]

    fitted, on = (made(device, surface, threshold=1e-7, fitted=f) for f in (True, False))
    assert fitted.live()[1] <= on.live()[1]
    assert error(fitted.result()[0]) < 0.9 * error(on.result()[0])


def test_both_systems_and_no_normals_give_the_same(device):
    one = made(device, patches.pot(8)).result()[0]
    other = made(device, patches.pot(8), semi_adaptive, normals=False).result()[0]
    assert one.positions.tobytes() == other.positions.tobytes() and other.normals is None
