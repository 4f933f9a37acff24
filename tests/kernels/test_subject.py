"""The base of device subjects, by one that spreads as many triangles as its frame says: it overflows on purpose."""

import numpy as np
import pytest

from lodbench.kernels.opencl.device import Device, Unsupported
from lodbench.kernels.opencl.timeline import Timeline
from lodbench.kernels.stages.camera import fit_box
from lodbench.kernels.stages.raster import Raster
from lodbench.kernels.subject import POINT, DeviceSubject
from lodbench.kernels.system import Check, DeviceSurface, Frame, run

KERNEL = """
__kernel void spread(__global float *positions, __global uint *triangles, __global uint *counts, __global uint *state,
    const uint capacity, const uint wanted)
{
    const uint i = get_global_id(0), made = min(capacity, wanted);
    if (i == 0) { state[0] = wanted; counts[0] = 3 * made; counts[1] = made; }
    if (i >= made) return;
    vstore3((float3)(i, 0, 0), 3 * i, positions);
    vstore3((float3)(i + 1, 0, 0), 3 * i + 1, positions);
    vstore3((float3)(i, 1, 0), 3 * i + 2, positions);
    vstore3((uint3)(3 * i, 3 * i + 1, 3 * i + 2), i, triangles);
}
"""


class Spread(DeviceSubject):
    """`Frame.time` triangles side by side."""

    def __init__(self, device, folder, capacity=4):
        super().__init__(device)
        file = folder / "spread.cl"
        file.write_text(KERNEL)
        self._program = device.build(file)
        self.counts = self.allocate("counts", 2, np.uint32)
        self.state = self.allocate("state", 1, np.uint32)
        self.capacity, self.grown = capacity, 0
        self._make()
        self.warm_up()

    def _make(self):
        self.positions = self.allocate("positions", (3 * self.capacity, 3), np.float32, "output")
        self.triangles = self.allocate("triangles", (self.capacity, 3), np.uint32, "output")
        surface = DeviceSurface(
            self.positions, None, self.triangles, 3 * self.capacity, self.capacity,
            counts=self.counts,
        )  # fmt: skip
        self.output = (surface,)
        self._steps.clear()
        self._launch = self._program.launch(
            "spread", self.capacity, stage="spread", positions=self.positions, triangles=self.triangles,
            counts=self.counts, state=self.state, capacity=self.capacity, wanted=0,
        )  # fmt: skip
        self.add(self._launch, bytes=lambda own: 4 * POINT * own.live()[1], flops=7)

    def steps(self, frame):
        self._launch.set(wanted=int(frame.time))
        return super().steps(frame)

    def overflowed(self):
        return int(self.device.read(self.state)[0]) > self.capacity

    def grow(self):
        self.grown += 1
        self.release("output", self.positions, self.triangles)
        self.capacity = int(self.device.read(self.state)[0])
        self._make()

    def check(self):
        return Check(True, "nothing", 0, 0)


@pytest.fixture
def spread(device, tmp_path):
    return Spread(device, tmp_path)


def test_memory_is_counted_by_role_as_it_is_taken_and_given_back(device, spread):
    assert spread.footprint().output_bytes == 4 * (3 * 12 + 12)
    assert spread.footprint().scratch_bytes == 12
    with spread.holding("pattern"):
        kept = [device.allocate("a", 100, np.uint8), device.allocate("b", 1, np.float64)]
        device.allocate("gone", 1000, np.uint8)
    assert spread.footprint().pattern_bytes == sum(buffer.size_bytes for buffer in kept)
    run(device, spread, Frame(time=9))
    assert spread.footprint().output_bytes == 9 * (3 * 12 + 12)


def test_traffic_is_that_of_the_steps_of_the_last_frame(device, spread):
    run(device, spread, Frame(time=3))
    assert {stage: vars(moved) for stage, moved in spread.traffic().items()} == {
        "spread": {"bytes": 4 * 12 * 3, "flops": 7}
    }
    spread.fill("clear", spread.state, 0)
    timeline = run(device, spread, Frame(time=3))
    assert list(timeline.stage_s) == ["spread", "clear"]
    assert list(spread.traffic()) == ["spread"], "a step that says no bytes is in no share"


def test_result_counters_and_stored_are_the_live_rows(device, spread):
    run(device, spread, Frame(time=2))
    (mesh,) = spread.result()
    assert mesh.triangles.tolist() == [[0, 1, 2], [3, 4, 5]]
    assert mesh.positions[:, 0].tolist() == [0, 1, 0, 1, 2, 1]
    assert spread.counters() == {"vertices": 6, "triangles": 2}
    assert spread.stored().stored_bytes == 12 * (6 + 2)


def test_subject_of_several_surfaces_counts_and_reads_them_all(device, spread, tmp_path):
    other = Spread(device, tmp_path)
    run(device, other, Frame(time=1))
    run(device, spread, Frame(time=2))
    spread.output = (*spread.output, *other.output)
    assert spread.live_rows() == [(6, 2), (3, 1)]
    assert spread.counters() == {"vertices": 9, "triangles": 3}
    assert [mesh.triangle_count for mesh in spread.result()] == [2, 1]
    spread.output = ()
    spread.enqueue(Frame(), Timeline())
    assert spread.live() == (0, 0)
    assert spread.result() == []


def test_subject_that_has_run_no_frame_runs_one_where_it_is_asked(device, tmp_path):
    class Lazy(Spread):
        def warm_up(self):
            pass

    lazy = Lazy(device, tmp_path)
    assert lazy.frame is None
    assert lazy.counters() == {"vertices": 0, "triangles": 0}
    assert lazy.frame == Frame()


def test_frame_that_overflows_grows_its_subject_and_runs_again(device, spread):
    run(device, spread, Frame(time=4))
    assert spread.grown == 0
    timeline = run(device, spread, Frame(time=50))
    assert (spread.grown, spread.capacity) == (1, 50)
    assert spread.counters()["triangles"] == 50
    assert set(timeline.stage_s) == {"spread"}
    run(device, spread, Frame(time=7))
    assert (spread.grown, spread.counters()["triangles"]) == (1, 7)


def test_raster_grows_with_the_surface_that_it_draws(device, spread, tmp_path):
    view = fit_box((0, 0, 0), (50, 1, 0), size=(70, 66))
    raster = Raster(device, spread.output, 70, 66, view=view)
    run(device, spread, Frame(time=50), raster)
    grown = raster.image()
    other = Spread(device, tmp_path, capacity=64)
    run(device, other, Frame(time=50), own := Raster(device, other.output, 70, 66, view=view))
    assert np.array_equal(grown, own.image())
    assert raster.keys()[1][raster.keys()[1] != 0xFFFFFFFF].max() > 40, (
        "triangles past the first four"
    )


def test_no_room_to_grow_is_said(tmp_path):
    small = Device.open(memory_limit=10_000)
    spread = Spread(small, tmp_path)
    with pytest.raises(Unsupported, match="needs"):
        run(small, spread, Frame(time=10_000))


def test_what_a_system_has_to_write_is_named(device):
    with pytest.raises(NotImplementedError, match=r"DeviceSubject\.check"):
        DeviceSubject(device).check()
    DeviceSubject(device).enqueue(Frame(), Timeline())
