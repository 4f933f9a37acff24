"""A work-item for each cell of each patch: test and count, scan, emit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels.bezier.adaptive import Adaptive
from lodbench.kernels.bezier.candidates import Flags, candidate_masks
from lodbench.kernels.bezier.dabt.params import Params
from lodbench.kernels.bezier.dabt.reference import candidates, inserted
from lodbench.kernels.opencl import Device


class Dabt(Adaptive):
    """Patches under dynamic and adaptive tessellation: see `lodbench.kernels.bezier.dabt`."""

    inserted = staticmethod(inserted)

    def __init__(self, device: Device, patches: BezierPatches, params: Params) -> None:
        super().__init__(device, patches, params)
        with self.setup.host("upload"):
            pattern = self.upload("candidates", candidate_masks(), role="pattern")
        self.build("bezier/dabt/geometry.cl")
        self.prepare("dabt_geometry", {"candidates": pattern}, {})

    def work(self, flags: Flags) -> NDArray[np.int64]:
        """Candidates tested, which depend on the levels of the edges, and vertices emitted."""
        return candidates(flags, self._params.finest_depth).sum(axis=-1) + flags.sum(axis=-1)
