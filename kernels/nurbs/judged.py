"""The check of all systems of the family: points and normals against float64."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lodbench.datasets_gen.nurbs_surface import NurbsModel
from lodbench.datasets_gen.surfaces import Floats
from lodbench.kernels.exactness import verdict
from lodbench.kernels.nurbs.grids import Grid
from lodbench.kernels.nurbs.reference import normals_at, points_at
from lodbench.kernels.nurbs.samples import Samples
from lodbench.kernels.system import Check

CHECKED_ROWS = 500  # of all surfaces' grids that a check looks at


def judged(
    model: NurbsModel, grids: Sequence[Grid], positions: Floats, normals: Floats | None
) -> Check:
    """Were these the points and normals of the surfaces? Some rows, spread over all, are compared with float64.

    Args:
        model: that was tessellated.
        grids: of its surfaces.
        positions: (vertices, 3).
        normals: likewise, or None.
    """
    low, high = model.box
    size = max(float(np.linalg.norm(high - low)), float(np.abs([low, high]).max()), 1e-37)
    rows = sum(grid.rows for grid in grids)
    step = max(1, rows // CHECKED_ROWS)
    position, normal, seen, number = 0.0, 0.0, 0, 0
    for surface, grid in zip(model.surfaces, grids, strict=True):
        chosen = np.flatnonzero((number + np.arange(grid.rows)) % step == 0)
        number += grid.rows
        if not len(chosen):
            continue
        seen += len(chosen)
        u = Samples(grid.u.spans[chosen], grid.u.t[chosen])
        at = grid.first + chosen[:, None] * grid.columns + np.arange(grid.columns)
        off = np.abs(positions[at] - points_at(surface, u, grid.v)).max()
        position = float(np.max([position, off / size]))  # NaN is worst
        if normals is not None:
            expected, certain = normals_at(surface, u, grid.v)
            turned = np.linalg.norm(normals[at] - expected, axis=-1)
            normal = float(np.max([normal, turned[certain].max(initial=0)]))
    return verdict(position, normal, f"{seen} of {rows} rows")
