"""The flat surface, in float64 and in the paper's notation."""

from __future__ import annotations

from lodbench.kernels.refine.reference import Doubles


def flat(P: Doubles, N: Doubles, wuv: Doubles) -> tuple[Doubles, Doubles]:
    """Points and normals interpolated along each triangle: w P0 + u P1 + v P2.

    Args:
        P: corners, (m, 3 corners, 3) in model units.
        N: their normals, (m, 3 corners, 3), unit length.
        wuv: (n, 3) weights.

    Returns:
        Points and normals of any length, (m, n, 3) each.

    Source: Boubekeur & Schlick 2005, section 3.2.
    """
    return wuv @ P, wuv @ N
