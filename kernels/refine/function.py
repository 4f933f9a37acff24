"""A function of the user's that raises a surface: its text between the kernels', and what it says to a check."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Floats, TriangleMesh
from lodbench.kernels.opencl import Device, Text, Timeline
from lodbench.kernels.refine.displacement import Displacement, Doubles, Height
from lodbench.kernels.refine.function_text import SIGNATURE
from lodbench.kernels.refine.params import RefineParams
from lodbench.kernels.refine.texture import ATTRIBUTES, uv_attributes

STEP = 2.0**-12  # of the diagonal, to either side: a wave of a hundredth shows its slope in full
FAR_STEP = 2.0**-17  # of the largest coordinate, whose own rounding is 2^-24
CALL = """static inline float function_called(float3 position, float3 normal, float2 uv, float time) {
    return displace(position, normal, uv, time);
}
"""
NUDGE = 16 * float(np.finfo(np.float32).eps)
STEEPEST = 100.0  # a check takes steeper places for jumps
ROUGHEST = 0.01  # change of slope under a nudge that makes a kink


class FunctionDisplacement(Displacement):
    """The height that a user's function gives, in model units, its slope by differences (a reconstruction)."""

    is_any = True
    flops = 250  # without the function's own
    remark = "; heights are the function's own, asked of the device at float64's points, but for its jumps and kinks"

    def __init__(self, params: RefineParams, mesh: TriangleMesh, diagonal: float) -> None:
        super().__init__(params, mesh, diagonal)
        text = Text("function", params.function, CALL, SIGNATURE)
        self.files = ("common/displacement.cl", text, "common/function.cl")
        away = float(np.abs(mesh.positions).max(initial=0))
        self._step = max(STEP * diagonal, FAR_STEP * away, 2.0**-120)
        self._attributes = None if mesh.uvs is None else uv_attributes(mesh, self._unit)

    @property
    def defines(self) -> dict[str, int]:
        """See `Displacement`."""
        return super().defines | {"ATTRIBUTES": 0 if self._attributes is None else ATTRIBUTES}

    def attributes(self) -> Floats | None:
        """Texture coordinates and how they rise, where the mesh has any."""
        return self._attributes

    def value(self, time: float) -> tuple[float, float, float, float]:
        """See `Displacement`."""
        largest = float(np.finfo(np.float32).max)
        return self._step, 0.0, min(max(time, -largest), largest), 1 / self._unit

    def height(self, time: float, rows: NDArray[np.int64], device: Device) -> Height:
        """See `Displacement`."""
        read = self._attributes
        corners = None if read is None else read[rows].astype(np.float64)
        return FunctionHeight(self, self.value(time), corners, device)

    def check_heights(self, positions: Floats) -> None:
        """See `Displacement`."""
        finite = np.isfinite(positions).all(axis=-1)
        if not finite.all():
            missing = finite.size - np.count_nonzero(finite)
            got = f"infinity or NaN at {missing:,} of {finite.size:,} vertices"
            raise ValueError(f"function: expected finite heights, got {got}")


class FunctionHeight:
    """What the function itself says on a device, which is no second opinion of it, but of everything around it.

    `a`, `slope` and `bend` are those that it had where it was asked last. See `Height`.
    """

    def __init__(
        self,
        displacement: FunctionDisplacement,
        value: tuple[float, float, float, float],
        corners: Doubles | None,
        device: Device,
    ) -> None:
        """`corners` are the attributes of m triangles, (m, 3, 8)."""
        self._files, self._defines = displacement.files, displacement.defines
        self._value, self._corners, self._device = value, corners, device
        self.a = self.slope = value[0]
        self.bend = 1 / value[0]

    def __call__(
        self, points: Doubles, normals: Doubles, wuv: Doubles
    ) -> tuple[Doubles, Doubles, Doubles]:
        """See `Height`. A place is certain where nudges by some roundings change little."""
        shape = points.shape[:-1]
        at = np.zeros((*shape, ATTRIBUTES))
        if self._corners is not None:
            at = wuv @ self._corners
        size = max(float(np.abs(points).max(initial=0)), self._value[0])
        nudge, uv_nudge = NUDGE * size, NUDGE * (1 + np.abs(at[..., :2]).max(initial=0))
        height, gradient = self._asked(points, normals, at)
        moved, turned = np.zeros(shape), np.zeros(shape)
        for axis in range(3):
            for sign in (-1.0, 1.0):
                step = sign * np.eye(3)[axis]
                uv_step = np.zeros(ATTRIBUTES)
                uv_step[:2] = uv_nudge * sign, uv_nudge * (sign if axis else -sign)
                other = self._asked(points + nudge * step, normals + NUDGE * step, at + uv_step)
                with np.errstate(invalid="ignore"):  # infinity less infinity
                    moved = np.fmax(moved, np.abs(other[0] - height))
                turned = np.fmax(turned, np.linalg.norm(other[1] - gradient, axis=-1))
        steep = np.linalg.norm(gradient, axis=-1)
        height = np.where(moved <= STEEPEST * nudge, height, np.nan)
        certain = np.isfinite(height) & (turned <= ROUGHEST * (1 + steep))
        if certain.any():
            self.a = max(float(np.abs(height[certain]).max()), self.a)
            rises = max(float(steep[certain].max()), float(moved[certain].max()) / nudge)
            self.slope = rises + self.a / size
        return height, gradient, certain.astype(np.float64)

    def _asked(self, points: Doubles, normals: Doubles, at: Doubles) -> tuple[Doubles, Doubles]:
        """Height (m, n) and gradient (m, n, 3)."""
        shape = points.shape[:-1]
        rows = points.size // 3
        count = -(-rows // 8) * 8
        planes = np.zeros((8 + 6, count), np.float32)
        given = np.concatenate([points, normals, at], axis=-1).reshape(rows, 14)
        planes[:, :rows] = given.T
        planes[5, rows:] = 1
        device, arguments = self._device, dict[str, Any]()
        arguments["places"] = device.upload("places", planes[:8])
        arguments["gradients"] = device.upload("gradients", planes[8:])
        answers = device.allocate("answers", (4, count), np.float32)
        program = device.build(
            *self._files, "refine/function.cl", defines={"CHUNK": 8} | self._defines
        )
        program.launch(
            "refine_function_answers", count // 8, stage="check", answers=answers,
            displacement=self._value, count=count, **arguments,
        )(Timeline())  # fmt: skip
        found = device.read(answers)[:, :rows].astype(np.float64)
        return found[0].reshape(shape), np.moveaxis(found[1:], 0, -1).reshape(*shape, 3)
