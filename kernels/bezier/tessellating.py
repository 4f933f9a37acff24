"""The verb tessellate, of any system of the family."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import psutil

from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels.bezier.adaptive import Adaptive
from lodbench.kernels.bezier.lattice import side_vertices
from lodbench.kernels.bezier.level_params import LeveledParams
from lodbench.kernels.bezier.leveled import Leveled
from lodbench.kernels.bezier.params import BezierParams
from lodbench.kernels.bezier.tessellated import Tessellated, vertex_total
from lodbench.kernels.opencl import Device, Unsupported
from lodbench.kernels.parameters import check
from lodbench.kernels.result import Result
from lodbench.kernels.system import Frame, View, run

VERTEX_BYTES = 200
"""Of a vertex on device and host at the most, with two triangles, while all are read back and welded."""


def _check_room(patches: int, params: BezierParams) -> None:
    """Refuse a result that this machine could not hold, before any work is done on it.

    Raises:
        ValueError: more vertices than 32-bit indices can name.
        Unsupported: more bytes than the machine has left.
    """
    level = params.finest if isinstance(params, LeveledParams) else params.level
    needed = VERTEX_BYTES * vertex_total(patches, side_vertices(level) ** 2)
    available = psutil.virtual_memory().available
    if needed > available:
        raise Unsupported(
            f"level: needs {needed:,} bytes of memory for the result, machine has {available:,}"
        )


def tessellator(
    make: Callable[..., Tessellated | Leveled | Adaptive], kind: type[BezierParams]
) -> Callable[..., Result]:
    """The verb `tessellate` of a system, made of its subject and its `Params`."""

    def tessellate(
        device: Device,
        patches: BezierPatches,
        *,
        weld: bool = True,
        view: View | None = None,
        **options: Any,
    ) -> Result:
        """Every patch as triangles; `options` are those of the Params, `view` what is chosen by the screen for.

        Welded, patches share the vertices on borders that have the same control points, and one normal at each: where
        they meet at an angle, the mean of theirs.
        """
        if view is not None and issubclass(kind, LeveledParams) and "levels" not in options:
            options = {"by": "screen"} | options
        params = kind.named(**options)
        check("weld", weld, bool)
        _check_room(len(patches.points), params)
        prepared = make(device, patches, params)
        timeline = run(device, prepared, Frame(check("view", view, View | None)))
        made = prepared.welded() if weld else prepared.result()[0]
        counters = dict(prepared.counters())
        return Result(made, None, (made,), counters, prepared.setup, timeline)

    return tessellate
