import numpy as np
import pytest

from lodbench.datasets_gen.triangles import icosphere
from lodbench.kernels import refine
from lodbench.kernels.opencl.device import Device, Unsupported
from lodbench.kernels.opencl.memory import HELD_SHARE, Pool
from lodbench.kernels.opencl.timeline import Timeline


def test_memory_limit_refuses_with_the_bytes_needed_and_free():
    small = Device.open(memory_limit=1000)
    held = small.allocate("held", 150, np.float32)
    with pytest.raises(Unsupported, match=r"more: needs 4,000 bytes .* device has 400 \(free\)"):
        small.allocate("more", 1000, np.float32)
    assert small.used_bytes == 600
    held.release()
    assert small.used_bytes == 0
    assert small.allocate("again", 250, np.float32).size_bytes == 1000


def test_allocation_over_the_device_limit_is_unsupported(device):
    count = device.facts.largest_allocation_bytes // 4 + 1
    with pytest.raises(Unsupported, match="bytes of device memory, device has"):
        device.allocate("huge", count, np.float32)


def test_memory_comes_back_when_a_buffer_is_dropped():
    small = Device.open(memory_limit=1000)
    for _ in range(5):
        buffer = small.allocate("values", 200, np.float32)
        del buffer
    assert small.used_bytes == 0


def test_released_buffer_is_released_once():
    small = Device.open(memory_limit=1000)
    buffer = small.allocate("values", 10, np.float32)
    buffer.release()
    buffer.release()
    assert small.used_bytes == 0


def test_pool_hands_the_same_memory_out_again(device):
    buffer = device.allocate("values", 1 << 20, np.float32)
    handle = buffer.memory.int_ptr
    buffer.release()
    assert device.allocate("other", 1 << 20, np.float32).memory.int_ptr == handle


def test_buffers_of_many_sizes_leave_a_bounded_amount_held():
    small = Device.open(memory_limit=1 << 20)
    bound, most = HELD_SHARE * small.memory_limit, 0
    for k in range(1, 60):
        buffers = [small.allocate("values", 97 * k * n, np.float32) for n in (1, 3, 7)]
        small.fill(Timeline(), "fill", buffers[-1], 0)
        del buffers
        assert small.used_bytes == 0
        assert small.held_bytes <= bound
        most = max(most, small.held_bytes)
    assert most > bound / 2, "what is within the bound is kept"


def test_calls_of_many_sizes_leave_a_bounded_amount_held():
    small = Device.open(memory_limit=4 << 20)
    for segments in range(2, 40, 3):
        refine(icosphere(1), segments=segments, device=small)
        assert small.used_bytes == 0
        assert small.held_bytes <= HELD_SHARE * small.memory_limit


def test_view_reads_the_same_memory_as_another_type():
    small = Device.open(memory_limit=1000)
    buffer = small.upload("values", np.array([[1.0, 2.0]], np.float32))
    view = buffer.view(2, np.uint32)
    np.testing.assert_array_equal(small.read(view), [0x3F800000, 0x40000000])
    with pytest.raises(ValueError, match="values: expected a view of at most 8 bytes, got 12"):
        buffer.view(3, np.uint32)
    del buffer
    assert small.used_bytes == 8, "the view keeps the memory"
    del view
    assert small.used_bytes == 0


def test_view_of_a_view_keeps_the_memory_and_takes_any_shape_that_fits():
    small = Device.open(memory_limit=1000)
    buffer = small.upload("values", np.arange(6, dtype=np.uint32))
    pairs = buffer.view((2, 2), np.uint32)
    front = pairs.view(4, np.uint16)
    assert (pairs.shape, pairs.size_bytes, front.size_bytes) == ((2, 2), 16, 8)
    np.testing.assert_array_equal(small.read(front), [0, 0, 1, 0])  # little-endian halves
    with pytest.raises(ValueError, match="at most 16 bytes, got 24"):
        pairs.view(6, np.uint32)
    del buffer, pairs
    assert small.used_bytes == 24
    np.testing.assert_array_equal(small.read(front), [0, 0, 1, 0])
    del front
    assert small.used_bytes == 0


def test_view_that_is_released_leaves_the_memory_to_its_owner():
    small = Device.open(memory_limit=1000)
    buffer = small.upload("values", np.arange(3, dtype=np.uint32))
    view = buffer.view(3, np.int32)
    view.release()
    view.release()
    assert small.used_bytes == 12
    np.testing.assert_array_equal(small.read(buffer), [0, 1, 2])


def test_buffer_of_nothing_has_memory_and_gives_it_back():
    small = Device.open(memory_limit=1000)
    empty = small.allocate("none", (0, 3), np.float32)
    assert (empty.size_bytes, small.used_bytes) == (1, 1)
    empty.release()
    assert small.used_bytes == 0


@pytest.mark.parametrize(
    ("limit", "largest", "size", "said"),
    [
        (100, 60, 61, "more: needs 61 bytes of device memory, device has 60 (the largest allocation)"),
        (50, 60, 51, "more: needs 51 bytes of device memory, device has 50 (free)"),
        (1 << 40, 1 << 40, (1 << 40) + 1, "more: needs 1,099,511,627,777 bytes"),
    ],
)  # fmt: skip
def test_pool_says_which_limit_it_has_no_room_in(device, limit, largest, size, said):
    pool = Pool(device.queue, limit, largest)
    with pytest.raises(Unsupported) as error:
        pool.take("more", size)
    assert str(error.value).startswith(said)
    assert pool.used_bytes == 0


def test_pool_gives_out_its_limit_to_the_last_byte(device):
    pool = Pool(device.queue, 100, 60)
    held = [pool.take("half", 60), pool.take("rest", 40)]
    assert pool.used_bytes == 100
    with pytest.raises(Unsupported, match=r"device has 0 \(free\)"):
        pool.take("more", 1)
    held.pop().release()
    pool.give_back(40)
    assert pool.used_bytes == 60
    assert pool.held_bytes <= HELD_SHARE * pool.limit


def test_memory_that_the_driver_refuses_is_unsupported_and_not_counted(device, monkeypatch):
    pool = Pool(device.queue, 1000, 1000)

    class Refusing:
        def allocate(self, size):
            raise device.cl.MemoryError("clCreateBuffer", -4)

    monkeypatch.setattr(pool, "_pool", Refusing())
    with pytest.raises(Unsupported, match=r"values: needs 40 bytes .*, device refused: clCreate"):
        pool.take("values", 40)
    assert pool.used_bytes == 0
