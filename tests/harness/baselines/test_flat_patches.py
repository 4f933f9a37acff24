import numpy as np
import pytest

from lodbench.datasets_gen import patches
from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.harness.baselines.flat_patches import SYSTEM, Params, corner_mesh
from lodbench.kernels.system import run


@pytest.mark.parametrize("level", [0, 3])
def test_flat_patches_have_the_triangles_of_a_tessellation(device, level):
    prepared = SYSTEM.prepare(device, patches.cup(), Params(level))
    run(device, prepared)
    assert prepared.check().passed
    counts = prepared.counters()
    n = 2**level
    assert counts["triangles"] == 26 * 2 * n * n
    assert counts["vertices"] == 26 * (n + 1) * (n + 2)


def test_flat_patches_turn_as_their_patches_do():
    flat = np.stack(np.meshgrid(np.arange(4), np.arange(4), [0], indexing="ij"), axis=-1)
    mesh = corner_mesh(BezierPatches(flat[None, :, :, 0]))
    a, b, c = mesh.positions[mesh.triangles].swapaxes(0, 1)
    assert (np.cross(b - a, c - a)[:, 2] == 9).all()
