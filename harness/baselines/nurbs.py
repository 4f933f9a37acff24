"""What baselines of NURBS surfaces share: the parameters, the grids, the verdict. Points alone, without normals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.nurbs_surface import NurbsModel, NurbsSurface
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.host import HostPrepared
from lodbench.kernels.nurbs.grids import Grid, placed
from lodbench.kernels.nurbs.judged import judged
from lodbench.kernels.nurbs.params import Level, NurbsParams
from lodbench.kernels.nurbs.samples import by_span, first_knots
from lodbench.kernels.nurbs.tessellated import sampled, vertex_total
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.parameters import Parameters
from lodbench.kernels.system import Check, Frame

Points = NDArray[np.floating]


@dataclass(frozen=True)
class Params(Parameters):
    """`level`: of resolution, 0 to 10: a surface has 2^level segments along each side."""

    level: Level = 4


def span_grids(model: NurbsModel, level: int) -> tuple[list[Grid], NDArray[np.int64]]:
    """The grids of a model with 2^level segments on each span, and where their vertices stand among those of KSQuads.

    KSQuads come surface after surface, along v fastest, each with its own (2^level + 1)^2 vertices, along v fastest.
    """
    n, vertices = 1 << level, 0
    grids = placed([(by_span(s.knots_u, n), by_span(s.knots_v, n)) for s in model.surfaces])
    order = [np.zeros(0, np.int64)]
    for surface, grid in zip(model.surfaces, grids, strict=True):
        row, column = (np.rint(s.t * n).astype(np.int64) for s in (grid.u, grid.v))
        quad = grid.u.spans[:, None] * len(first_knots(surface.knots_v)) + grid.v.spans
        place = quad * (n + 1) ** 2 + row[:, None] * (n + 1) + column
        order.append(vertices + place.ravel())
        vertices += surface.span_count * (n + 1) ** 2
    return grids, np.concatenate(order)


def grid_subject(
    device: Device,
    model: NurbsModel,
    params: Params,
    evaluator: Callable[[NurbsSurface, Grid], Callable[[], Points]],
    planes: bool = False,
) -> HostPrepared:
    """A subject that calls an evaluator for each surface in turn.

    Args:
        device: that it is compared with.
        model: whose surfaces are evaluated.
        params: how finely.
        evaluator: (surface, grid) -> the timed call, which gives points (rows, columns, 3).
        planes: the calls give (3, rows, columns).
    """
    setup = Timeline()
    with setup.host("allocate"):
        grids = placed(sampled(model, NurbsParams(params.level)))
        vertex_total(grids)
        calls = [evaluator(s, grid) for s, grid in zip(model.surfaces, grids, strict=True)]

    def call(frame: Frame) -> list[Points]:
        return [one() for one in calls]

    def read(output: Sequence[Points]) -> list[TriangleMesh]:
        rows = [np.moveaxis(p, 0, 2) if planes else p for p in output]
        points = [np.asarray(p, np.float32).reshape(-1, 3) for p in rows]
        none = np.zeros((0, 3))
        triangles = [grid.triangles() for grid in grids]
        return [
            TriangleMesh(
                np.concatenate([none.astype(np.float32), *points]),
                np.concatenate([none.astype(np.uint32), *triangles]),
            )
        ]

    def verdict(meshes: Any) -> Check:
        return judged(model, grids, meshes[0].positions, None)

    size = sum(s.points.nbytes + s.weights.nbytes for s in model.surfaces)
    made = HostPrepared(device, call, read, verdict, setup, input_bytes=size)
    made.count = lambda output: {"surfaces": len(model.surfaces), "quads": model.span_count}
    return made
