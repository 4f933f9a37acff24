"""Curved PN triangles, in float64 and in Vlachos's notation: Bernstein polynomials of ten points and six normals.

b300 belongs to P0 and weight w, b030 to P1 and u, b003 to P2 and v.
"""

from __future__ import annotations

import numpy as np

from lodbench.kernels.refine.reference import Doubles


def dot(a: Doubles, b: Doubles) -> Doubles:
    return (a * b).sum(-1, keepdims=True)


def unit(vectors: Doubles, otherwise: Doubles | float) -> Doubles:
    """Vectors at unit length, `otherwise` where there is no direction."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    none = length <= 1e-12
    return np.where(none, otherwise, vectors / np.where(none, 1, length))


def curve_handle(a: Doubles, b: Doubles, normal: Doubles, share: Doubles | float = 1.0) -> Doubles:
    """The control point beside a on the edge to b: a third of the way, bent into the tangent plane by `share`."""
    return (2 * a + b - share * dot(b - a, normal) * normal) / 3


def middle_normal(a: Doubles, b: Doubles, na: Doubles, nb: Doubles) -> Doubles:
    """The control normal of the edge between a and b; where it vanishes, the mean of its ends (reconstruction)."""
    d, total = b - a, na + nb
    square = dot(d, d)
    v = np.where(square > 0, 2 * dot(d, total) / np.where(square > 0, square, 1), 0)
    return unit(total - v * d, unit(total, na))


def control_points(P: Doubles, N: Doubles) -> dict[str, Doubles]:
    """The ten control points of each triangle, (m, 3) each, by their name.

    Args:
        P: corners, (m, 3 corners, 3) in model units.
        N: their unit normals, likewise.

    Source: Vlachos et al. 2001, section 3.1.
    """
    p, n = P.swapaxes(0, 1), N.swapaxes(0, 1)

    def near(i: int, j: int) -> Doubles:
        return curve_handle(p[i], p[j], n[i])

    b = {
        "b300": p[0], "b030": p[1], "b003": p[2],
        "b210": near(0, 1), "b120": near(1, 0), "b021": near(1, 2), "b012": near(2, 1),
        "b102": near(2, 0), "b201": near(0, 2),
    }  # fmt: skip
    E = sum(b[name] for name in ("b210", "b120", "b021", "b012", "b102", "b201")) / 6
    V = p.sum(0) / 3
    b["b111"] = E + (E - V) / 2
    return b


def control_normals(P: Doubles, N: Doubles) -> dict[str, Doubles]:
    """The six control normals of each triangle, (m, 3) each.

    Source: Vlachos et al. 2001, section 3.3.
    """
    p, n = P.swapaxes(0, 1), N.swapaxes(0, 1)

    def middle(i: int, j: int) -> Doubles:
        return middle_normal(p[i], p[j], n[i], n[j])

    return {
        "n200": n[0], "n020": n[1], "n002": n[2],
        "n110": middle(0, 1), "n011": middle(1, 2), "n101": middle(0, 2),
    }  # fmt: skip


def _weighted(terms: list[tuple[Doubles, Doubles]]) -> Doubles:
    """Sum of weights (n,) times vectors (m, 3): (m, n, 3)."""
    return sum(weight[None, :, None] * vector[:, None] for weight, vector in terms)  # type: ignore[return-value]


def cubic_points(b: dict[str, Doubles], wuv: Doubles) -> Doubles:
    """The cubic of ten control points at (n, 3) weights, (m, n, 3)."""
    w, u, v = wuv.T
    return _weighted([
        (w**3, b["b300"]), (u**3, b["b030"]), (v**3, b["b003"]),
        (3 * w**2 * u, b["b210"]), (3 * w * u**2, b["b120"]), (3 * w**2 * v, b["b201"]),
        (3 * u**2 * v, b["b021"]), (3 * w * v**2, b["b102"]), (3 * u * v**2, b["b012"]),
        (6 * w * u * v, b["b111"]),
    ])  # fmt: skip


def quadratic_normals(n: dict[str, Doubles], wuv: Doubles) -> Doubles:
    """The quadratic of six control normals, of any length: no factor 2 in the mixed terms."""
    w, u, v = wuv.T
    return _weighted([
        (w**2, n["n200"]), (u**2, n["n020"]), (v**2, n["n002"]),
        (w * u, n["n110"]), (u * v, n["n011"]), (w * v, n["n101"]),
    ])  # fmt: skip


def curved(P: Doubles, N: Doubles, wuv: Doubles) -> tuple[Doubles, Doubles]:
    """Points of the cubic patch and its quadratic normals, of any length, (m, n, 3) each; a `Reference`."""
    points = cubic_points(control_points(P, N), wuv)
    return points, quadratic_normals(control_normals(P, N), wuv)


def curved_with_linear_normals(P: Doubles, N: Doubles, wuv: Doubles) -> tuple[Doubles, Doubles]:
    """Points of the cubic patch, normals interpolated along the triangle; a `Reference`."""
    return curved(P, N, wuv)[0], wuv @ N
