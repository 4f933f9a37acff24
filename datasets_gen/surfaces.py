"""The surfaces that lodbench reads, makes and hands out: frozen, validated, host side only."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lodbench.datasets_gen.arrays import (
    Origin,
    area_normals,
    box,
    checked_origin,
    finite,
    recentred,
    rows,
)
from lodbench.datasets_gen.nurbs_surface import NurbsModel

Floats = NDArray[np.float32]
Indices = NDArray[np.uint32]
ATTRIBUTES = ("normals", "uvs", "colours", "tags")  # of a TriangleMesh, a row for each vertex


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """An indexed triangle mesh.

    ```
    positions  (n, 3) float32   x y z | x y z | ...        model units, from the origin
    triangles  (m, 3) uint32    a b c | a b c | ...        rows of positions, counter-clockwise from outside
    normals    (n, 3) float32   unit length, or None
    uvs        (n, 2) float32   texture coordinates, or None
    colours    (n, 3) float32   0..1, or None
    tags       (n, 3) float32   tension, sharpness, bias per vertex, or None
    edge_tags  (m, 3, 2) float32   sharpness, bias of each triangle's edges ab, bc, ca, or None; no file holds them
    origin     (3,) float64     where the positions count from in the world, or None for zero
    ```
    Any real or integer dtype is taken and converted; the arrays are read-only views where no conversion was needed.
    Positions not yet float32 that lie far from zero for their extent, such as map coordinates, get an origin in their
    middle (see `arrays.recentred`), unless one is given; `points` are those that came.

    Raises:
        TypeError: a dtype that is not a number's.
        ValueError: a wrong shape, NaN or infinity (also after rounding to float32), an index out of range.
    """

    positions: Floats
    triangles: Indices
    normals: Floats | None = None
    uvs: Floats | None = None
    colours: Floats | None = None
    tags: Floats | None = None
    edge_tags: Floats | None = None
    origin: Origin | None = None

    if TYPE_CHECKING:  # what is taken is wider than what is kept

        def __init__(
            self,
            positions: ArrayLike,
            triangles: ArrayLike,
            normals: ArrayLike | None = None,
            uvs: ArrayLike | None = None,
            colours: ArrayLike | None = None,
            tags: ArrayLike | None = None,
            edge_tags: ArrayLike | None = None,
            origin: ArrayLike | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        given, origin = self.positions, checked_origin(self.origin)
        local = given
        if self.origin is None:
            local, origin = recentred(given)
        object.__setattr__(self, "origin", origin)
        with np.errstate(over="ignore", invalid="ignore"):
            positions = rows("points", local, np.float32, 3)
        finite("points", given, positions)
        object.__setattr__(self, "positions", positions)
        faces = np.asarray(self.triangles)
        if faces.size and faces.dtype.kind in "iu":
            low, high = int(faces.min()), int(faces.max())
            if low < 0 or high >= len(positions):
                worst = low if low < 0 else high
                raise ValueError(
                    f"faces: expected indices from 0 to {len(positions) - 1}, got {worst}"
                    if len(positions)
                    else f"faces: expected no triangles with no points, got index {worst}"
                )
        object.__setattr__(self, "triangles", rows("faces", faces, np.uint32, 3))
        for name, columns in (("normals", 3), ("uvs", 2), ("colours", 3), ("tags", 3)):
            values = getattr(self, name)
            if values is not None:
                array = rows(name, values, np.float32, columns, len(positions))
                finite(name, values, array)
                object.__setattr__(self, name, array)
        if self.edge_tags is not None:
            edges = np.asarray(self.edge_tags)
            if edges.shape[1:] != (3, 2):
                raise ValueError(f"edge_tags: expected (m, 3, 2) float32, got shape {edges.shape}")
            array = rows("edge_tags", edges.reshape(-1, 6), np.float32, 6, len(self.triangles))
            finite("edge_tags", edges, array)
            object.__setattr__(self, "edge_tags", array.reshape(-1, 3, 2))

    @classmethod
    def of_kernels(cls, positions: Floats, triangles: Indices) -> TriangleMesh:
        """Of arrays that kernels have just written, as they should be: none is looked at, which takes 0.1 ms."""
        mesh = object.__new__(cls)
        vars(mesh).update(dict.fromkeys((*ATTRIBUTES, "edge_tags", "origin")))
        vars(mesh).update(positions=positions, triangles=triangles)
        positions.flags.writeable = triangles.flags.writeable = False
        return mesh

    @property
    def vertex_count(self) -> int:
        return len(self.positions)

    @property
    def triangle_count(self) -> int:
        return len(self.triangles)

    @property
    def points(self) -> NDArray[np.floating]:
        """The positions in the world, (n, 3): float64 with an origin, else `positions` themselves."""
        return self.positions if self.origin is None else self.positions + self.origin

    def with_origin(self, origin: ArrayLike | None) -> TriangleMesh:
        """The same positions counted from another origin; itself where both are None."""
        if origin is None and self.origin is None:
            return self
        return replace(self, origin=origin)

    def bare(self) -> TriangleMesh:
        """Its positions and triangles alone; itself where it has no more."""
        more = (*ATTRIBUTES, "edge_tags")
        if all(getattr(self, name) is None for name in more):
            return self
        return TriangleMesh(self.positions, self.triangles, origin=self.origin)

    @property
    def box(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lower and upper corner of all positions, from the origin, (3,) float64 each; zeros when there are none."""
        return box(self.positions)

    @property
    def diagonal(self) -> float:
        low, high = self.box
        return float(np.linalg.norm(high - low))

    def with_normals(self) -> TriangleMesh:
        """This mesh with area-weighted unit vertex normals; itself when it has normals already.

        A vertex with no area around it gets (0, 0, 1). With uvs, which part vertices at a seam, those at one place
        share theirs.
        """
        if self.normals is not None:
            return self
        normals = area_normals(self.positions, self.triangles, shared=self.uvs is not None)
        return replace(self, normals=normals)


