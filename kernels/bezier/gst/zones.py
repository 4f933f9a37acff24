"""Zones of a parametric map: how large a geometry shader's output lets them be, and where their vertices stand.

```
a zone of rows x columns cells    strip r:  (r + 1, 0) (r, 0) (r + 1, 1) (r, 1) ...
emits `rows` strips                         2 (columns + 1) vertices
```
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from lodbench.kernels.bezier.arrangement import Arrangement


@dataclass(frozen=True)
class Zone:
    """So many cells."""

    rows: int
    columns: int

    @property
    def vertices(self) -> int:
        """That a zone emits."""
        return 2 * self.rows * (self.columns + 1)


def largest_zone(level: int, values_per_vertex: int, most_values: int) -> Zone:
    """The zone of most cells, powers of two on each side, that emits no more; the squarest of these, rather wide.

    Source: Concheiro 2013, section 2.3 (1024 values); powers of two are a reconstruction, they tile the map.
    """
    sides = [1 << k for k in range(level + 1)]
    zones = [Zone(rows, columns) for rows, columns in product(sides, sides) if rows <= columns]
    fitting = [zone for zone in zones if zone.vertices * values_per_vertex <= most_values]
    return max(fitting, key=lambda zone: (zone.rows * zone.columns, zone.rows))


def zone_arrangement(level: int, zone: Zone) -> Arrangement:
    """A patch's zones, row by row of the map, each as its strips."""
    n, side = 1 << level, (1 << level) + 1
    first_row = np.arange(0, n, zone.rows)[:, None, None, None, None]
    first_column = np.arange(0, n, zone.columns)[:, None, None, None]
    strip = np.arange(zone.rows)[:, None, None]
    column = np.arange(zone.columns + 1)[:, None]
    upper = np.array([1, 0])  # the row after the strip's first, then that
    places = (first_row + strip + upper) * side + first_column + column
    starts = np.arange(places.size // (2 * (zone.columns + 1))) * 2 * (zone.columns + 1)
    b = (starts[:, None] + 2 * np.arange(zone.columns)).ravel()
    a, c, d = b + 1, b + 2, b + 3
    triangles = np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)
    return Arrangement(places.ravel(), triangles.astype(np.uint32))
