"""The verb refine, of any system that refines by patterns."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.opencl import Device
from lodbench.kernels.parameters import check
from lodbench.kernels.refine.params import RefineParams
from lodbench.kernels.refine.refined import Refined
from lodbench.kernels.refine.room import check_room
from lodbench.kernels.result import Result
from lodbench.kernels.system import Frame, Prepared, run


class Refining(Prepared, Protocol):
    """What a refinement's `prepare` gives."""

    def welded(self) -> TriangleMesh:
        """The last frame's mesh with every shared vertex once, the coarse vertices in use first."""
        ...


def refined(
    device: Device, prepared: Refining, mesh: TriangleMesh, frame: Frame, weld: bool
) -> Result:
    """What one frame makes of the coarse `mesh`; welded, with the map from its vertices in use."""
    timeline = run(device, prepared, frame)
    vertex_map = None
    if weld:
        made = prepared.welded()
        used = np.unique(mesh.triangles)
        vertex_map = np.full(mesh.vertex_count, 0xFFFFFFFF, np.uint32)
        vertex_map[used] = np.arange(len(used), dtype=np.uint32)
    else:
        made = prepared.result()[0]
    return Result(made, vertex_map, (made,), dict(prepared.counters()), prepared.setup, timeline)


def refiner(make: Callable[..., Refined], kind: type[RefineParams]) -> Callable[..., Result]:
    """The verb `refine` of a system, made of its subject and its `Params`."""

    def refine(
        device: Device,
        mesh: TriangleMesh,
        *,
        segments: int,
        weld: bool = True,
        time: float = 0.0,
        **options: Any,
    ) -> Result:
        """Every triangle split into segments^2; `options` are those of the Params, `time` is the displacement's, s.

        Welded, the coarse vertices in use come first and `vertex_map` says where; else there is none, since every
        coarse triangle has its own.
        """
        params = kind.named(segments=segments, **options)
        check("weld", weld, bool)
        check("time", time, float)
        check_room(device, mesh, params.segments, weld)
        prepared = make(device, mesh, params)
        return refined(device, prepared, mesh, Frame(time=time), weld)

    return refine
