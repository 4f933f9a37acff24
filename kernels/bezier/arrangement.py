"""Where a system puts the vertices of a patch: which virtual vertex each slot of the output holds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Indices
from lodbench.kernels.bezier.borders import Numbers


@dataclass(frozen=True, eq=False)
class Arrangement:
    """The output of one patch; others follow it with the same.

    Attributes:
        places: (slots,) the virtual vertex in each slot.
        triangles: (t, 3) uint32, of slots.
    """

    places: Numbers
    triangles: Indices

    def slot_pairs(self, seams: Numbers) -> NDArray[np.uint32]:
        """Every slot that has another's normal, and that other slot, (k, 2); `seams` as `borders.seams` has them."""
        order = np.argsort(self.places, kind="stable")
        first, count = np.unique(self.places[order], return_index=True, return_counts=True)[1:]
        slots = len(self.places)
        patch, vertex, other, other_vertex = seams.T
        copies = count[vertex]
        within = np.arange(copies.sum()) - np.repeat(np.cumsum(copies) - copies, copies)
        target = order[np.repeat(first[vertex], copies) + within]
        target = target + slots * np.repeat(patch, copies)
        source = np.repeat(order[first[other_vertex]] + slots * other, copies)
        return np.stack([target, source], axis=1).astype(np.uint32)
