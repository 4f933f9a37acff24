import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.fast_simplification import SYSTEM, Params
from lodbench.harness.baselines.simplifier import asked
from lodbench.harness.measure.quality import measure, topology
from lodbench.kernels.system import run


def height_field(cells=60, side=1.0):
    """An open sheet with two waves in it: 2 * cells^2 triangles."""
    axis = np.linspace(0, 1, cells + 1)
    x, y = np.meshgrid(axis, axis)
    z = 0.1 * np.sin(6 * x) * np.cos(5 * y)
    row = cells + 1
    a = (np.arange(cells)[:, None] * row + np.arange(cells)).ravel()
    faces = np.concatenate(
        [np.stack([a, a + 1, a + row + 1], 1), np.stack([a, a + row + 1, a + row], 1)]
    )
    return TriangleMesh(side * np.stack([x.ravel(), y.ravel(), z.ravel()], 1), faces)


def simplified(device, mesh, params):
    prepared = SYSTEM.prepare(device, mesh, params)
    timeline = run(device, prepared)
    return prepared, timeline, prepared.result()[0]


def test_fast_simplification_reaches_the_count_asked_for(device):
    mesh = height_field()
    prepared, timeline, result = simplified(device, mesh, Params(target_count=700))
    assert 690 <= result.triangle_count <= 700
    assert prepared.check().passed
    assert prepared.counters() == {
        "vertices": result.vertex_count,
        "triangles": result.triangle_count,
    }
    assert set(timeline.stage_s) == {"call"}
    assert 0 < timeline.stage_s["call"] <= timeline.wall_s
    assert topology(result)["components"] == 1


def test_fast_simplification_target_reduction_is_the_share_removed(device):
    mesh = height_field()
    _, _, result = simplified(device, mesh, Params(target_reduction=0.75))
    assert result.triangle_count == pytest.approx(0.25 * mesh.triangle_count, abs=2)


@pytest.mark.parametrize("side", [1.0, 1e4])
def test_fast_simplification_careful_case_does_not_depend_on_units(device, side):
    mesh = height_field(side=side)
    params = SYSTEM.cases["careful"]
    _, _, result = simplified(device, mesh, params)
    assert result.triangle_count <= asked(mesh, params)
    assert measure(mesh, result, samples=2000)["rms_error"] < 2e-3  # a fiftieth of the waves


def test_fast_simplification_check_fails_when_the_count_is_not_kept(device):
    mesh = height_field(cells=10)
    prepared, _, _ = simplified(device, mesh, Params(target_count=100))
    prepared.read = lambda _: [mesh]
    verdict = prepared.check()
    assert not verdict.passed
    assert verdict.value == pytest.approx(1.0)  # 200 triangles where 100 were asked for


def test_fast_simplification_check_fails_on_what_is_no_mesh(device):
    mesh = height_field(cells=10)
    prepared, _, _ = simplified(device, mesh, Params(target_count=100))
    points = mesh.positions.copy()
    points[3, 1] = np.nan
    prepared.read = lambda _: [TriangleMesh(points, mesh.triangles)]
    verdict = prepared.check()
    assert not verdict.passed
    assert "expected finite" in verdict.what


def test_fast_simplification_gives_back_a_mesh_that_is_small_enough(device):
    mesh = height_field(cells=3)
    _, _, result = simplified(device, mesh, Params(target_count=1000))
    np.testing.assert_array_equal(result.triangles, mesh.triangles)


def test_fast_simplification_of_nothing_is_nothing(device):
    empty = TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int))
    _, _, result = simplified(device, empty, Params())
    assert result.triangle_count == 0


@pytest.mark.parametrize(
    "given", [{"target_count": -1}, {"target_reduction": 1.5}, {"target_reduction": -0.1}]
)
def test_params_refuse_what_makes_no_target(given):
    with pytest.raises(ValueError, match=next(iter(given))):
        Params(**given)
