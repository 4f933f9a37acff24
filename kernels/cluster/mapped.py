"""What a simplification on the device knows of its vertices: the output vertex of each input vertex."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.opencl import Buffer, Launch, Timeline
from lodbench.kernels.subject import DeviceSubject


class Mapped(DeviceSubject):
    """A subject that maps its input's vertices when asked, or in every frame once `map_vertices` was called.

    A system says in `mapping` how.
    """

    _map_out: Buffer | None = None  # that every frame fills
    _vertex_map: NDArray[np.uint32]  # of the last frame, once its counts were read

    def mapping(self) -> tuple[Launch, Buffer]:
        """What writes `vertex_map`, and where to."""
        raise NotImplementedError(f"{type(self).__name__}.mapping: expected of every system")

    def map_vertices(self) -> None:
        """Have each frame fill `vertex_map` too: read with its counts, it needs no wait of its own."""
        launch, self._map_out = self.mapping()
        self.add(launch)

    def vertex_map(self) -> NDArray[np.uint32]:
        """The last frame's output vertex of each input vertex, (n,); 0xFFFFFFFF where no triangle has it."""
        if self._map_out is None:
            return self.device.read(self.map_now())
        self.live()
        return self._vertex_map

    def map_now(self) -> Buffer:
        """`vertex_map` on the device, of the last frame; never waits."""
        launch, result = self.mapping()
        launch(Timeline())
        return result

    def read_counts(self, counts: Sequence[Buffer]) -> Sequence[NDArray[np.uint32]]:
        """As every subject's; read with them is the vertex map, if frames fill it."""
        more = () if self._map_out is None else (self._map_out,)
        found = self.device.read_all(*((buffer, None) for buffer in (*counts, *more)))
        if more:
            self._vertex_map = found.pop()
        return found
