"""Bicubic patches in float64 and in the thesis's notation: the oracle of all systems of the family."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Floats

Doubles = NDArray[np.float64]

DEGENERATE = 1e-11
"""Of the squared length of Q_u x Q_v, both of a patch of size near 1 and without their factor 3: below, there is no
normal."""
INWARDS = 2.0**-10
"""How far towards the patch's middle the normal is taken where it has none, as a share of the way."""


def bernstein(t: Doubles) -> Doubles:
    """J_{3,i}(t) of (n,) parameters, (n, 4).

    Source: Concheiro 2013, section 1.2 (Bernstein basis).
    """
    s = 1 - t
    return np.stack([s**3, 3 * s * s * t, 3 * s * t * t, t**3], axis=-1)


def bernstein_slopes(t: Doubles) -> Doubles:
    """J_{2,i}(t), (n, 3): the weights of a cubic's three control differences; its slope is three times their sum."""
    s = 1 - t
    return np.stack([s * s, 2 * s * t, t * t], axis=-1)


def patch_scales(P: NDArray[np.floating]) -> Floats:
    """The power of two that brings each patch's size near 1, (m,) float32: lengths are multiplied before squared."""
    P = np.asarray(P, np.float64)
    size = np.abs(P - P[:, :1, :1]).max(axis=(1, 2, 3), initial=0)
    exponents = np.frexp(np.where(size > 0, size, 1))[1]
    return np.ldexp(np.float32(1), np.clip(-exponents, -100, 100)).astype(np.float32)


def points_at(P: Doubles, u: Doubles, v: Doubles) -> Doubles:
    """Points of patches P, (m, 4, 4, 3), at (n,) parameters: (m, n, 3).

    Source: Concheiro 2013, section 1.2: Q(u, v) = sum B_ij J_{3,i}(u) J_{3,j}(v).
    """
    return np.einsum("ni,nj,mijk->mnk", bernstein(u), bernstein(v), P)


def _crossed(P: Doubles, u: Doubles, v: Doubles) -> Doubles:
    """Q_u x Q_v without their factors 3, of patches of size near 1."""
    P = P * patch_scales(P).astype(np.float64)[:, None, None, None]
    along_u = np.einsum("ni,nj,mijk->mnk", bernstein_slopes(u), bernstein(v), np.diff(P, axis=1))
    along_v = np.einsum("ni,nj,mijk->mnk", bernstein(u), bernstein_slopes(v), np.diff(P, axis=2))
    return np.cross(along_u, along_v)


def normals_at(P: Doubles, u: Doubles, v: Doubles) -> tuple[Doubles, NDArray[np.bool_]]:
    """Unit normals of patches P at (n,) parameters, (m, n, 3), and where they are the surface's own, (m, n).

    Where Q_u x Q_v vanishes, as at a collapsed edge, the normal is that of a place a little nearer to the patch's
    middle; where there is none either, (0, 0, 1).

    Source: Concheiro 2013, section 1.2; what is done at degenerate places is a reconstruction.
    """
    normals = _crossed(P, u, v)
    certain = (normals**2).sum(-1) > DEGENERATE
    inner = _crossed(P, u + INWARDS * (0.5 - u), v + INWARDS * (0.5 - v))
    normals = np.where(certain[..., None], normals, inner)
    length = np.linalg.norm(normals, axis=-1, keepdims=True)
    unit = normals / np.where(length > 1e-15, length, 1)
    return np.where(length > 1e-15, unit, (0.0, 0.0, 1.0)), certain
