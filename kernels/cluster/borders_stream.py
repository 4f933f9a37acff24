"""Border edges of a mesh file that need not fit into memory: those that `borders.border_edges` finds in core.

A first walk over the triangles adds signed hashes of edges to both their ends, which cancel wherever an edge is used as
often in one direction as in the other. Where all do, that was it. A second walk collects the edges between vertices
whose hashes do not cancel, hardly more than the border's, and which of them are used once is decided as in core. Where
they are too many at a time, as of a file whose triangles share nothing, it takes them in several walks, each those with
other hashes of their two places. What is kept in the end is a bit for each edge.

Source: none.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.batches import Batch, MeshFile, ahead, pieces
from lodbench.kernels.cluster.borders import NO_VERTICES, places, single, unordered
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.stages.scan import chunk_count, chunk_local

FILE = "cluster/borders_batch.cl"
_AT_ONCE = 4  # edges collected at a time, by triangles of a batch
_MOST_PARTS = 1 << 16
_LEAST_SLOTS = 1 << 10
_TABLE_SHARE = 2  # of the device's memory: one part of so many for the hashes


class _Edges(NamedTuple):
    """Candidates: their numbers in the file, (k,); their ends' rows, (k, 2), and where those lie, (k, 2, 3)."""

    numbers: NDArray[np.int64]
    ends: NDArray[np.uint32]
    positions: NDArray[np.float32]

    def those(self, which: NDArray[Any]) -> _Edges:
        return _Edges(self.numbers[which], self.ends[which], self.positions[which])


