"""Generic mesh refinement: one stored pattern of barycentric vertices, evaluated over every coarse triangle.

What stays in memory is the pattern and the coarse triangles' attributes, whatever the depth of refinement.
Flat interpolation, or a sine displacement along the normal whose normal is corrected by the chain rule
(reconstruction: the paper does not say how). Level of detail: nested patterns, one chosen per object by distance.

Source: Boubekeur & Schlick, Generic Mesh Refinement on GPU, Graphics Hardware 2005, sections 3.2, 3.3, 4 and 5.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.opencl import Device
from lodbench.kernels.parameters import check
from lodbench.kernels.refine.pattern.host import Pattern
from lodbench.kernels.refine.pattern.params import Params
from lodbench.kernels.refine.room import check_room
from lodbench.kernels.result import Result
from lodbench.kernels.system import Frame, System, run

__all__ = ["Params", "Pattern", "SYSTEM", "refine"]


def refine(
    device: Device,
    mesh: TriangleMesh,
    *,
    segments: int,
    weld: bool = True,
    time: float = 0.0,
    **options: Any,
) -> Result:
    """Every triangle split into segments^2; `options` are those of `Params`, `time` is the displacement's, s.

    Welded, the coarse vertices in use come first and `vertex_map` says where; else there is none, since every coarse
    triangle has its own.
    """
    params = Params.named(segments=segments, **options)
    check("weld", weld, bool), check("time", time, float)
    check_room(device, mesh, params.segments, weld)
    prepared = Pattern(device, mesh, params)
    frame = run(device, prepared, Frame(time=time))
    vertex_map = None
    if weld:
        refined = prepared.welded()
        used = np.unique(mesh.triangles)
        vertex_map = np.full(mesh.vertex_count, 0xFFFFFFFF, np.uint32)
        vertex_map[used] = np.arange(len(used), dtype=np.uint32)
    else:
        refined = prepared.result()[0]
    counters = dict(prepared.counters())
    return Result(refined, vertex_map, (refined,), counters, prepared.setup, frame)


SYSTEM = System(
    name="pattern",
    family="refine",
    source="Boubekeur & Schlick 2005, sections 3.2, 3.3, 4 and 5",
    takes=(TriangleMesh,),
    prepare=Pattern,
    cases={
        "flat_16": Params(16),
        "flat_64": Params(64),
        "flat_128": Params(128),
        "sine_64": Params(64, amplitude=0.02),
        "per_triangle_64": Params(64, draw="per_triangle"),
        "per_triangle_128": Params(128, draw="per_triangle"),
        "levels_64": Params(64, levels=7),
    },
    verbs={"refine": refine},
)
