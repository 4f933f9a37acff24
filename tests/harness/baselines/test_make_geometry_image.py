import numpy as np
import pytest

from lodbench.datasets_gen.shapes import blob_with_ears
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, torus
from lodbench.harness.baselines.make_geometry_image import SYSTEM, Params
from lodbench.kernels.opencl.device import Unsupported
from lodbench.kernels.system import run


def test_set_up_counts_what_the_table_shows(device):
    prepared = SYSTEM.prepare(device, icosphere(2), Params(n=4))
    run(device, prepared)
    assert prepared.check().passed
    counters = prepared.counters()
    assert counters["triangles"] == 512
    assert counters["flipped"] == 0
    assert counters["degree"] == pytest.approx(1)
    assert 0 < counters["area_min"] <= counters["area_least_hundredth"] < 1 < counters["area_max"]
    assert counters["parameterise_s"] > 0


def test_kept_sphere_is_made_before_the_frame_that_reads_it(device, monkeypatch, tmp_path):
    monkeypatch.setenv("LODBENCH_CACHE", str(tmp_path))
    prepared = SYSTEM.prepare(device, icosphere(2), Params(n=4, cache=True))
    assert prepared.setup.stage_s["fill_cache"] > 0
    before = sorted(tmp_path.rglob("*.npz"))
    run(device, prepared)
    assert before == sorted(tmp_path.rglob("*.npz")) != []
    assert prepared.counters()["parameterise_s"] < prepared.setup.stage_s["fill_cache"]


def test_comparison_mode_keeps_less_of_the_surface(device):
    least = {}
    for mode in ("coarse_to_fine", "cmcf"):
        prepared = SYSTEM.prepare(device, blob_with_ears(10), Params(n=4, mode=mode))
        run(device, prepared)
        least[mode] = prepared.counters()["area_least_hundredth"]
    assert least["coarse_to_fine"] > 10 * least["cmcf"]


def test_failed_mode_and_wrong_surface_are_reasons_to_skip(device):
    with pytest.raises(Unsupported, match="ray left"):
        run(device, SYSTEM.prepare(device, blob_with_ears(12), Params(mode="ray")))
    with pytest.raises(Unsupported, match="Euler number 0"):
        run(device, SYSTEM.prepare(device, torus(12, 8), Params()))


def test_no_triangles_in_none_out(device):
    prepared = SYSTEM.prepare(
        device, TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int)), Params()
    )
    run(device, prepared)
    assert prepared.check().passed
    assert prepared.result()[0].triangle_count == 0


@pytest.mark.parametrize("wrong", [{"n": 0}, {"mode": "tutte"}, {"turn": "up"}])
def test_parameters_out_of_range_are_refused(wrong):
    with pytest.raises(ValueError, match="expected"):
        Params(**wrong)
