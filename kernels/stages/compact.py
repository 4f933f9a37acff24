"""Stream compaction on the device: rows whose flag is set, in order, and how many there are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lodbench.kernels.opencl import Buffer, Device, Timeline
from lodbench.kernels.stages.scan import check_row, chunk_count, chunk_local, live_rows


class Compact:
    """The rows whose flag is set, moved to the front in their order; `total` = how many. Nothing is read by the host.

    Made once in `prepare`, called once a frame after the kernel that sets the flags:

        self._compact = Compact(device, flags, total, rows=[(triangles, kept_triangles)], stage="geometry")

    Kernels after it are launched for the capacity and return early for rows past `total[0]`. To rename what refers
    to the rows, scan the flags as counts with `ExclusiveScan` instead. Any work-group size, chunk count and device
    gives the same bits; what stands behind the kept rows is not touched.

    Args:
        device: where the buffers are.
        flags: uint8, (capacity,); not 0: the row stays.
        total: uint32, (1,) or longer; the first word is written.
        rows: (source, target) pairs of one type and shape (capacity, ...) each, not the same memory; a row is a whole
            number of 4-byte words.
        indices: uint32, (capacity,): takes the row numbers that stay; None where no one asks for them.
        live: uint32, (1,): how many rows count, set by an earlier kernel; None takes all.
        stage: the stage that the seconds count towards.

    Raises:
        TypeError: a buffer of another type.
        ValueError: a buffer too short, or a row that is not a whole number of words.
    """

    def __init__(
        self,
        device: Device,
        flags: Buffer,
        total: Buffer,
        *,
        rows: Sequence[tuple[Buffer, Buffer]] = (),
        indices: Buffer | None = None,
        live: Buffer | None = None,
        stage: str = "compact",
    ) -> None:
        capacity = flags.shape[0]
        check_row(flags, "uint8", capacity)
        check_row(total, "uint32", 1)
        chunks = chunk_count(device, capacity)
        self._chunk_sums = device.allocate("chunk_sums", chunks, np.uint32)
        shared = {
            "flags": flags,
            "live": live_rows(device, live, capacity),
            "chunk_sums": self._chunk_sums,
            "capacity": capacity,
            "chunk_count": chunks,
        }

        def launch(kernel: str, row_words: int = 1, **arguments: Buffer):
            program = device.build("stages/compact.cl", defines={"ROW_WORDS": row_words})
            local = chunk_local(device)
            return program.launch(kernel, chunks, stage=stage, local=local, **shared, **arguments)

        if not rows and indices is None:
            raise ValueError("rows: expected pairs, or indices to write, got neither")
        self._launches = [launch("stages_compact_sum")]
        if indices is not None:
            check_row(indices, "uint32", capacity)
            self._launches.append(launch("stages_compact_indices", indices=indices, total=total))
        for source, target in rows:
            check_row(source, str(target.dtype), capacity)
            check_row(target, str(source.dtype), capacity)
            size = int(np.prod(source.shape[1:], dtype=np.int64)) * source.dtype.itemsize
            if size == 0 or size % 4 or source.shape[1:] != target.shape[1:]:
                raise ValueError(
                    f"{target.name}: expected rows like {source.name}'s, of whole 4-byte words, "
                    f"got {source.shape} of {source.dtype} and {target.shape} of {target.dtype}"
                )
            words = (capacity, size // 4)
            self._launches.append(
                launch(
                    "stages_compact_rows", size // 4,
                    rows=source.view(words, np.uint32), kept_rows=target.view(words, np.uint32),
                    total=total,
                )
            )  # fmt: skip

    def __call__(self, timeline: Timeline) -> None:
        """Enqueue the compaction; never waits."""
        for launch in self._launches:
            launch(timeline)

    @property
    def scratch_bytes(self) -> int:
        """Device bytes that the compaction holds for itself."""
        return self._chunk_sums.size_bytes
