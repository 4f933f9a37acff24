"""Adaptive tessellation by the test "mean", of whichever system: a grid for each cell, and edges that suit both."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels.bezier.adaptive import Adaptive
from lodbench.kernels.bezier.adaptive_check import Wished, judged
from lodbench.kernels.bezier.adaptive_params import AdaptiveParams
from lodbench.kernels.bezier.candidates import Flags, Integers
from lodbench.kernels.bezier.grids import MEAN_SHARE, SUMMED, rings, surface_area
from lodbench.kernels.bezier.lattice import side_vertices
from lodbench.kernels.bezier.rises import corner_ring, held
from lodbench.kernels.bezier.tessellated import CONTROL_FLOATS
from lodbench.kernels.launching import group_size
from lodbench.kernels.opencl import Device
from lodbench.kernels.system import Check

LEAST_AREA = 1e-6
"""Of all patches, in squares of the diagonal: less is that of a line, and of roundings."""


class Gridded(Adaptive):
    """Patches whose cells take grids: see `lodbench.kernels.bezier.grids`.

    Attributes:
        area: of all patches, in squares of the diagonal, at least `LEAST_AREA`.
        ring: of each edge of each cell the next that is one with it, (4 cells,).
        corner_ring: of each corner likewise.
        held: edges and corners that stay on the surface, (cells,).
    """

    def __init__(self, device: Device, patches: BezierPatches, params: AdaptiveParams) -> None:
        super().__init__(device, patches, params)
        cells, local = self.cells, group_size(device)
        self.build("bezier/grids.cl", "bezier/grid_pieces.cl")
        area = surface_area(patches.points.astype(np.float64), self._inverse)
        self.area = max(area, LEAST_AREA)
        self.ring = rings(self._borders, params.base)
        self.corner_ring = corner_ring(self._borders, params.base)
        self.held = held(self._borders, params.base)
        with self.setup.host("upload"):
            ring = self.upload("ring", self.ring, role="pattern")
            corners = self.upload("corners", self.corner_ring, role="pattern")
            stays = self.upload("held", self.held, role="pattern")
        self._wishes = self.allocate("wishes", cells, np.uint32)
        self._rises = self.allocate("rises", 2 * cells, np.int32)
        choosing = self._tests.launch(
            "bezier_grids_choose", cells, stage="geometry_test", local=local, map=self._map,
            controls=self._controls, wishes=self._wishes, rises=self._rises,
            inverse=self._inverse, mean=MEAN_SHARE[params.rises],
            price=min(params.least * self.area * SUMMED, 1e38), map_stride=self._map.shape[1],
            side=side_vertices(self._level), depth=params.finest_depth, cell_count=cells,
        )  # fmt: skip
        self.add(choosing, bytes=4 * CONTROL_FLOATS * self.count + 12 * cells)
        testing = self._tests.launch(
            "bezier_grid_pieces_test", cells, stage="geometry_test", local=local, wishes=self._wishes,
            ring=ring, masks=self._masks, **self._sizes, cell_count=cells,
        )  # fmt: skip
        self.add(testing, bytes=44 * cells)
        emitted = {
            "wishes": self._wishes, "rises": self._rises, "ring": ring, "corner_ring": corners,
            "held": stays, "diagonal": 1 / self._inverse if params.rises else 0.0,
        }  # fmt: skip
        self.finish("bezier_grid_pieces_emit", emitted)

    def wishes(self) -> Integers:
        """The grid that each cell wishes for, (cells,): see `grids`."""
        return self.device.read(self._wishes).astype(np.int64)

    def rises(self) -> Integers:
        """How far each half of each cell rises, (cells, 2), in `rises.UNITS` of a diagonal."""
        return self.device.read(self._rises).astype(np.int64).reshape(-1, 2)

    def work(self, flags: Flags) -> NDArray[np.int64]:
        """Vertices emitted; each cell compares as many grids."""
        return flags.sum(axis=-1)

    def check(self) -> Check:
        """As of the other tests; wishes are compared by what they cost."""
        (mesh,) = self.result()
        return judged(
            self._patches, self._params, None, mesh, self.masks(), self.vertex_places(),
            Wished(self.wishes(), self.rises(), self.ring, self.corner_ring, self.held, self.area),
        )  # fmt: skip


def by_test(kind: Callable[..., Adaptive]) -> Callable[..., Adaptive]:
    """A system's `prepare`: `kind`, but for the test "mean", which asks for no candidates and is the same for all."""

    def prepare(device: Device, patches: BezierPatches, params: Any) -> Adaptive:
        made = Gridded if params.test == "mean" else kind
        return made(device, patches, params)

    return prepare
