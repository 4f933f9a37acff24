"""As few segments on each span as keep triangles near their surface; measured in float64 on the host."""

from __future__ import annotations

import numpy as np

from lodbench.datasets_gen.nurbs_surface import Doubles, NurbsModel, NurbsSurface
from lodbench.kernels.nurbs.borders import Borders
from lodbench.kernels.nurbs.reference import points_at
from lodbench.kernels.nurbs.samples import Numbers, Samples, first_knots

PARTS = 4  # of a segment, at whose ends distances are measured
MARGIN = 0.93  # of the tolerance that measured distances may have, for what lies between
MOST_GROWTH = 16
ROUNDS = 40
MOST_VERTICES = 1 << 26
MOST_MEASURED = 1 << 25  # points of one surface at which distances are measured: 2 GB in float64

Counts = list[list[Numbers]]
"""Segments of each span of u and v of each surface."""


def within(
    model: NurbsModel, borders: Borders, tolerance: float
) -> tuple[list[tuple[Samples, Samples]], float]:
    """Samples of each surface, and the largest distance measured, as a share of the box's diagonal.

    The distance is that of points on triangles to the surface's points at the same parameters, which is no less than
    that to the surface. Spans have one segment at the least, and sides of borders that surfaces share have the same.

    Args:
        model: whose surfaces are sampled.
        borders: of the model.
        tolerance: largest distance, as a share of the diagonal.

    Raises:
        ValueError: more vertices than one would want.
    """
    counts: Counts = [
        [np.ones(len(first_knots(knots)), np.int64) for knots in (s.knots_u, s.knots_v)]
        for s in model.surfaces
    ]
    size = diagonal(model)
    limit = MARGIN * tolerance * size
    worst = np.zeros(len(counts))
    changed = np.ones(len(counts), bool)
    for _ in range(ROUNDS):
        before = [[side.copy() for side in sides] for sides in counts]
        for s in np.flatnonzero(changed):
            worst[s] = _refine(model.surfaces[s], counts[s], limit)
        _agree(counts, borders)
        total = sum(int((u.sum() + 1) * (v.sum() + 1)) for u, v in counts)
        largest = max((int(u.sum() * v.sum()) for u, v in counts), default=0)
        if total > MOST_VERTICES or PARTS**2 * largest > MOST_MEASURED:
            raise ValueError(
                f"tolerance: expected one that at most {MOST_VERTICES:,} vertices keep, "
                f"{MOST_MEASURED // PARTS**2:,} of one surface, got {tolerance:g}"
            )
        for s, sides in enumerate(counts):
            pairs = zip(sides, before[s], strict=True)
            changed[s] = any((new != old).any() for new, old in pairs)
        if not changed.any():
            break
    else:
        raise ValueError(f"tolerance: expected one that these surfaces can keep, got {tolerance:g}")
    samples = [(_samples(u), _samples(v)) for u, v in counts]
    return samples, float(worst.max(initial=0)) / size if size else 0.0


def diagonal(model: NurbsModel) -> float:
    """Of the box of points on the surfaces, four to each side of a KSQuad."""
    found = [np.zeros((0, 3))]
    for s in model.surfaces:
        sides = (_samples(np.full(len(first_knots(k)), PARTS)) for k in (s.knots_u, s.knots_v))
        found.append(points_at(s, *sides).reshape(-1, 3))
    points = np.concatenate(found)
    return float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0


def _samples(counts: Numbers) -> Samples:
    """So many segments on each span."""
    spans = np.repeat(np.arange(len(counts)), counts)
    within = np.arange(len(spans)) - np.repeat(np.cumsum(counts) - counts, counts)
    return Samples(np.append(spans, len(counts) - 1), np.append(within / counts[spans], 1.0))


def distances(
    surface: NurbsSurface,
    counts: list[Numbers],
    parts: int = PARTS,
    corners: Doubles | None = None,
) -> tuple[Doubles, Doubles, Doubles]:
    """Largest distances over each KSQuad, (spans_u, spans_v): of its triangles, of their edges along u, and along v.

    `corners` of the triangles, (rows, columns, 3), are the surface's own points where none are given.
    """
    P = points_at(surface, *(_samples(parts * n) for n in counts))
    X = P[::parts, ::parts] if corners is None else corners
    A, B, C, D = X[:-1, :-1], X[1:, :-1], X[1:, 1:], X[:-1, 1:]
    found = [np.zeros(A.shape[:2]) for _ in range(3)]
    rows, columns = len(P) - parts, P.shape[1] - parts
    for i in range(parts + 1):
        for j in range(parts + 1):
            x, y = i / parts, j / parts
            flat = A + x * (B - A) + y * (C - B) if x >= y else A + y * (D - A) + x * (C - D)
            there = P[i : i + rows : parts, j : j + columns : parts]
            off = np.sqrt(((there - flat) ** 2).sum(axis=2))
            for k, counted in enumerate((True, j % parts == 0, i % parts == 0)):
                if counted:
                    np.maximum(found[k], off, out=found[k])
    starts = [np.cumsum(n) - n for n in counts]
    return tuple(  # pyright: ignore[reportReturnType]
        np.maximum.reduceat(np.maximum.reduceat(off, starts[0], axis=0), starts[1], axis=1)
        for off in found
    )


def _refine(surface: NurbsSurface, counts: list[Numbers], limit: float) -> float:
    """More segments where distances are larger than the limit; returns the largest that there was."""
    off, along_u, along_v = distances(surface, counts)
    twist = np.maximum(off - along_u - along_v, 0) / 2
    over = off > limit
    if over.any():
        # a distance falls with the square of the segments: half of the limit for each side
        growth = [np.sqrt(2 * (along + twist) / max(limit, 1e-300)) for along in (along_u, along_v)]
        stuck = over & (growth[0] <= 1) & (growth[1] <= 1)
        for k, other in ((0, 1), (1, 0)):
            larger = growth[k] >= growth[other]
            wanted = np.where(over, np.where(stuck & larger, 1.5, np.maximum(growth[k], 1)), 1)
            wanted = np.minimum(wanted.max(axis=1 - k), MOST_GROWTH)
            counts[k] = np.ceil(counts[k] * wanted).astype(np.int64)
    return float(off.max())


def _agree(counts: Counts, borders: Borders) -> None:
    """The larger number of both sides of every border that surfaces share, until none changes."""
    links = []
    for s, edges in enumerate(borders.owner):
        for e, owner in enumerate(edges):
            o, oe = divmod(int(owner), 4)
            if (o, oe) != (s, e) and not borders.collapsed[s, e]:
                links.append((s, int(e < 2), o, int(oe < 2), -1 if borders.turned[s, e] else 1))
    moved = True
    while moved:
        moved = False
        for s, side, o, other_side, step in links:
            mine, theirs = counts[s][side], counts[o][other_side][::step]
            most = np.maximum(mine, theirs)
            if (most != mine).any() or (most != theirs).any():
                counts[s][side], counts[o][other_side] = most, most[::step].copy()
                moved = True
