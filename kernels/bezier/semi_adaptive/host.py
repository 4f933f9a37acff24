"""A pattern for each combination of edges, made once; then a work-item for each cell: test, scan, emit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels.bezier.adaptive import MOST_TRIANGLES, Adaptive
from lodbench.kernels.bezier.candidates import INSIDE, LEVEL, Flags, candidate_masks
from lodbench.kernels.bezier.semi_adaptive.params import Params
from lodbench.kernels.bezier.semi_adaptive.reference import HALVES, inserted, pattern_count
from lodbench.kernels.opencl import Device, Timeline

WORDS = 3 * MOST_TRIANGLES // 4  # of a pattern's list, a corner in each byte


class SemiAdaptive(Adaptive):
    """Patches under semi-adaptive tessellation: see `lodbench.kernels.bezier.semi_adaptive`.

    Attributes:
        shapes: on the device, the nodes of each pattern.
        lists: likewise, the ranks of the corners of its triangles, four in a word.
    """

    inserted = staticmethod(inserted)

    def __init__(self, device: Device, patches: BezierPatches, params: Params) -> None:
        super().__init__(device, patches, params)
        count = pattern_count(params.finest_depth)
        self.shapes = self.allocate("shapes", count, np.uint64, "pattern")
        self.lists = self.allocate("lists", (count, WORDS), np.uint32, "pattern")
        with self.setup.host("upload"):
            pattern = self.upload("candidates", candidate_masks(), role="pattern")
        folder = "bezier/semi_adaptive"
        program = self.build(
            f"{folder}/setup.cl", f"{folder}/geometry.cl", HALVES=HALVES[params.finest_depth]
        )
        with self.setup.host("patterns"):
            making = program.launch(
                "semi_adaptive_setup_patterns", count, stage="setup",
                shapes=self.shapes, lists=self.lists,
            )  # fmt: skip
            making(Timeline())
            device.wait()
        numbers = self.allocate("numbers", 2 * self.cells, np.uint32)
        self.prepare(
            "semi_adaptive_geometry",
            {"candidates": pattern, "shapes": self.shapes, "numbers": numbers},
            {"candidates": pattern, "lists": self.lists, "numbers": numbers},
        )  # fmt: skip

    def work(self, flags: Flags) -> NDArray[np.int64]:
        """Candidates on edges, as many for each, and vertices emitted."""
        on_edges = ~INSIDE & (LEVEL > 0) & (LEVEL <= self._params.finest_depth)
        return on_edges.sum() + flags.sum(axis=-1)
