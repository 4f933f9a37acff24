import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, plane
from lodbench.harness.baselines.numpy_pattern import SYSTEM, Params
from lodbench.kernels.refine import pattern
from lodbench.kernels.system import run
from tests.tolerances import ROUNDING32


@pytest.mark.parametrize("segments", [1, 3, 16, 200])
@pytest.mark.parametrize("make", [lambda: icosphere(1), lambda: plane(2), lambda: plane(3, 1)])
def test_numpy_pattern_agrees_with_reference_and_kernel(device, make, segments):
    host = SYSTEM.prepare(device, make(), Params(segments))
    kernel = pattern.Pattern(device, make(), pattern.Params(segments))
    for prepared in (host, kernel):
        run(device, prepared)
    check = host.check()
    assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"
    ours, theirs = kernel.result()[0], host.result()[0]
    assert np.abs(ours.positions - theirs.positions).max() < ROUNDING32
    assert np.abs(ours.normals - theirs.normals).max() < ROUNDING32
    assert np.array_equal(ours.triangles, theirs.triangles)


def test_numpy_pattern_check_finds_a_wrong_output(device):
    host = SYSTEM.prepare(device, icosphere(1), Params(4))
    run(device, host)
    points, _ = host._last
    points[0, 1, 3] += 0.01
    assert not host.check().passed


def test_numpy_pattern_of_nothing_is_nothing(device):
    host = SYSTEM.prepare(device, TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int)), Params(8))
    run(device, host)
    assert host.result()[0].triangle_count == 0
    assert host.check().passed
