"""NURBS surfaces in an OpenGL driver's vertex shader: a map drawn once for each KSQuad, instanced.

Control points and knots lie in a texture; the shader makes basis functions at its place and sums. What faces away or
lies outside the view is left to the driver.

Source: Concheiro 2013, section 6.2, on real shaders.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.finest import finest
from lodbench.datasets_gen.nurbs_surface import NurbsModel
from lodbench.datasets_gen.surfaces import Floats, TriangleMesh
from lodbench.harness.baselines.gl.bezier import KEPT, RECORD, Params
from lodbench.harness.baselines.gl.drawn import Drawn
from lodbench.harness.baselines.gl.driver import build
from lodbench.harness.baselines.nurbs import span_grids
from lodbench.kernels.bezier.lattice import lattice_parameters, lattice_triangles
from lodbench.kernels.nurbs.grids import SPAN_FLOATS, placed, tables_of
from lodbench.kernels.nurbs.judged import judged
from lodbench.kernels.nurbs.reference import homogeneous, quad_scales, surface_origin
from lodbench.kernels.nurbs.samples import by_span
from lodbench.kernels.nurbs.tessellated import vertex_total
from lodbench.kernels.opencl import Device
from lodbench.kernels.render import mesh_view
from lodbench.kernels.stages.shading import Shading
from lodbench.kernels.system import Check, System

__all__ = ["Params", "SYSTEM", "Spans"]

WIDTH = 1024  # texels of a row of the texture


def _tables(model: NurbsModel) -> tuple[Floats, NDArray[np.int32], Floats]:
    """Texels (n, 4); of each KSQuad whole numbers, (quads, 6), and floats, (quads, 4): see `nurbs.vert`."""
    grids = placed([(by_span(s.knots_u, 1), by_span(s.knots_v, 1)) for s in model.surfaces])
    tables = tables_of(model, grids)
    nets = [homogeneous(s).reshape(-1, 4) for s in model.surfaces]
    controls = np.concatenate([np.zeros((0, 4)), *nets]).astype(np.float32)
    first_span = len(controls)
    numbers, floats = [np.zeros((0, 6), np.int32)], [np.zeros((0, 4), np.float32)]
    for surface, grid, words in zip(
        model.surfaces, grids, tables.surfaces.astype(np.int64), strict=True
    ):
        sides = [
            tables.samples[first : first + len(side) - 1].astype(np.int64)
            for first, side in ((words[3], grid.u), (words[4], grid.v))
        ]
        u, v = np.meshgrid(*(np.arange(len(side)) for side in sides), indexing="ij")
        rows, columns = sides[0][u.ravel()], sides[1][v.ravel()]
        spans = [first_span + SPAN_FLOATS // 4 * side[:, 3] for side in (rows, columns)]
        first = words[5] + rows[:, 0] * words[6] + columns[:, 0]
        same = np.broadcast_to(words[[6, 7, 8]], (len(first), 3))
        numbers.append(np.column_stack([first, same[:, 0], *spans, same[:, 1:]]).astype(np.int32))
        origin = np.broadcast_to(surface_origin(surface), (len(first), 3))
        floats.append(np.column_stack([origin, quad_scales(surface).ravel()]).astype(np.float32))
    texels = np.concatenate([controls, tables.spans.reshape(-1, 4)])
    return texels, np.concatenate(numbers), np.concatenate(floats)


class Spans(Drawn):
    """The map per vertex, the KSQuad per instance.

    Raises:
        ValueError: more vertices than 32-bit indices can name.
        Unsupported: no OpenGL driver.
    """

    def __init__(self, model: NurbsModel, params: Params, shading: Shading | None = None) -> None:
        self.model, self.params = model, params
        self.grids, self._order = span_grids(model, params.level)
        vertex_total(self.grids)
        view = mesh_view(finest(model), size=(params.width, params.height))
        super().__init__(model.span_count, params, view, shading)

    def programs(self) -> tuple[Any, Any]:
        """See `Drawn`; with degrees as constants where all surfaces have the same."""
        found = {(s.degree_u, s.degree_v) for s in self.model.surfaces}
        self._degrees = found.pop() if len(found) == 1 else None
        defines: dict[str, int] = {}
        if self._degrees is not None:
            defines["DEGREE_U"], defines["DEGREE_V"] = self._degrees
        return (
            build("nurbs.vert", "surface.frag", defines=defines),
            build("nurbs.vert", varyings=KEPT, defines=defines),
        )

    def upload(self) -> None:
        """See `Drawn`."""
        texels, numbers, floats = _tables(self.model)
        filled = np.zeros((-(-len(texels) // WIDTH), WIDTH, 4), np.float32)
        filled.reshape(-1, 4)[: len(texels)] = texels
        self._table = self.gl.texture((WIDTH, len(filled)), 4, filled.tobytes(), dtype="f4")
        self._table.filter = self.gl.NEAREST, self.gl.NEAREST
        self.bytes += filled.nbytes
        places = np.stack(lattice_parameters(self.params.level), axis=1).astype(np.float32)
        self._places = len(places)
        arrays = [
            (self.buffer(places), "2f", "place"),
            (self.buffer(numbers[:, :4]), "4i/i", "quad"),
            (self.buffer(floats), "4f/i", "origin"),
        ]
        if self._degrees is None:
            arrays.append((self.buffer(numbers[:, 4:]), "2i/i", "degrees"))
        triangles = self.buffer(lattice_triangles(self.params.level))
        self._array = self.gl.vertex_array(self.draw_program, arrays, triangles)
        self._points = self.gl.vertex_array(self.feedback_program, arrays)

    def draw(self, coarse: int) -> None:
        """See `Drawn`."""
        self._table.use(0)
        self._array.render(instances=coarse)

    def keep(self, buffer: Any) -> None:
        """See `Drawn`."""
        self._table.use(0)
        self._points.transform(
            buffer, mode=self.gl.POINTS, vertices=self._places, instances=self.coarse
        )

    def feedback_bytes(self) -> int:
        """Of a row for each vertex."""
        return RECORD.itemsize * len(self._every())

    def _every(self) -> range:
        return range(self.coarse * ((1 << self.params.level) + 1) ** 2)

    def result(self) -> Sequence[TriangleMesh]:
        """Every KSQuad's vertices in the map's order; they share nothing."""
        kept = np.frombuffer(self.feedback(), RECORD)
        first = np.arange(self.coarse)[:, None, None] * ((1 << self.params.level) + 1) ** 2
        triangles = (lattice_triangles(self.params.level)[None] + first).reshape(-1, 3)
        return [TriangleMesh(kept["point"].copy(), triangles, kept["normal"].copy())]

    def check(self) -> Check:
        """Points and normals of some rows, spread over all surfaces, against float64."""
        kept = np.frombuffer(self.feedback(), RECORD)[self._order]
        return judged(self.model, self.grids, kept["point"], kept["normal"])

    def counters(self) -> Mapping[str, int | float]:
        """What a frame draws, every vertex of a KSQuad once."""
        return {
            "vertices": len(self._every()),
            "triangles": self.coarse * 2 * 4**self.params.level,
            "surfaces": len(self.model.surfaces),
            "quads": self.coarse,
        }


def prepare(device: Device, model: NurbsModel, params: Params) -> Spans:
    """Tables in a texture and in the instances' attributes."""
    return Spans(model, params)


SYSTEM = System[Params](
    "gl_nurbs",
    "baselines",
    "Concheiro 2013, section 6.2, on an OpenGL driver",
    (NurbsModel,),
    prepare,
    {"image_3": Params(3), "points_3": Params(3, "points")},
    runs_on="gl",
)
