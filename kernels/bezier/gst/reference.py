"""Geometry shader tessellation in float64: the surface by powers, one row of samples at a time."""

from __future__ import annotations

import numpy as np

from lodbench.kernels.bezier.reference import Doubles

N = np.array([(1, 3, 3, 1), (-6, -6, 6, 6), (12, -12, -12, 12), (-8, 24, -24, 8)]) / 8
"""From control points to powers of t - 1/2."""


def coefficients(P: Doubles) -> Doubles:
    """C = N P N^T of patches (m, 4, 4, 3): what is evaluated before sampling.

    Source: Concheiro 2013, section 2.3; powers about the middle, where theirs are about the corner, round less.
    """
    return np.einsum("ai,bj,mijk->mabk", N, N, P)


def sampled(P: Doubles, level: int) -> Doubles:
    """Points of patches at the (2^level + 1)^2 virtual vertices, (m, n + 1, n + 1, 3): U C, then (U C) V."""
    t = np.arange((1 << level) + 1) / (1 << level) - 0.5
    powers = t[:, None] ** np.arange(4)
    rows = np.einsum("ra,mabk->mrbk", powers, coefficients(P))
    return np.einsum("cb,mrbk->mrck", powers, rows)
