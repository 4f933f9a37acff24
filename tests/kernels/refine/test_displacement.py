import numpy as np
import pytest

from lodbench.datasets_gen.triangles import icosphere, torus
from lodbench.kernels import refine
from lodbench.kernels.refine import pattern, pn_triangles
from lodbench.kernels.refine.displacement import PERIOD, Noise, noise, permutation
from lodbench.kernels.system import Frame, run
from tests.kernels.refine.test_pattern import shaken, tetrahedron

KINDS = pytest.mark.parametrize("kind", ["perlin", "turbulence"])


def points(count=2000, seed=0, size=20.0):
    return (np.random.default_rng(seed).random((count, 3)) - 0.5) * size


def test_noise_is_zero_at_lattice_points_and_at_most_one():
    lattice = np.stack(np.meshgrid(*[np.arange(-3.0, 4.0)] * 3), axis=-1).reshape(-1, 3)
    assert not noise(lattice)[0].any()
    values = noise(points())[0]
    assert np.abs(values).max() <= 1 and values.std() > 0.2


def test_noise_rises_by_its_gradient():
    at, h = points(), 1e-5
    gradient = noise(at)[1]
    for axis in range(3):
        step = h * np.eye(3)[axis]
        slope = (noise(at + step)[0] - noise(at - step)[0]) / (2 * h)
        np.testing.assert_allclose(gradient[:, axis], slope, atol=1e-8)


def test_noise_has_no_kink_between_cells():
    """First and second derivatives are the same from either side of a face."""
    face = points(500, 1)
    face[:, 0] = np.round(face[:, 0])
    h, step = 1e-4, np.array([1.0, 0, 0])
    below, at, above = (noise(face + k * h * step)[1] for k in (-1, 0, 1))
    np.testing.assert_allclose((at - below) / h, (above - at) / h, atol=0.1)


def test_noise_repeats_after_its_period():
    at = points(100, 2)
    np.testing.assert_allclose(noise(at + PERIOD)[0], noise(at)[0], atol=1e-10)
    table = permutation()
    assert sorted(table[:PERIOD].tolist()) == list(range(PERIOD))
    assert np.array_equal(table[:PERIOD], table[PERIOD:])


def test_octaves_are_halves_at_double_frequency():
    at = points(300, 3)
    one, three = (Noise(2.0, 0.5, 0.25, octaves, False)(at) for octaves in (1, 3))
    q = at * 0.5 + (0, 0, 0.25)
    expected = sum(noise(q * 2.0**k)[0] * 0.5**k for k in range(3))
    np.testing.assert_allclose(three[0], 2 * expected)
    np.testing.assert_allclose(one[0], 2 * noise(q)[0])
    assert (Noise(1.0, 0.5, 0.0, 2, True)(at)[0] >= 0).all()


@KINDS
@pytest.mark.parametrize("octaves", [1, 4])
@pytest.mark.parametrize("segments", [1, 3, 8, 33])
@pytest.mark.parametrize("make", [tetrahedron, lambda: shaken(icosphere(1)), lambda: torus(9, 7)])
def test_raised_surface_agrees_with_reference(device, make, segments, octaves, kind):
    options = {"displacement": kind, "amplitude": 0.03, "waves": 5.0, "octaves": octaves}
    for system in (pattern, pn_triangles):
        prepared = system.SYSTEM.prepare(device, make(), system.Params(segments, **options))
        run(device, prepared, Frame(time=0.3))
        check = prepared.check()
        assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"


@KINDS
@pytest.mark.parametrize("segments", [2, 5, 16])
@pytest.mark.parametrize("offset", [0.0, 1000.0])
def test_raised_surface_has_no_cracks(device, segments, kind, offset):
    mesh = shaken(icosphere(1), offset=offset)
    options = {"displacement": kind, "amplitude": 0.05, "waves": 9.0}
    made = pattern.Pattern(device, mesh, pattern.Params(segments, **options)).result()[0]
    both = np.hstack([made.positions, made.normals]) + np.float32(0)
    assert len(np.unique(both, axis=0)) == mesh.triangle_count * segments**2 // 2 + 2


def test_normals_follow_the_raised_surface(device):
    mesh = icosphere(2)
    options = {"displacement": "perlin", "amplitude": 0.01, "waves": 3.0, "octaves": 2}
    made = pn_triangles.PnTriangles(device, mesh, pn_triangles.Params(24, **options)).result()[0]
    a, b, c = made.positions.astype(float)[made.triangles].transpose(1, 0, 2)
    facet = np.cross(b - a, c - a)
    facet /= np.linalg.norm(facet, axis=1, keepdims=True)
    mean = made.normals.astype(float)[made.triangles].mean(axis=1)
    along = (facet * mean).sum(1) / np.linalg.norm(mean, axis=1)
    assert np.degrees(np.arccos(np.clip(along, -1, 1))).max() < 4


def test_time_moves_the_noise_and_comes_back_after_its_period(device):
    options = {"displacement": "perlin", "amplitude": 0.05, "waves": 4.0}
    prepared = pattern.Pattern(device, icosphere(1), pattern.Params(6, **options))
    found = []
    for time in (0.0, 0.5, float(PERIOD)):
        run(device, prepared, Frame(time=time))
        found.append(prepared.result()[0].positions)
    assert (found[0] != found[1]).any()
    assert np.array_equal(found[0], found[2])


@KINDS
@pytest.mark.parametrize("size", [1e-30, 1e30])
def test_noise_of_any_size_is_finite(device, kind, size):
    mesh = icosphere(1)
    far = type(mesh)((mesh.positions * size).astype(np.float32), mesh.triangles)
    options = {"displacement": kind, "amplitude": 1.0, "waves": 1e4, "octaves": 12}
    made = pattern.Pattern(device, far, pattern.Params(5, **options)).result()[0]
    assert np.isfinite(made.positions).all() and np.isfinite(made.normals).all()


def test_displacement_is_an_option_of_every_refinement():
    for method in ("pattern", "pn_triangles", "st_triangles"):
        smooth, rough = (
            refine(icosphere(1), segments=4, method=method, displacement=kind, amplitude=a)[0]
            for kind, a in (("perlin", 0.0), ("perlin", 0.1))
        )
        assert np.abs(smooth - rough).max() > 0.01
    with pytest.raises(ValueError, match="displacement: expected one of sine, perlin, turbulence"):
        refine(icosphere(0), displacement="bumps")
    with pytest.raises(ValueError, match="octaves: expected 1 to 12, got 13"):
        refine(icosphere(0), octaves=13)
