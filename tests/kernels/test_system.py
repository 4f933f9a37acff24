import pytest

from lodbench.kernels.opencl.device import Unsupported
from lodbench.kernels.system import Frame, Growing, Remembering, Traffic, run


class Prepared:
    """Counts its frames; the first ones need more room than there is."""

    output = None

    def __init__(self, missing=0):
        self.missing, self.said = missing, []

    def enqueue(self, frame, timeline):
        self.said.append("frame")
        with timeline.host("call"):
            pass


class Needing(Prepared):
    def overflowed(self):
        return self.missing > 0

    def grow(self):
        self.said.append("grow")
        self.missing -= 1


def test_frame_is_enqueued_once_and_timed(device):
    made = Prepared()
    timeline = run(device, made)
    assert made.said == ["frame"]
    assert timeline.wall_s >= timeline.stage_s["call"] >= 0
    assert not isinstance(made, Growing) and not isinstance(made, Remembering)


@pytest.mark.parametrize("missing", [0, 1, 3])
def test_frame_that_overflowed_runs_again_warm_after_each_growth(device, missing):
    made = Needing(missing)
    assert isinstance(made, Growing)
    run(device, made)
    assert made.said == ["frame"] + ["grow", "frame", "frame"] * missing


def test_frame_of_nothing_on_the_device_cannot_be_drawn(device):
    drawn = []
    with pytest.raises(Unsupported):
        run(device, Prepared(), raster=lambda *given: drawn.append(given))
    assert not drawn


def test_frame_is_drawn_from_what_it_left_with_its_own_view(device):
    made, drawn, frame = Prepared(), [], Frame()
    made.output = "a surface"
    timeline = run(device, made, frame, raster=lambda *given: drawn.append(given))
    assert drawn == [("a surface", frame, timeline)]


def test_traffic_adds_up():
    assert Traffic(3, 5) + Traffic(10) == Traffic(13, 5)
