"""All baselines of NURBS surfaces, which share what is around them."""

import importlib
import sys

import numpy as np
import pytest

from lodbench.datasets_gen import nurbs
from lodbench.kernels.nurbs.uniform_nurbs import Params, UniformNurbs
from lodbench.kernels.system import Unsupported, run

NAMES = ("numpy_nurbs", "splipy_nurbs", "scipy_ndbspline", "geomdl_nurbs")
MODELS = {"ball": nurbs.ball(), "mixed": nurbs.mixed_degrees(), "quilt": nurbs.quilt(1, 2, 3)}


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("name", NAMES)
def test_baseline_gives_the_points_of_the_kernels(device, name, model):
    package = importlib.import_module(f"lodbench.harness.baselines.{name}")
    surface = MODELS[model]
    try:
        prepared = package.SYSTEM.prepare(device, surface, package.Params(4))
    except Unsupported as reason:
        pytest.skip(str(reason))
    own = UniformNurbs(device, surface, Params(4))
    meshes = []
    for subject in (prepared, own):
        run(device, subject)
        assert subject.check().passed
        meshes.append(subject.result()[0])
    assert np.array_equal(meshes[0].triangles, meshes[1].triangles)
    assert np.abs(meshes[0].positions - meshes[1].positions).max() < 1e-6 * surface.diagonal


@pytest.mark.parametrize("name", ["splipy", "geomdl"])
def test_absent_package_is_unsupported_with_the_line_that_installs_it(device, name, monkeypatch):
    package = importlib.import_module(f"lodbench.harness.baselines.{name}_nurbs")
    for module in (name, "geomdl.BSpline", "geomdl.NURBS"):
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(Unsupported, match=f"pip install {name}"):
        package.SYSTEM.prepare(device, nurbs.ball(), package.Params(1))
