import pytest

from lodbench.datasets_gen import nurbs
from lodbench.harness.baselines.rpns_picture import Params, RpnsPicture
from lodbench.kernels.system import run

SIZE = {"width": 240, "height": 192}
BODY = nurbs.body(2, 3, (4, 5))


def counters(device, **options):
    given = {"sampling": "adaptive", "level": 7} | options
    prepared = RpnsPicture(device, BODY, Params(**given, **SIZE))
    run(device, prepared)
    return prepared.counters()


def test_finer_dices_are_nearer_to_the_finest_picture(device):
    found = [counters(device, pixel_area=area) for area in (1, 8, 64)]
    found.append(counters(device, sampling="one"))
    for name in ("psnr", "model_psnr"):
        values = [own[name] for own in found]
        assert values == sorted(values, reverse=True) and values[-1] < values[0] - 3
        assert 10 < min(values) and max(values) <= 99
    assert all(own["psnr"] > own["model_psnr"] for own in found)


def test_certified_culling_changes_no_pixel_and_light_does(device):
    assert counters(device)["pixels_changed"] == 0
    light = counters(device, culling="light")
    assert light["pixels_changed"] > 0 and light["visible_lost"] > 0
    assert light["model_psnr"] < counters(device)["model_psnr"]


def test_what_is_no_size_is_refused():
    with pytest.raises(ValueError, match="width: expected"):
        Params(width=0)