class StreamBorders:
    """The border edges of a file, in the order of its triangles.

    Attributes:
        count: how many there are.
    """

    def __init__(
        self, device: Device, source: MeshFile, rows: int, told: Callable[[float], None]
    ) -> None:
        """Find them.

        Args:
            device: where they are looked for.
            source: the file, whose box is known.
            rows: triangles of a batch.
            told: called with the share that is done.
        """
        self._device, self._source, self._rows = device, source, rows
        self._program = device.build(FILE)
        slots = 1 << max(source.vertex_count - 1, 1).bit_length()
        while slots > _LEAST_SLOTS and 4 * slots > device.memory_limit // _TABLE_SHARE:
            slots >>= 1
        self._marks = device.allocate("marks", slots, np.int32)
        device.fill(Timeline(), "borders", self._marks, 0)
        self.count, self._bits = 0, np.zeros(0, np.uint8)
        count = source.triangle_count
        for done, keys in self._keys():
            self._launch("mark", keys, 1 if device.is_cpu else None)
            told(0.5 * done / count)
        if self._unbalanced():
            # in whole bytes of eight edges each; what is never written takes no memory
            self._bits = np.zeros(-(-3 * count // 8), np.uint8)
            self._collect(lambda share: told(0.5 + 0.5 * share))
        del self._marks

    def _keys(self) -> Iterator[tuple[int, NDArray[np.uint32]]]:
        """A number for each corner's vertex, batch by batch, (k, 3), and triangles so far.

        Rows of the file where triangles share them, else hashes of where they lie.
        """
        source = self._source
        found = pieces(source.triangle_count, self._rows)
        if source.shared:
            yield from ahead((stop, source.corners(start, stop)) for start, stop in found)
        else:
            yield from ahead(
                (stop, _hashes(source.batch(start, stop, slice(None)).positions).reshape(-1, 3))
                for start, stop in found
            )

    def _launch(
        self, name: str, keys: NDArray[np.uint32], chunks: int | None = None, **more: Any
    ) -> None:
        device, count = self._device, len(keys)
        chunks = chunks or chunk_count(device, max(count, 1))
        self._program.launch(
            f"cluster_borders_batch_{name}", chunks, stage="borders", local=chunk_local(device),
            keys=device.upload("keys", keys), marks=self._marks, slot_mask=self._marks.shape[0] - 1,
            triangle_count=count, chunk_count=chunks, **more,
        )(Timeline())  # fmt: skip

    def _unbalanced(self) -> bool:
        """Is there a vertex with an edge that does not cancel?"""
        return bool(self._device.read(self._marks).any())

    def _candidates(self, keys: NDArray[np.uint32]) -> NDArray[np.int64]:
        """Edges of a batch between marked vertices: three times the triangle and 0, 1 or 2, ascending."""
        device = self._device
        sums = device.allocate("chunk_sums", chunk_count(device, max(len(keys), 1)), np.uint32)
        self._launch("count", keys, chunk_sums=sums)
        edges = device.allocate("edges", int(device.read(sums).sum(dtype=np.int64)), np.uint32)
        self._launch("write", keys, chunk_sums=sums, edges=edges)
        return device.read(edges).astype(np.int64)

    def _collect(self, told: Callable[[float], None]) -> None:
        """Walks over the file, each for its part of the candidates; a part that is too large becomes two."""
        todo, walks, most = [(0, 1)], 0, _AT_ONCE * self._rows
        while todo:
            part, parts = todo.pop()
            held, first = _none(), 0
            for done, keys in self._keys():
                found = self._edges(first, keys)
                held = _joined(held, found.those(_part_of(found, parts) == part))
                first = done
                if len(held.numbers) > most:
                    held = _fewer(held, self._source.shared)
                while len(held.numbers) > most // 2 and parts < _MOST_PARTS:
                    todo.append((part + parts, 2 * parts))
                    parts *= 2
                    held = held.those(_part_of(held, parts) == part)
                told(1 - 0.25 ** (walks + done / self._source.triangle_count))
            walks += 1
            numbers = _used_once(held, self._source.shared)
            self.count += len(numbers)
            bits = np.uint8(128) >> (numbers & 7).astype(np.uint8)
            np.bitwise_or.at(self._bits, numbers >> 3, bits)

    def _edges(self, first: int, keys: NDArray[np.uint32]) -> _Edges:
        """The candidates of the batch whose first triangle is `first`."""
        edges = self._candidates(keys)
        if not len(edges):
            return _none()
        triangle, corner = np.divmod(edges, 3)
        turn = np.stack([corner, (corner + 1) % 3], axis=1)
        if self._source.shared:
            ends = keys[triangle[:, None], turn]
            positions = self._source.at(ends.ravel()).reshape(-1, 2, 3)
        else:
            ends = np.zeros((len(edges), 2), np.uint32)  # told apart by where they lie
            low = int(triangle[0])
            batch = self._source.batch(first + low, first + int(triangle[-1]) + 1, slice(None))
            positions = batch.positions.reshape(-1, 3, 3)[(triangle - low)[:, None], turn]
        return _Edges(3 * first + edges, ends, positions)

    # what was found

    def edges(self) -> Iterator[Batch]:
        """The border edges, in order, batch by batch: as triangles from, to and the third corner."""
        for start, stop in pieces(self._source.triangle_count if self.count else 0, self._rows):
            low, high = 3 * start // 8, -(-3 * stop // 8)
            if not self._bits[low:high].any():
                continue
            bits = np.unpackbits(self._bits[low:high])[3 * start - 8 * low :][: 3 * (stop - start)]
            border = bits.reshape(-1, 3).astype(bool)
            which = np.asarray(border.any(axis=1))
            if not which.any():
                continue
            batch = self._source.batch(start, stop, which)
            turned = np.stack([np.roll(batch.triangles, -k, axis=1) for k in range(3)], axis=1)
            yield Batch(
                batch.positions, np.ascontiguousarray(turned[border[which]]), batch.vertices
            )

    def vertices(self) -> NDArray[np.uint32]:
        """Rows of their ends in the file, ascending."""
        found = [NO_VERTICES]
        for batch in self.edges():
            rows = np.unique(batch.triangles[:, :2])
            given = batch.vertices
            found.append(
                (rows + given if isinstance(given, int) else given[rows]).astype(np.uint32)
            )
        return np.unique(np.concatenate(found))


def _hashes(positions: NDArray[np.float32]) -> NDArray[np.uint32]:
    """Of where vertices lie, (k,)."""
    x, y, z = (positions + np.float32(0)).reshape(-1, 3).view(np.uint32).T  # -0 is 0
    hashes = x * np.uint32(0x9E3779B1)
    for axis in (y, z):
        hashes = ((hashes ^ hashes >> np.uint32(15)) + axis) * np.uint32(0x2C1B3C6D)
    return hashes ^ hashes >> np.uint32(12)


def _part_of(edges: _Edges, parts: int) -> NDArray[np.uint32]:
    """Which of `parts`, a power of two, an edge belongs to: by where its ends lie, whichever way."""
    if parts == 1:
        return np.zeros(len(edges.numbers), np.uint32)
    both = _hashes(edges.positions).reshape(-1, 2)
    mixed = (both[:, 0] + both[:, 1]) * np.uint32(0x297A2D39)
    return (mixed >> np.uint32(8)) % np.uint32(parts)


def _none() -> _Edges:
    return _Edges(
        np.zeros(0, np.int64), np.zeros((0, 2), np.uint32), np.zeros((0, 2, 3), np.float32)
    )


def _joined(*parts: _Edges) -> _Edges:
    numbers, ends, positions = (np.concatenate(values) for values in zip(*parts, strict=True))
    return _Edges(numbers, ends, positions)


def _ends(edges: _Edges, shared: bool) -> NDArray[np.integer]:
    """Numbers of their vertices, (k, 2): where the format shares none, those at one place are one."""
    return edges.ends if shared else places(edges.positions.reshape(-1, 3)).reshape(-1, 2)


def _fewer(edges: _Edges, shared: bool) -> _Edges:
    """No more than two uses of each edge, which say as much as all; in order."""
    keys = unordered(_ends(edges, shared))
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    kept = np.ones(len(keys), bool)
    kept[2:] = keys[2:] != keys[:-2]
    return edges.those(np.sort(order[kept]))


def _used_once(edges: _Edges, shared: bool) -> NDArray[np.int64]:
    """The numbers of those that `borders.used_once` leaves."""
    alone = edges.those(single(_ends(edges, shared)))
    if shared:
        alone = alone.those(single(_ends(alone, False)))
    return alone.numbers
