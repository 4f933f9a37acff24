import numpy as np
import pytest

from lodbench.datasets_gen import patches
from lodbench.harness.baselines.numpy_bezier import SYSTEM, Params
from lodbench.kernels.bezier.vst import Params as VstParams
from lodbench.kernels.bezier.vst import Vst
from lodbench.kernels.system import run


@pytest.mark.parametrize(("level", "normals"), [(0, True), (3, True), (3, False), (6, True)])
def test_numpy_bezier_gives_the_vertices_of_vst(device, level, normals):
    surface = patches.cup()
    own = SYSTEM.prepare(device, surface, Params(level, normals))
    vst = Vst(device, surface, VstParams(level, normals))
    meshes = []
    for prepared in (own, vst):
        run(device, prepared)
        assert prepared.check().passed
        meshes.append(prepared.result()[0])
    diagonal = np.linalg.norm(np.ptp(surface.points.reshape(-1, 3), axis=0))
    assert np.array_equal(meshes[0].triangles, meshes[1].triangles)
    assert np.abs(meshes[0].positions - meshes[1].positions).max() < 1e-6 * diagonal
    assert (meshes[0].normals is None) == (not normals)
