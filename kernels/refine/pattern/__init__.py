"""Generic mesh refinement: one stored pattern of barycentric vertices, evaluated over every coarse triangle.

What stays in memory is the pattern and the coarse triangles' attributes, whatever the depth of refinement.
Flat interpolation, or a sine displacement along the normal whose normal is corrected by the chain rule
(reconstruction: the paper does not say how). Level of detail: nested patterns, one chosen per object by distance.

Source: Boubekeur & Schlick, Generic Mesh Refinement on GPU, Graphics Hardware 2005, sections 3.2, 3.3, 4 and 5.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.device import Device
from lodbench.kernels.parameters import Parameters, Range, check
from lodbench.kernels.refine.lattice import Amplitude, Segments, Waves
from lodbench.kernels.refine.pattern.host import Pattern, prepare
from lodbench.kernels.refine.room import check_room
from lodbench.kernels.result import Result
from lodbench.kernels.system import Frame, System, run

__all__ = ["Params", "Pattern", "SYSTEM", "refine"]


@dataclass(frozen=True)
class Params(Parameters):
    """How to refine.

    Attributes:
        segments: parts that each coarse edge is cut into, 1 to 4096.
        levels: nested patterns held ready, the coarser with half the segments of the finer; `segments` must allow
            for it. `Frame.view` chooses: each doubling of the eye's distance past `near` halves the segments.
        draw: "batched", one launch for all coarse triangles; or "per_triangle", one launch for each with its attributes
            as arguments, as the paper's draw calls did.
        amplitude: of the displacement a sin(f |P|), as a fraction of the bounding-box diagonal; 0 for none.
        waves: of that sine per bounding-box diagonal; one passes per second of `Frame.time`.
        near: distance of the eye from the box, in diagonals, up to which the finest level is shown.
    """

    segments: Segments = 16
    levels: Annotated[int, Range(1, 13)] = 1
    draw: Literal["batched", "per_triangle"] = "batched"
    amplitude: Amplitude = 0.0
    waves: Waves = 8.0
    near: Annotated[float, Range(0, open="low")] = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.segments % (1 << (self.levels - 1)):
            raise ValueError(
                f"levels: expected halvings of {self.segments} segments, got {self.levels}"
            )


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
    prepared = prepare(device, mesh, params)
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
    prepare=prepare,
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
