"""Exclusive scan on the device: the middle of every geometry stage that counts, scans and emits."""

from __future__ import annotations

import numpy as np

from lodbench.kernels.opencl import Buffer, Device, Timeline

CHUNK_ROWS = 4096  # a shorter chunk costs more to start than to walk
GPU_CHUNK_ROWS = 64
MOST_MAPS = 4


def chunk_count(device: Device, capacity: int) -> int:
    """Into how many chunks `capacity` rows are cut on this device; integer sums come out the same for any number."""
    if device.is_cpu:
        return min(max(capacity // CHUNK_ROWS, 1), 4 * device.facts.compute_units)
    return min(max(capacity // GPU_CHUNK_ROWS, 1), 4096)


def map_count(device: Device, rows: int) -> tuple[int, int]:
    """(maps, chunks of `rows` rows) of a kernel whose items add to the same places.

    A CPU's items have a map each, since its atomics take four times as long, and are few; a GPU's share one.
    """
    chunks = chunk_count(device, rows)
    maps = min(chunks, device.facts.compute_units, MOST_MAPS) if device.is_cpu else 1
    return maps, maps if device.is_cpu else chunks


def chunk_local(device: Device) -> int | None:
    """Work-items per group of a chunked launch: a CPU's threads take whole groups, so one item each."""
    return 1 if device.is_cpu else None


def check_row(buffer: Buffer, dtype: str, rows: int) -> None:
    """Refuse a buffer of another type, or one too short for `rows` rows."""
    if buffer.dtype != np.dtype(dtype):
        raise TypeError(f"{buffer.name}: expected {np.dtype(dtype)}, got {buffer.dtype}")
    if buffer.shape[0] < rows:
        raise ValueError(f"{buffer.name}: expected at least {rows} rows, got {buffer.shape[0]}")


def live_rows(device: Device, live: Buffer | None, capacity: int) -> Buffer:
    """How many of `capacity` rows count, on the device: as given, else all of them."""
    if live is None:
        return device.upload("live", np.array([capacity], np.uint32))
    check_row(live, "uint32", 1)
    return live


class ExclusiveScan:
    """`offsets[i]` = `counts[0] + ... + counts[i - 1]`, and `total` = the sum of all; nothing is read by the host.

    Made once in `prepare`, called once a frame between the kernel that counts and the kernel that emits:

        self._scan = ExclusiveScan(device, counts, offsets, total, stage="geometry")
        ...
        self._count(timeline); self._scan(timeline); self._emit(timeline)

    The emitting kernel is launched for the capacity; it returns early for rows past `live[0]`, and compares
    `offsets[i] + counts[i]` with the room it has before it writes. Sums are modulo 2^32; any work-group size,
    chunk count and device gives the same bits.

    Args:
        device: where the buffers are.
        counts: uint32, (capacity,).
        offsets: uint32, at least (capacity,); `counts` itself scans in place. Rows past the live ones keep their value.
        total: uint32, (1,) or longer; the first word is written.
        live: uint32, (1,): how many rows count, set by an earlier kernel; None takes all. More than the capacity
            means the capacity.
        stage: the stage that the scan's seconds count towards.

    Raises:
        TypeError: a buffer that is not uint32.
        ValueError: a buffer too short.

    Source: Blelloch 1990, "Prefix sums and their applications", section 1.3.
    """

    def __init__(
        self,
        device: Device,
        counts: Buffer,
        offsets: Buffer,
        total: Buffer,
        *,
        live: Buffer | None = None,
        stage: str = "scan",
    ) -> None:
        capacity = counts.shape[0]
        for buffer, rows in ((counts, capacity), (offsets, capacity), (total, 1)):
            check_row(buffer, "uint32", rows)
        program = device.build("stages/scan.cl")
        chunks = chunk_count(device, capacity)
        self._chunk_sums = device.allocate("chunk_sums", chunks, np.uint32)
        shared = {
            "live": live_rows(device, live, capacity),
            "chunk_sums": self._chunk_sums,
            "capacity": capacity,
            "chunk_count": chunks,
        }
        local = chunk_local(device)
        self._sum = None
        if chunks > 1:  # a single chunk has nothing before it
            self._sum = program.launch(
                "stages_scan_sum", chunks, stage=stage, local=local, counts=counts, **shared
            )
        self._write = program.launch(
            "stages_scan_write", chunks, stage=stage, local=local,
            counts=counts, offsets=offsets, total=total, **shared,
        )  # fmt: skip

    def __call__(self, timeline: Timeline) -> None:
        """Enqueue the scan; never waits."""
        if self._sum is not None:
            self._sum(timeline)
        self._write(timeline)

    @property
    def scratch_bytes(self) -> int:
        """Device bytes that the scan holds for itself."""
        return self._chunk_sums.size_bytes
