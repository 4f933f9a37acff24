"""Targets of a clustering whose grid may be warped, and the warp that they ask for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, Literal

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.target import ClusterTarget, GridTarget
from lodbench.kernels.cluster.warp import (
    DEFINES,
    STEPS,
    Region,
    TableWarp,
    ViewWarp,
    Warp,
    region_warp,
)
from lodbench.kernels.function_text import check_text
from lodbench.kernels.opencl import Device, Text, Timeline
from lodbench.kernels.parameters import check, plain, shown
from lodbench.kernels.system import View

SIGNATURE = "float warp(const float t, const int axis)"
CALL = """static inline float warp_called(const float t, const int axis) {
    return warp(t, axis);
}
"""
WARPS = ("regions", "view", "warp")
FALL = 1e-6  # of the whole rise: what rounding may take back


@dataclass(frozen=True)
class WarpedTarget(GridTarget, ClusterTarget):
    """As its bases; and how its cells are spread, by at most one of three. Without, all are alike.

    Attributes:
        regions: (x, y, z, radius, weight) each, model units: along each axis cells are `weight` times as fine at the
            centre as far away, 1 to 1e6, with a Gaussian of standard deviation `radius` between; densities add up.
            Axis by axis, so that two regions on a diagonal make the box's other corners finer too.
        view: a View, or its world_to_clip, (4, 4): cells are even where the view has its places after projection;
            what is not seen falls into the outermost ones.
        view_depth: of the view's cells: "log", as deep as wide everywhere; "ndc", even in z after projection as
            published, so that depth grows with the square of the distance.
        warp: the text of an OpenCL function `float warp(const float t, const int axis)`, which rises with t from 0 to 1
            along the box's axis 0, 1 or 2: the steeper, the finer. Its ends are brought to 0 and 1.
    """

    regions: tuple = field(default=(), kw_only=True)
    view: tuple | None = field(default=None, kw_only=True)
    view_depth: Literal["log", "ndc"] = field(default="log", kw_only=True)
    warp: str | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        object.__setattr__(self, "regions", tuple(_regions(self.regions)))
        object.__setattr__(self, "view", _matrix(self.view))
        super().__post_init__()
        if self.warp is not None:
            check_text("warp", self.warp, SIGNATURE)
        given = [name for name in WARPS if getattr(self, name)]
        if len(given) > 1:
            raise ValueError(f"{', '.join(WARPS)}: expected one of them, got {' and '.join(given)}")


def _regions(given: Any) -> Iterator[Region]:
    """Each checked.

    Raises:
        TypeError, ValueError: no five numbers, or one out of range.
    """
    wanted = "expected (x, y, z, radius, weight) each, radius above 0 and weight 1 to 1e6"
    rows = given.tolist() if isinstance(given, np.ndarray) else given
    if not isinstance(rows, tuple | list):
        raise TypeError(f"regions: {wanted}, got {shown(given)}")
    for row in rows:
        if not isinstance(row, tuple | list | np.ndarray) or len(row) != 5:
            raise ValueError(f"regions: {wanted}, got {shown(row)}")
        region = check("regions", tuple(plain(value) for value in row), Region)
        if not (region[3] > 0 and 1 <= region[4] <= 1e6):
            raise ValueError(f"regions: {wanted}, got {shown(row)}")
        yield region


def _matrix(view: Any) -> tuple[tuple[float, ...], ...] | None:
    """The view's world_to_clip as plain numbers, which a record can keep.

    Raises:
        TypeError, ValueError: no View and no matrix, or one that is not finite.
    """
    if view is None:
        return None
    try:
        matrix = np.asarray(view.world_to_clip if isinstance(view, View) else view, np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"view: expected a View or its (4, 4) matrix, got {shown(view)}") from None
    if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
        got = f"shape {matrix.shape}" if matrix.shape != (4, 4) else "infinity or NaN in it"
        raise ValueError(f"view: expected a View or its (4, 4) matrix, got {got}")
    return tuple(tuple(row) for row in matrix.tolist())


def warp_of(params: WarpedTarget, mesh: TriangleMesh, device: Device | None = None) -> Warp | None:
    """The warp that is asked for, over this mesh; None without one, or without vertices.

    Args:
        params: of any clustering.
        mesh: what is simplified; regions and the view count from the world's origin, not from the mesh's.
        device: what is asked for the values of a user's function.

    Raises:
        ValueError: a function that does not build, or does not rise; a matrix that cannot be inverted.
    """
    if not mesh.vertex_count:
        return None
    if not any(getattr(params, name) for name in WARPS):
        return None  # before the box, which takes longer than a frame
    origin = np.zeros(3) if mesh.origin is None else mesh.origin
    low, high = box = mesh.box[0].astype(np.float64), mesh.box[1].astype(np.float64)
    if params.regions:
        t = np.linspace(0, 1, STEPS + 1)
        extents = np.where(high > low, high - low, 1)
        rising = [
            region_warp(t, [
                ((centre[axis] - origin[axis] - low[axis]) / extents[axis], radius / extents[axis], weight)
                for *centre, radius, weight in params.regions
            ])
            for axis in range(3)
        ]  # fmt: skip
        return TableWarp(box, np.stack(rising))
    if params.view:
        matrix = np.array(params.view)
        matrix[:, 3] += matrix[:, :3] @ origin
        return ViewWarp(box, mesh.positions, matrix, params.view_depth)
    assert params.warp is not None and device is not None
    return TableWarp(box, function_table(device, params.warp))


def function_table(device: Device, text: str) -> Any:
    """A user's warp at even steps, (3, STEPS + 1) float64, its ends brought to 0 and 1.

    Raises:
        ValueError: it does not build, is not finite, or falls.
    """
    program = device.build(
        Text("warp", text, CALL, SIGNATURE), "cluster/warp_function.cl", defines=DEFINES
    )
    values = device.allocate("values", (3, STEPS + 1), np.float32)
    count = 3 * (STEPS + 1)
    program.launch(
        "cluster_warp_function_table", count, stage="warp", values=values, value_count=count
    )(Timeline())
    found = device.read(values).astype(np.float64)
    for axis, row in zip("xyz", found, strict=True):
        wanted = f"warp: expected a function that rises from t = 0 to 1 along {axis}"
        if not np.isfinite(row).all():
            raise ValueError(f"{wanted}, got {row[~np.isfinite(row)][0]:g}")
        rise = row[-1] - row[0]
        if rise <= 0:
            raise ValueError(f"{wanted}, got {row[0]:g} and {row[-1]:g} at its ends")
        for step, (before, after) in enumerate(pairwise(row)):
            if after < before - FALL * rise:
                at = f"{after:g} after {before:g} at t = {(step + 1) / STEPS:.3g}"
                raise ValueError(f"{wanted}, got {at}")
        row[:] = np.clip(np.maximum.accumulate((row - row[0]) / rise), 0, 1)
    return found
