"""Attributes of vertices, summed by cell or by side of one, weighted by the area around each vertex."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import ATTRIBUTES, TriangleMesh

_LEAST = 1e-6  # of the mean area: a triangle without area still has a say where it is alone

Index = NDArray[np.intp]
Real = NDArray[np.float64]


def vertex_weights(mesh: TriangleMesh, corners: Index) -> Real:
    """The area of the triangles at each vertex, up to a common factor; 0 where no triangle is."""
    low, high = mesh.box
    extent = float((high - low).max())
    scale = np.float32(0.5 ** float(np.frexp(extent)[1]) if extent > 0 else 1.0)
    x, y, z = mesh.positions.T * scale
    a, b, c = corners
    ux, uy, uz = (axis[b] - axis[a] for axis in (x, y, z))
    vx, vy, vz = (axis[c] - axis[a] for axis in (x, y, z))
    area = np.sqrt(
        (uy * vz - uz * vy) ** 2 + (uz * vx - ux * vz) ** 2 + (ux * vy - uy * vx) ** 2
    ).astype(np.float64)
    mean = area.mean() if len(area) else 0.0
    area = np.maximum(area, _LEAST * mean if mean > 0 else 1.0)
    total = np.zeros(len(x))
    for k in corners:
        total += np.bincount(k, area, len(x))
    return total


class AttributeSums:
    """Weighted sums of positions and attributes, a row each for a piece or a side."""

    def __init__(
        self, mesh: TriangleMesh, kept: Index, row: Index, weights: Real, count: int
    ) -> None:
        """Those over the vertices `kept` of the mesh, each with its row and its weight."""
        self.total = np.bincount(row, weights, count)
        self.sums: dict[str, Real] = {}
        for name in ("positions", *ATTRIBUTES):
            given = getattr(mesh, name)
            if given is None:
                continue
            columns = given[kept].T.astype(np.float64)
            if name == "normals":
                columns = unit(columns)
            sums = [np.bincount(row, weights * x, count).astype(np.float64) for x in columns]
            self.sums[name] = np.stack(sums)

    def joined(self, row: Index) -> AttributeSums:
        """The sums of those that have the same `row`; itself where each has its own."""
        moved = np.flatnonzero(row != np.arange(len(row)))
        if not len(moved):
            return self
        result = object.__new__(AttributeSums)
        result.total = self.total.copy()
        result.sums = {name: sums.copy() for name, sums in self.sums.items()}
        for own in (result.total, *(row_ for sums in result.sums.values() for row_ in sums)):
            np.add.at(own, row[moved], own[moved])
        return result

    def means(self, name: str, rows: Index) -> Real:
        """(columns, len(rows)); normals of unit length."""
        sums = self.sums[name][:, rows]
        return unit(sums) if name == "normals" else sums / self.total[rows]

    def values(self, rows: Index) -> dict[str, Any]:
        """Attributes by name, a row for each of `rows`."""
        return {
            name: np.ascontiguousarray(self.means(name, rows).T, dtype=np.float32)
            for name in self.sums
            if name != "positions"
        }


def unit(columns: Real) -> Real:
    """Vectors of unit length, (3, n); (0, 0, 1) for those of none."""
    length = np.sqrt((columns**2).sum(0))
    none = length <= 1e-12 * max(length.max(initial=0), 1e-300)
    result = columns / np.where(none, 1, length)
    result[:, none] = ((0.0,), (0.0,), (1.0,))
    return result
