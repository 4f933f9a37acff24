"""How far a surface moves from one view of a camera path to the next, where nothing but its level of detail changes.

Source: Boubekeur & Schlick 2005, section 6, names popping between levels as what remains; the measure is ours.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.system import Parametric, Prepared

MOST_POINTS = 10_000_000  # of a surface that is looked at


class Moves:
    """The largest move of any point, between each view and the one before, in bounding-box diagonals."""

    def __init__(self) -> None:
        self._last: NDArray[np.float32] | None = None
        self._moved: list[float | None] = []

    def see(self, prepared: Prepared, diagonal: float) -> None:
        """Look at the last frame; nothing is known of a subject whose parameters change with its level."""
        points = prepared.at_parameters() if isinstance(prepared, Parametric) else None
        if points is not None and len(points) > MOST_POINTS:
            points = None
        moved = None
        if points is not None and self._last is not None and len(points):
            square = ((points - self._last) ** 2).sum(axis=1).max()
            moved = float(np.sqrt(square)) / (diagonal or 1.0)
        self._last = points
        self._moved.append(moved)

    def to(self, step: int) -> dict[str, float]:
        """`moved`: on the way to this view, from the one before; nothing where it is not known."""
        moved = self._moved[step] if step < len(self._moved) else None
        return {} if moved is None else {"moved": moved}
