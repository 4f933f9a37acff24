"""NURBS surfaces cut into Bezier patches, one for each KSQuad, and these under vertex shader tessellation.

What one does without a pipeline for NURBS: knots are inserted once, before the frames, until each span is a patch of
its own. The patches of the Bezier family are bicubic and not rational, so that is what it takes.

Source: Concheiro 2013, chapters 2 (VST) and 6 (which does without this conversion); knot insertion after Boehm 1980.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from lodbench.datasets_gen.nurbs_surface import Doubles, NurbsModel, NurbsSurface, cut
from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.harness.baselines.nurbs import span_grids
from lodbench.kernels.bezier.vst.host import Vst
from lodbench.kernels.bezier.vst.params import Params
from lodbench.kernels.nurbs.judged import judged
from lodbench.kernels.nurbs.samples import first_knots
from lodbench.kernels.opencl import Device, Timeline, Unsupported
from lodbench.kernels.system import Check, System

__all__ = ["Params", "SYSTEM", "AsBezier", "bezier_patches"]

DEGREE = 3


def _split(knots: Doubles, rows: Doubles) -> Doubles:
    """Control points of each span as a Bezier curve of its own, (spans, 4, ...)."""
    starts = first_knots(knots)
    ends = knots[starts + 1]
    return np.stack(
        [cut(knots, rows, DEGREE, *pair)[1] for pair in zip(knots[starts], ends, strict=True)]
    )


def bezier_patches(surface: NurbsSurface) -> Doubles:
    """The patches of a bicubic surface, (spans along u, spans along v, 4, 4, 3).

    Raises:
        Unsupported: another degree, or weights that differ.
    """
    degrees = surface.degree_u, surface.degree_v
    if degrees != (DEGREE, DEGREE) or surface.rational:
        kind = "rational" if surface.rational else "not rational"
        raise Unsupported(
            f"needs bicubic surfaces that are not rational, has one of {degrees[0]} x {degrees[1]}, {kind}"
        )
    along_u = _split(surface.knots_u, surface.points)  # (spans_u, 4, n_v, 3)
    along_v = _split(surface.knots_v, along_u.transpose(2, 0, 1, 3))  # (spans_v, 4, spans_u, 4, 3)
    return along_v.transpose(2, 0, 3, 1, 4)


class AsBezier(Vst):
    """The patches of all surfaces, surface after surface, along v fastest; each is checked as the surface it was."""

    def __init__(self, device: Device, model: NurbsModel, params: Params) -> None:
        converting = Timeline()
        with converting.host("convert"):
            parts = [bezier_patches(s).reshape(-1, 4, 4, 3) for s in model.surfaces]
            points = np.concatenate([np.zeros((0, 4, 4, 3)), *parts]).astype(np.float32)
        self._model = model
        super().__init__(device, BezierPatches(points), params)
        self.setup.stage_s["convert"] = converting.stage_s["convert"]

    def check(self) -> Check:
        """Points of some rows against the surfaces before they were cut; then as of any patches, normals too.

        Where patches meet at less than the family's smallest angle they share a normal, which no surface has.
        """
        grids, order = span_grids(self._model, self._params.level)
        found = judged(self._model, grids, self._read()[0][order], None)
        return super().check() if found.passed else found

    def more_counters(self) -> Mapping[str, int | float]:
        """With the surfaces and their KSQuads."""
        counts = {"surfaces": len(self._model.surfaces), "quads": self._model.span_count}
        return {**super().more_counters(), **counts}


def prepare(device: Device, model: NurbsModel, params: Params) -> AsBezier:
    """The patches, under one level.

    Raises:
        Unsupported: a surface that is rational or not bicubic, or levels of patches of their own.
    """
    if not params.is_uniform:
        raise Unsupported("needs one level for all patches, has one for each")
    return AsBezier(device, model, params)


SYSTEM = System[Params](
    name="nurbs_as_bezier",
    family="baselines",
    source="Concheiro 2013, chapter 2 (VST), after knot insertion",
    takes=(NurbsModel,),
    prepare=prepare,
    cases={"level_3": Params(3), "positions_3": Params(3, normals=False)},
    notes="bicubic surfaces that are not rational; conversion is part of the set-up",
)
