"""What the device can do at most: the lines of the roofline, measured in the run that they judge."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lodbench.kernels.opencl import Buffer, Device, Launch, Timeline
from lodbench.kernels.stages.compact import Compact
from lodbench.kernels.stages.scan import ExclusiveScan, chunk_local
from lodbench.kernels.system import Traffic

KERNELS = Path(__file__).with_name("limits.cl")
SAMPLES = 12
WARMUPS = 2
VECTOR = 32  # bytes of a float8
CHAINS = 64  # lanes that an item of the multiply-add kernel carries
SWEEPS_ON_CPU = 8  # work-items per compute unit, each with a run of its own


@dataclass(frozen=True)
class Rate:
    """One measured quantity. `subject` says which candidate won; `samples` are its own, in the order taken."""

    subject: str
    unit: str
    best: float
    median: float
    samples: tuple[float, ...]


@dataclass(frozen=True)
class Limits:
    """The limits of one device, from device events (launch_wall: from the host's clock).

    Attributes:
        size_bytes: bytes of the array that was filled and copied.
        fill: bytes written per second with a 4-byte value; the fastest of the driver's command, a vector kernel and
            one whose stores bypass the caches. A C library's memset of one repeated byte may be faster: no kernel
            can store values that way.
        copy: bytes read plus bytes written per second; the fastest of the same three.
        multiply_add: floating-point operations per second, two per multiply-add, float32.
        launch_wall: seconds from enqueueing an empty kernel to the end of the wait for it.
        launch_event: seconds of the same kernel on the device.
    """

    device: str
    size_bytes: int
    fill: Rate
    copy: Rate
    multiply_add: Rate
    launch_wall: Rate
    launch_event: Rate

    @classmethod
    def of_record(cls, row: Mapping[str, Any]) -> Limits:
        """The limits as a run's `limits` row holds them."""
        rates = {name: Rate(**rate) for name, rate in row.items() if isinstance(rate, Mapping)}
        return cls(row["device"], row["size_bytes"], **rates)

    def least_s(self, traffic: Traffic) -> float:
        """Seconds that the device needs at the least to move these bytes and do these operations.

        From the medians: a stage's own median is held against it, and a single best sample may be a clock's error.
        """
        bandwidth = max(self.fill.median, self.copy.median)
        return max(traffic.bytes / bandwidth, traffic.flops / self.multiply_add.median)

    def share(self, traffic: Traffic, seconds: float) -> float:
        """Which part of the device's limit a stage reached, 0 to 1; work that stays in cache may exceed 1."""
        return self.least_s(traffic) / seconds if seconds > 0 else float("nan")


def sweep(
    device: Device, kernel: str, count: int, *, streaming: bool = False, **arguments: Buffer | float
) -> Launch:
    """A fill or copy kernel over `count` float8: a few long runs on a CPU, neighbouring items on a GPU."""
    program = device.build(KERNELS, defines={"STREAMING": int(streaming)})
    units = device.facts.compute_units
    items = max(min(units * (SWEEPS_ON_CPU if device.is_cpu else 2048), count), 1)
    steps = -(-count // items)
    item_step, vector_step = (steps, 1) if device.is_cpu else (1, items)
    return program.launch(
        f"measure_limits_{kernel}", items, stage=kernel, local=chunk_local(device),
        steps=steps, item_step=item_step, vector_step=vector_step, vector_count=count, **arguments,
    )  # fmt: skip


def timed(
    device: Device, subjects: Mapping[str, Callable[[Timeline], object]], samples: int = SAMPLES
) -> dict[str, tuple[list[float], list[float]]]:
    """(wall seconds, device seconds) of each subject, taken in turns, after warm-ups that are dropped."""
    taken: dict[str, tuple[list[float], list[float]]] = {name: ([], []) for name in subjects}
    for turn in range(-WARMUPS, samples):
        for name, enqueue in subjects.items():
            timeline = Timeline()
            start = time.perf_counter()
            enqueue(timeline)
            device.wait()
            wall = time.perf_counter() - start
            if turn >= 0:
                taken[name][0].append(wall)
                taken[name][1].append(timeline.collect().total_s)
    return taken


def _rate(amount: float, unit: str, seconds: Mapping[str, list[float]]) -> Rate:
    """The fastest subject's rate for so much work per call; for `amount` 0 the seconds themselves."""
    name = min(seconds, key=lambda subject: float(np.median(seconds[subject])))
    values = [max(s, 1e-9) for s in seconds[name]]
    values = [amount / s for s in values] if amount else values
    best = max(values) if amount else min(values)
    return Rate(name, unit, best, float(np.median(values)), tuple(values))


def measure(
    device: Device,
    size_bytes: int = 256 << 20,
    samples: int = SAMPLES,
    steps: int | None = None,
) -> Limits:
    """The device's limits, from `samples` interleaved calls each.

    Args:
        device: the device.
        size_bytes: of the array; cut to an eighth of the device's memory. Should be several times the last cache.
        samples: counted calls per subject; at least 10 make a record.
        steps: multiply-adds of each chain; None takes enough for some milliseconds.

    Raises:
        Unsupported: no room for two such arrays.
    """
    count = max(min(size_bytes, device.memory_limit // 8) // VECTOR, 1)
    size = count * VECTOR
    values = device.allocate("values", 8 * count, np.float32)
    source = device.allocate("source", 8 * count, np.float32)
    device.fill(Timeline(), "first touch", source, 1.0)
    device.fill(Timeline(), "first touch", values, 1.0)
    kinds = {"kernel": False, "streaming kernel": True}

    fills = {"driver": lambda timeline: device.fill(timeline, "fill", values, 2.0)} | {
        name: sweep(device, "fill", count, streaming=kind, values=values, value=3.0)
        for name, kind in kinds.items()
    }
    copies = {"driver": lambda timeline: device.copy(timeline, "copy", source, values)} | {
        name: sweep(device, "copy", count, streaming=kind, source=source, values=values)
        for name, kind in kinds.items()
    }
    fill = {name: events for name, (_, events) in timed(device, fills, samples).items()}
    copy = {name: events for name, (_, events) in timed(device, copies, samples).items()}

    items = min(device.facts.compute_units * (SWEEPS_ON_CPU if device.is_cpu else 2048), count)
    steps = steps or 1 << (16 if device.is_cpu else 12)
    program = device.build(KERNELS, defines={"STREAMING": 0})
    chains = program.launch(
        "measure_limits_multiply_add", items, stage="multiply_add", local=chunk_local(device),
        values=values, factor=0.999, term=0.001, steps=steps, item_count=items,
    )  # fmt: skip
    empty = program.launch("measure_limits_empty", 1, stage="empty", values=values, item_count=0)
    taken = timed(device, {"multiply_add": chains, "empty": empty}, samples)
    return Limits(
        device=device.facts.name,
        size_bytes=size,
        fill=_rate(size, "B/s", fill),
        copy=_rate(2 * size, "B/s", copy),
        multiply_add=_rate(
            2.0 * CHAINS * steps * items, "flop/s", {"kernel": taken["multiply_add"][1]}
        ),
        launch_wall=_rate(0, "s", {"empty kernel": taken["empty"][0]}),
        launch_event=_rate(0, "s", {"empty kernel": taken["empty"][1]}),
    )


def measure_compaction(
    device: Device, rows: int, share: float = 0.5, samples: int = SAMPLES
) -> dict[str, Rate]:
    """Rows per second, by wall time, of the shared scan, of compaction of 12-byte rows, and of a copy of such rows.

    Args:
        device: the device.
        rows: how many rows are scanned and compacted.
        share: of the rows whose flag is set, at random places (seeded).
        samples: counted calls per subject, interleaved.
    """
    random = np.random.default_rng(rows)
    counts = device.upload("counts", random.integers(0, 8, rows, dtype=np.uint32))
    flags = device.upload("flags", (random.random(rows) < share).astype(np.uint8))
    offsets = device.allocate("offsets", rows, np.uint32)
    total = device.allocate("total", 1, np.uint32)
    triangles = device.upload("triangles", np.zeros((rows, 3), np.uint32))
    kept = device.allocate("kept_triangles", (rows, 3), np.uint32)
    taken = timed(
        device,
        {
            "scan": ExclusiveScan(device, counts, offsets, total),
            "compact": Compact(device, flags, total, rows=[(triangles, kept)]),
            "compact_indices": Compact(device, flags, total, indices=offsets),
            "copy": lambda timeline: device.copy(timeline, "copy", triangles, kept),
        },
        samples,
    )
    return {
        name: _rate(max(rows, 1), "rows/s", {name: walls}) for name, (walls, _) in taken.items()
    }
