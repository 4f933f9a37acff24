"""Small sets of patches that the family's tests share."""

import numpy as np
from hypothesis import strategies as st

from lodbench.datasets_gen.surfaces import BezierPatches

SYMMETRIES = [
    lambda p: p,
    lambda p: p[::-1],
    lambda p: p[:, ::-1],
    lambda p: p[::-1, ::-1],
    lambda p: p.swapaxes(0, 1),
    lambda p: p.swapaxes(0, 1)[::-1],
    lambda p: p.swapaxes(0, 1)[:, ::-1],
    lambda p: p.swapaxes(0, 1)[::-1, ::-1],
]
"""The eight ways to name a patch's corners."""


def sheet(seed, rows=2, columns=2, turns=(), scale=1.0):
    """The patches of one rough sheet, each named in another way: borders have the same control points."""
    random = np.random.default_rng(seed)
    points = random.normal(size=(3 * rows + 1, 3 * columns + 1, 3)) * scale
    found = [
        points[3 * i : 3 * i + 4, 3 * j : 3 * j + 4] for i in range(rows) for j in range(columns)
    ]
    turns = [*turns, *[0] * len(found)]
    return BezierPatches(np.array([SYMMETRIES[turns[k]](p) for k, p in enumerate(found)]))


sheets = st.builds(
    sheet,
    st.integers(0, 2**20),
    turns=st.lists(st.integers(0, 7), min_size=4, max_size=4),
    scale=st.sampled_from([1e-30, 1e-3, 1.0, 1e6, 1e30]),
)


def bicubic(height):
    """One patch over the unit square whose control points rise by `height`, (4, 4)."""
    x, y = np.meshgrid(np.arange(4) / 3, np.arange(4) / 3, indexing="ij")
    return BezierPatches(np.stack([x, y, np.broadcast_to(height, (4, 4))], axis=-1)[None])


NASTY = {
    "a point": np.zeros((1, 4, 4, 3)),
    "a line": np.broadcast_to(np.arange(4.0)[:, None, None], (1, 4, 4, 3)),
    "twice the same": np.repeat(bicubic(0.0).points, 2, axis=0),
    "huge": bicubic(np.arange(4.0)).points * np.float32(1e30),
    "tiny": bicubic(np.arange(4.0)).points * np.float32(1e-30),
    "extremes": np.where(np.arange(48).reshape(1, 4, 4, 3) % 2, 1e30, -1e-30),
    "three on an edge": np.repeat(bicubic(0.0).points, 3, axis=0)
    * np.array([1, -1, 2])[:, None, None, None],
}
