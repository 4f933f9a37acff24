"""The verb tessellate, of any system of the family."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import psutil

from lodbench.datasets_gen.nurbs_surface import NurbsModel
from lodbench.kernels.nurbs.params import NurbsParams
from lodbench.kernels.nurbs.tessellated import Tessellated
from lodbench.kernels.opencl import Device, Unsupported
from lodbench.kernels.parameters import check
from lodbench.kernels.result import Result
from lodbench.kernels.stages.camera import moved
from lodbench.kernels.system import Frame, View, run

VERTEX_BYTES = 250
"""Of a vertex on device and host at the most, with two triangles, while all are read back and welded."""


def check_room(model: NurbsModel, params: NurbsParams) -> None:
    """Refuse a result that this machine could not hold, before any work is done on it.

    Raises:
        Unsupported: more bytes than the machine has left.
    """
    parts = model.span_count if params.per == "span" else len(model.surfaces)
    needed = VERTEX_BYTES * parts * 4**params.level
    available = psutil.virtual_memory().available
    if needed > available:
        raise Unsupported(
            f"level: needs {needed:,} bytes of memory for the result, machine has {available:,}"
        )


def tessellator(
    make: Callable[..., Tessellated],
    kind: type[NurbsParams],
    chosen: Callable[[dict[str, Any]], dict[str, Any]] = dict,
) -> Callable[..., Result]:
    """The verb `tessellate` of a system, made of its subject and its `Params`; `chosen` adds what it takes as given."""

    def tessellate(
        device: Device,
        model: NurbsModel,
        *,
        weld: bool = True,
        view: View | None = None,
        **options: Any,
    ) -> Result:
        """Every surface as triangles; `options` are those of the Params, `view` what adapts to the screen is cut for.

        Welded, surfaces share the vertices on borders that have the same control points and knots, and one normal at
        each: where they meet at an angle, the mean of theirs. `parts` of the result has a mesh for each surface.
        """
        params = kind.named(**chosen(options))
        check("weld", weld, bool)
        if check("view", view, View | None) is not None and not getattr(params, "adapts", False):
            raise ValueError("view: expected a method that adapts to it, such as rpns, got another")
        if options.get("tolerance") is None and not getattr(params, "adapts", False):
            check_room(model, params)
        near, origin = model.recentred()
        prepared = make(device, near, params)
        back = None if origin is None else -np.asarray(origin, np.float64)
        seen = view if view is None or back is None else moved(view, back)
        timeline = run(device, prepared, Frame(seen))
        made = prepared.welded() if weld else prepared.result()[0]
        parts = dict(zip(model.names, prepared.parts(), strict=True))
        made = made.with_origin(origin)
        parts = {name: part.with_origin(origin) for name, part in parts.items()}
        counters = dict(prepared.counters())
        return Result(made, None, (made,), counters, prepared.setup, timeline, parts=parts)

    return tessellate
