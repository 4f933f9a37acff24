import numpy as np

from lodbench.datasets_gen.triangles import torus
from lodbench.harness.baselines.binned_adaptive_patterns import Params, prepare
from lodbench.kernels.refine.adaptive_patterns import AdaptivePatterns
from lodbench.kernels.system import run


def test_triangles_lie_by_pattern_and_make_the_same_surface(device):
    params = Params(16, tolerance=3e-3)
    plain, binned = (make(device, torus(12, 9), params) for make in (AdaptivePatterns, prepare))
    for prepared in (plain, binned):
        run(device, prepared)
        assert prepared.check().passed
    numbers = binned.chosen()[0].astype(int)
    assert len(np.unique(numbers)) > 2 and (np.diff(numbers) >= 0).all()
    points = [np.unique(found.result()[0].positions, axis=0) for found in (plain, binned)]
    assert np.array_equal(*points)
