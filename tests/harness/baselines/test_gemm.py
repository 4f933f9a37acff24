"""The NumPy forms of refinement: against the kernels of the same surface, and against what a check must find."""

import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, plane, torus
from lodbench.harness.baselines import gemm
from lodbench.harness.plan.registry import systems
from lodbench.kernels.system import run
from tests.tolerances import ROUNDING32

PAIRS = {"numpy_pattern": "pattern", "numpy_pn_triangles": "pn_triangles"}
MESHES = {
    "ball": lambda: icosphere(1),
    "plane": lambda: plane(2),
    "strip": lambda: plane(3, 1),
    "torus": lambda: torus(9, 7),
}


def both(device, name, mesh, segments):
    made = []
    for subject in (name, PAIRS[name]):
        system = systems()[subject]
        kind = type(next(iter(system.cases.values())))
        made.append(system.prepare(device, mesh, kind(segments)))
        run(device, made[-1])
    return made


@pytest.mark.parametrize("segments", [1, 3, 16, 200])
@pytest.mark.parametrize("make", MESHES)
@pytest.mark.parametrize("name", PAIRS)
def test_numpy_form_agrees_with_reference_and_kernel(device, name, make, segments):
    host, kernel = both(device, name, MESHES[make](), segments)
    check = host.check()
    assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"
    ours, theirs = kernel.result()[0], host.result()[0]
    assert np.abs(ours.positions - theirs.positions).max() < ROUNDING32
    assert np.abs(ours.normals - theirs.normals).max() < ROUNDING32
    assert np.array_equal(ours.triangles, theirs.triangles)


@pytest.mark.parametrize("name", PAIRS)
def test_size_of_the_blocks_changes_nothing_but_rounding(device, name, monkeypatch):
    whole, _ = both(device, name, torus(9, 7), 5)
    monkeypatch.setattr(gemm, "BLOCK", 50)  # two coarse triangles
    parts, _ = both(device, name, torus(9, 7), 5)
    for one, other in zip(whole._last, parts._last, strict=True):
        np.testing.assert_allclose(one, other, atol=ROUNDING32)


@pytest.mark.parametrize("name", PAIRS)
def test_check_of_a_numpy_form_finds_a_wrong_output(device, name):
    host, _ = both(device, name, icosphere(1), 4)
    points, _ = host._last
    points[0, 1, 3] += 0.01
    assert not host.check().passed


@pytest.mark.parametrize("name", PAIRS)
def test_numpy_form_of_nothing_is_nothing(device, name):
    nothing = TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int))
    for prepared in both(device, name, nothing, 8):
        assert prepared.result()[0].triangle_count == 0
        assert prepared.check().passed
