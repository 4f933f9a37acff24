"""Clustering, then edge collapse of what it leaves, both on the device; between them the host takes cells apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster import octree, quadric_clustering
from lodbench.kernels.cluster.clustering import Clustering
from lodbench.kernels.cluster.edge_collapse.fit import Input
from lodbench.kernels.cluster.edge_collapse.host import EdgeCollapse
from lodbench.kernels.cluster.edge_collapse.prepare import prepare as edge_collapse
from lodbench.kernels.cluster.edge_collapse.verdict import verdict
from lodbench.kernels.cluster.hybrid.joined import Joined, euler_but_border, joined
from lodbench.kernels.cluster.hybrid.params import Params
from lodbench.kernels.cluster.turned import NO_VERTEX
from lodbench.kernels.cluster.unchanged import Unchanged
from lodbench.kernels.opencl import Buffer, Device, Timeline
from lodbench.kernels.subject import DeviceSubject
from lodbench.kernels.system import Check, Footprint, Frame
from lodbench.kernels.targets import missed

FINER = 2.0  # a first stage that changes the surface is done anew with so many times the triangles


class Hybrid(DeviceSubject):
    """One mesh; each frame is a whole call, from host arrays on: its sizes are known as it goes.

    Attributes:
        mesh: what is simplified.
        params: how far, and how.
        target: triangles that may be left.
        first: what the clustering left in the last frame; None where edge collapse began with the mesh itself.
        second: edge collapse of that.
        tries: clusterings of the last frame.
    """

    second: EdgeCollapse | Unchanged

    def __init__(
        self,
        device: Device,
        mesh: TriangleMesh,
        params: Params,
        locked: NDArray[np.bool_] | None = None,
        warm: bool = True,
    ) -> None:
        super().__init__(device)
        self.mesh, self.params, self.locked = mesh, params, locked
        self.target = params.left(mesh.triangle_count)
        self.first: Joined | None = None
        self.tries = 0
        self._to: Input | None = None
        if warm:
            self.warm_up()

    def enqueue(self, frame: Frame, timeline: Timeline) -> None:
        """All of it; waits for the clustering."""
        self.frame, self._rows = frame, None
        self.first = self._first(timeline)
        mesh = self.mesh if self.first is None else self.first.mesh
        params = self.params.collapse(max(self.target, 1))
        self.second = edge_collapse(self.device, mesh, params, self._locked(), to=self._to)
        self.second.enqueue(frame, timeline)
        self.output = self.second.output
        self._enqueued = self.second._enqueued  # pyright: ignore[reportPrivateUsage]

    def _first(self, timeline: Timeline) -> Joined | None:
        """What a clustering leaves that is the surface it was; None where that would save nothing."""
        mesh, wanted = self.mesh, self.params.coarse(self.mesh.triangle_count)
        self.tries, self._to = 0, None
        while 0 < wanted < mesh.triangle_count:
            self.tries += 1
            clustered = self._clustered(wanted)
            if not isinstance(clustered, Clustering):
                return None
            clustered.enqueue(Frame(), timeline)
            simplified, vertex_map = clustered.read_back()
            positions, triangles = clustered.given
            with timeline.host("join"):
                found = joined(
                    self.device, triangles, mesh.positions, simplified, vertex_map, self.locked
                )
                if not found.surface or self._same(triangles, found):
                    vertex_map = self.device.upload("first", found.vertex_map, lent=True)
                    self._to = Input(positions, triangles, vertex_map)
                    return found
            params = replace(self.params, factor=FINER * wanted / max(self.target, 1))
            wanted = params.coarse(mesh.triangle_count)
        return None

    def _clustered(self, wanted: int) -> Any:
        """A clustering whose border vertices stay by themselves: the second stage sees to these."""
        system: Any = octree if self.params.first == "octree" else quadric_clustering
        params = system.Params(target_count=wanted, border="keep")
        return system.SYSTEM.prepare(self.device, self.mesh, params)

    def _same(self, triangles: Buffer, found: Joined) -> bool:
        """As many vertices - edges + triangles as before? Border edges are the same: those on borders stay single."""
        now = 2 * found.mesh.vertex_count - found.mesh.triangle_count
        return now == euler_but_border(self.device, triangles, self.mesh.vertex_count)

    def _locked(self) -> NDArray[np.bool_] | None:
        """Vertices of the second stage that stay where they are."""
        if self.locked is None or self.first is None:
            return self.locked
        to = self.first.vertex_map[self.locked]
        locked = np.zeros(self.first.mesh.vertex_count, bool)
        locked[to[to != NO_VERTEX]] = True
        return locked

    def footprint(self) -> Footprint:
        """That of the second stage, which holds its memory while the first has returned its own."""
        self.live()
        return self.second.footprint()

    def result(self) -> Sequence[TriangleMesh]:
        """The last frame's mesh."""
        self.live()
        return self.second.result()

    def live_rows(self) -> list[tuple[int, int]]:
        """Of the last frame; one is run where there was none."""
        if self.frame is None:
            self.enqueue(Frame(), Timeline())
        return self.second.live_rows()

    def vertex_map(self) -> NDArray[np.uint32]:
        """The last frame's output vertex of each input vertex, (n,); 0xFFFFFFFF where no triangle has it."""
        fit = getattr(self.second, "fit", None)
        if fit is not None:
            self.live()
            return self.device.read(fit.whole_map)
        found = self.second.vertex_map()
        if self.first is None:
            return found
        return np.append(found, NO_VERTEX)[np.minimum(self.first.vertex_map, np.uint32(len(found)))]

    def sources(self) -> NDArray[np.uint32]:
        """The input triangle of each output triangle of the last frame, corner by corner."""
        self.live()
        if isinstance(self.second, Unchanged):
            rows = np.arange(self.second.live()[1], dtype=np.uint32)
        else:
            rows = self.second.sources()
        return rows if self.first is None else self.first.sources[rows]

    def more_counters(self) -> Mapping[str, int | float]:
        """Sizes in, what the clustering left, and how near the target is."""
        first = self.first
        more = {
            name: value
            for name, value in self.second.more_counters().items()
            if name in ("sweeps", "collapses")
        }
        return {
            "vertices_in": self.mesh.vertex_count, "triangles_in": self.mesh.triangle_count,
            "first_triangles": first.mesh.triangle_count if first else self.mesh.triangle_count,
            "first_apart": first.apart if first else self.mesh.vertex_count,
            "first_tries": self.tries, **more, **missed(self.target, self.live()[1]),
        }  # fmt: skip

    def check(self) -> Check:
        """As edge collapse's, of the whole way from the input."""
        self.live()
        return verdict(self)  # pyright: ignore[reportArgumentType]


def prepare(
    device: Device,
    mesh: TriangleMesh,
    params: Params,
    locked: NDArray[np.bool_] | None = None,
) -> Hybrid:
    """A first frame run already, so that those that follow find everything compiled.

    Args:
        device: where it runs.
        mesh: what is simplified.
        params: how far, and how.
        locked: (n,), vertices that stay where they are.

    Raises:
        Unsupported: no room on the device.
    """
    return Hybrid(device, mesh, params, locked)
