"""How unlike the work of coarse triangles is: what makes neighbours on a GPU wait for each other.

Source: Concheiro 2013, chapters 3 and 4, for that divergence is what adaptive tessellation pays; the measures are ours.
"""

from __future__ import annotations

import numpy as np

from lodbench.kernels.bezier.candidates import Integers

LANES = 32  # coarse triangles that a GPU would run in step


def divergence(work: Integers) -> dict[str, float]:
    """How unlike the work of coarse triangles is.

    Returns:
        `work_spread`: standard deviation over mean. `lanes_used`: of 32 neighbours that wait for the slowest of them,
        the mean share of time in which one works.
    """
    if not len(work):
        return {"work_spread": 0.0, "lanes_used": 1.0}
    whole = np.zeros(-(-len(work) // LANES) * LANES)
    whole[: len(work)] = work
    slowest = whole.reshape(-1, LANES).max(axis=1).sum() * LANES
    padded = LANES - len(work) % LANES if len(work) % LANES else 0
    slowest -= padded * whole.reshape(-1, LANES)[-1].max()
    return {
        "work_spread": float(work.std() / work.mean()),
        "lanes_used": float(work.sum() / slowest),
    }
