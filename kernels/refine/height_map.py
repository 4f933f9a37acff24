"""A height map that raises a surface: on the device, and in float64."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.height_maps import height_map
from lodbench.datasets_gen.surfaces import Floats, TriangleMesh
from lodbench.kernels.opencl import Device
from lodbench.kernels.refine.displacement import Displacement, Doubles, Height
from lodbench.kernels.refine.params import RefineParams
from lodbench.kernels.refine.texture import ATTRIBUTES, uv_attributes

ROUNDINGS = 8 * float(np.finfo(np.float32).eps)  # of a texture coordinate on its way


class MapDisplacement(Displacement):
    """The values of a map at the texture coordinates, less a bias.

    Raises:
        ValueError: the mesh has no texture coordinates, or those are beyond a float's digits; and as `height_map`.
    """

    is_any = True
    files = ("common/height_map.cl",)
    flops = 120

    def __init__(self, params: RefineParams, mesh: TriangleMesh, diagonal: float) -> None:
        super().__init__(params, mesh, diagonal)
        if mesh.uvs is None:
            raise ValueError(
                "uvs: expected texture coordinates under a height map, got a mesh without"
            )
        self._values = height_map(params.height_map)[::-1] - np.float32(params.map_bias)
        self._attributes = uv_attributes(mesh, self._unit)

    @property
    def defines(self) -> dict[str, int]:
        """See `Displacement`."""
        nearest = int(self.params.map_filter == "nearest")
        return super().defines | {"ATTRIBUTES": ATTRIBUTES, "NEAREST": nearest}

    def table(self) -> NDArray[np.uint32]:
        """Width, height, and the bits of the values."""
        size = np.array(self._values.shape[::-1], np.uint32)
        return np.concatenate([size, self._values.ravel().view(np.uint32)])

    def attributes(self) -> Floats | None:
        """Texture coordinates and how they rise."""
        return self._attributes

    def value(self, time: float) -> tuple[float, float, float, float]:
        """See `Displacement`."""
        return self.params.amplitude * self.diagonal, 0.0, 0.0, 1 / self._unit

    def height(self, time: float, rows: NDArray[np.int64], device: Device) -> Height:
        """See `Displacement`."""
        amplitude, _, _, inverse = self.value(time)
        return MapHeight(
            amplitude, inverse, self._values.astype(np.float64),
            self._attributes[rows].astype(np.float64), self.params.map_filter == "nearest",
        )  # fmt: skip


class MapHeight:
    """A map in float64 over m triangles; `slope` and `bend` are those of the points that it had last. See `Height`."""

    def __init__(
        self, a: float, inverse: float, values: Doubles, corners: Doubles, nearest: bool
    ) -> None:
        """`values` (h, w) from the lowest v on, less their bias; `corners` (m, 3, 8) as `uv_attributes` has them."""
        self.a, self._inverse, self._nearest = a, inverse, nearest
        self._values, self._corners = values, corners
        self.slope = self.bend = 0.0

    def __call__(
        self, points: Doubles, normals: Doubles, wuv: Doubles
    ) -> tuple[Doubles, Doubles, Doubles]:
        """See `Height`: kinks lie between the values' places, and jumps of the nearest one midway."""
        at = wuv @ self._corners
        counts = np.array(self._values.shape[::-1])
        x = (at[..., :2] % 1.0) * counts - 0.5
        low = np.floor(x)
        (s, t), index = np.moveaxis(x - low, -1, 0), low.astype(np.int64)
        (i, j), (k, m) = (np.moveaxis(cell % counts, -1, 0) for cell in (index, index + 1))
        a, b, c, d = (self._values[row, column] for row in (j, m) for column in (i, k))
        along_u = counts[0] * ((b - a) * (1 - t) + (d - c) * t)
        along_v = counts[1] * ((c - a) * (1 - s) + (d - b) * s)
        raised = (a * (1 - s) + b * s) * (1 - t) + (c * (1 - s) + d * s) * t
        steep = self.a * self._inverse
        rises = along_u[..., None] * at[..., 2:5] + along_v[..., None] * at[..., 5:8]
        reach = counts * (1 + np.abs(self._corners[..., :2]).max(axis=(0, 1), initial=0))
        kink = (np.abs(x - np.round(x)) <= ROUNDINGS * reach).any(axis=-1)
        if self._nearest:
            raised = np.where(t < 0.5, np.where(s < 0.5, a, b), np.where(s < 0.5, c, d))
            jump = (np.abs(x - low - 0.5) <= ROUNDINGS * reach).any(axis=-1)
            raised = np.where(jump, np.nan, raised)
        self._measure(points, counts, reach)
        return self.a * raised, steep * rises, np.where(kink, 0.0, 1.0)

    def _measure(self, points: Doubles, counts: Doubles, reach: Doubles) -> None:
        """How far a rounding of texture coordinates or their gradients goes."""
        step = np.array(
            [np.abs(self._values - np.roll(self._values, 1, axis)).max() for axis in (1, 0)]
        )
        gradients = np.abs(self._corners[..., 2:]).reshape(-1, 2, 3).max(axis=(0, 2), initial=0)
        size = max(float(np.abs(points).max(initial=0)), abs(self.a), 1e-37)
        rises = float((counts * step * gradients).sum()) * self._inverse
        self.slope = abs(self.a) * (rises + float((reach * step).sum()) / size)
        self.bend = float(reach.sum()) / size
