import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere
from lodbench.kernels import turntable


@pytest.mark.parametrize("up", ["x", "y", "z"])
def test_turntable_keeps_its_distance_and_shows_all(device, up):
    tall = TriangleMesh(icosphere(1).positions * (1, 4, 2), icosphere(1).triangles)
    images = turntable(tall, frames=8, size=(48, 40), up=up, colour="flat", device=device)
    assert images.shape == (8, 40, 48, 3)
    background = images[0][:, :1]
    for image in images:
        shown = (image != background).any(-1)
        assert shown.any() and not shown[[0, -1]].any() and not shown[:, [0, -1]].any()
    # half a turn on, a body that is its own image through its middle has an outline as large
    outline = [(image != background).any(-1).sum() for image in images]
    assert outline[0] == pytest.approx(outline[4], rel=0.06)


def test_turntable_never_pulses(device):
    ball = icosphere(3)
    images = turntable(ball, frames=6, size=(40, 40), device=device)
    sizes = [(image != image[:, :1]).any(-1).sum() for image in images]
    assert max(sizes) - min(sizes) <= 0.03 * max(sizes)
    with pytest.raises(ValueError, match="frames: expected 1 to 1000, got 0"):
        turntable(ball, frames=0, device=device)


def test_a_path_draws_back_and_refines_less(device):
    options = {"size": (64, 64), "path": "orbit", "frames": 4, "device": device}
    refined = {"refine": "adaptive_patterns", "by": "screen", "wireframe": True}
    images = turntable(icosphere(0), colour="flat", **options, **refined)
    assert images.shape == (4, 64, 64, 3)
    shown = [(image != image[:, :1]).any(-1).sum() for image in images]
    assert shown[0] > 20 * shown[2], "the second half of the path is far away"
    with pytest.raises(ValueError, match="path: expected one of turntable, orbit, fly_through"):
        turntable(icosphere(0), path="around", device=device)
