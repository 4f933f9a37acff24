"""Scalar tagged triangles, in float64: PN triangles with tagged control points and normals (reconstruction ST-R)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.refine.pn_triangles.reference import (
    cubic_points,
    curve_handle,
    dot,
    middle_normal,
    quadratic_normals,
    unit,
)
from lodbench.kernels.refine.reference import Doubles

TURN = np.pi / 4  # the most that a bias turns a crease


def tagged(
    P: Doubles, N: Doubles, wuv: Doubles, tags: Doubles, from_p2: NDArray[np.bool_]
) -> tuple[Doubles, Doubles]:
    """Points and normals of any length, (m, n, 3) each.

    Args:
        P: corners, (m, 3 corners, 3) in model units, the one of lowest number first.
        N: their unit normals, likewise.
        wuv: (n, 3) weights.
        tags: (m, 3, 3): the tension of P0, P1, P2, then the sharpness of edges P0 P1, P1 P2, P2 P0, then their bias.
        from_p2: (m,): does edge P1 P2 run from P2?
    """
    p, n = (values.swapaxes(0, 1) for values in (P, N))
    tension, sharp, bias = (tags[:, k].T[..., None] for k in range(3))
    edges = ((0, 1), (1, 2), (2, 0))
    s = {frozenset(e): sharp[k] for k, e in enumerate(edges)}
    beta = {frozenset(e): bias[k] for k, e in enumerate(edges)}
    axis = {
        frozenset((0, 1)): unit(p[1] - p[0], 0), frozenset((2, 0)): unit(p[2] - p[0], 0),
        frozenset((1, 2)): unit(np.where(from_p2[:, None], p[1] - p[2], p[2] - p[1]), 0),
    }  # fmt: skip
    face = unit(np.cross(p[1] - p[0], p[2] - p[0]), unit(n.sum(0), n[0]))

    def handle(i: int, j: int, share: Doubles | float = 1.0) -> Doubles:
        return curve_handle(p[i], p[j], n[i], (1 - tension[i]) * share)

    def side(i: int, j: int) -> Doubles:
        """This face's normal at corner i for its edge to corner j."""
        e = frozenset((i, j))
        pulled = unit((1 - s[e]) * n[i] + s[e] * face, face)
        angle, d = s[e] * beta[e] * TURN, axis[e]
        turned = (
            pulled * np.cos(angle) + np.cross(d, pulled) * np.sin(angle)
            + d * dot(d, pulled) * (1 - np.cos(angle))
        )  # fmt: skip
        return np.where(s[e] == 0, n[i], turned)

    def mean(share: dict[frozenset[int], Doubles] | None = None) -> Any:
        return sum(
            handle(i, j, 1.0 if share is None else share[frozenset((i, j))])
            for a, b in edges for i, j in ((a, b), (b, a))
        ) / 6  # fmt: skip

    b = {
        "b300": p[0], "b030": p[1], "b003": p[2], "b210": handle(0, 1), "b120": handle(1, 0),
        "b021": handle(1, 2), "b012": handle(2, 1), "b102": handle(2, 0), "b201": handle(0, 2),
    }  # fmt: skip
    E, V = mean(), p.sum(0) / 3
    sigma = sum(s.values()) / 3
    b["b111"] = (1 - sigma) * (E + (E - V) / 2) + sigma * mean({e: 1 - s[e] for e in s})

    def corner(i: int, j: int, k: int) -> Doubles:
        smooth = (s[frozenset((i, j))] == 0) & (s[frozenset((i, k))] == 0)
        return np.where(smooth, n[i], unit(side(i, j) + side(i, k), n[i]))

    normals = {
        "n200": corner(0, 1, 2), "n020": corner(1, 2, 0), "n002": corner(2, 0, 1),
        "n110": middle_normal(p[0], p[1], side(0, 1), side(1, 0)),
        "n011": middle_normal(p[1], p[2], side(1, 2), side(2, 1)),
        "n101": middle_normal(p[0], p[2], side(0, 2), side(2, 0)),
    }  # fmt: skip
    return cubic_points(b, wuv), quadratic_normals(normals, wuv)