@dataclass(frozen=True, eq=False)
class BezierPatches:
    """Bicubic Bezier patches.

    ```
    points  (n, 4, 4, 3) float32   patch, i along u, j along v, x y z
    ```
    """

    points: Floats

    if TYPE_CHECKING:

        def __init__(self, points: ArrayLike) -> None: ...

    def __post_init__(self) -> None:
        array = np.asarray(self.points)
        if array.ndim != 4 or array.shape[1:] != (4, 4, 3):
            raise ValueError(f"points: expected (n, 4, 4, 3) float32, got shape {array.shape}")
        result = np.array(array, np.float32, order="C")
        finite("points", array, result)
        result.flags.writeable = False
        object.__setattr__(self, "points", result)


@dataclass(frozen=True, eq=False)
class GeometryImage:
    """A square grid of samples of a closed genus-0 surface, octahedral layout.

    ```
    positions  (2^n + 1, 2^n + 1, 3) float32   row, column, x y z
    normals    (2^n + 1, 2^n + 1, 3) float32   unit length
    origin     (3,) float64                    where the positions count from in the world, or None; see TriangleMesh
    ```
    Source: Wang et al., section 2 (geometry image of an octahedrally unfolded sphere).
    """

    positions: Floats
    normals: Floats
    origin: Origin | None = None

    def __post_init__(self) -> None:
        if self.origin is None:
            positions, origin = recentred(self.positions)
            object.__setattr__(self, "positions", positions)
        else:
            origin = checked_origin(self.origin)
        object.__setattr__(self, "origin", origin)
        for name in ("positions", "normals"):
            given = np.asarray(getattr(self, name))
            side = given.shape[0] if given.ndim == 3 else 0
            if given.shape != (side, side, 3) or side < 3 or (side - 1) & (side - 2):
                raise ValueError(
                    f"{name}: expected (2^n + 1, 2^n + 1, 3) float32, got shape {given.shape}"
                )
            array = np.array(given, np.float32, order="C")
            finite(name, given, array)
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        if self.positions.shape != self.normals.shape:
            raise ValueError(
                f"normals: expected shape {self.positions.shape}, got {self.normals.shape}"
            )

    @property
    def vertex_count(self) -> int:
        """Distinct points of the full surface: border samples are one with their seam duplicates."""
        return (len(self.positions) - 1) ** 2 + 2

    @property
    def triangle_count(self) -> int:
        """Of the full surface, two per cell."""
        return 2 * (len(self.positions) - 1) ** 2


Surface: TypeAlias = TriangleMesh | BezierPatches | NurbsModel | GeometryImage
