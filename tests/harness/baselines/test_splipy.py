import sys

import numpy as np
import pytest

from lodbench.datasets_gen import patches
from lodbench.harness.baselines.splipy import SYSTEM, Params
from lodbench.kernels.bezier.vst.reference import tessellated
from lodbench.kernels.system import Unsupported, run


@pytest.mark.parametrize("level", [0, 3])
def test_splipy_gives_the_surface_of_the_reference(device, level):
    pytest.importorskip("splipy")
    surface = patches.cup()
    prepared = SYSTEM.prepare(device, surface, Params(level))
    run(device, prepared)
    assert prepared.check().passed
    (mesh,) = prepared.result()
    points, _ = tessellated(surface.points.astype(np.float64), level)
    assert np.allclose(mesh.positions, points.reshape(-1, 3), atol=1e-6)
    assert mesh.triangle_count == prepared.counters()["triangles"] == 26 * 2 * 4**level


def test_splipy_says_what_it_needs_where_it_is_absent(device, monkeypatch):
    monkeypatch.setitem(sys.modules, "splipy", None)
    with pytest.raises(Unsupported, match="pip install splipy"):
        SYSTEM.prepare(device, patches.cup(), Params(2))
