"""Vertex clustering with means: one vertex per grid cell, where the cell's vertices lie on average.

What quadrics are measured against: the same cells and the same triangles, only corners and creases are rounded off.

Source: Rossignac & Borrel 1993, Multi-resolution 3D approximations for rendering complex scenes, all weights equal;
DeCoro & Tatarchuk 2007, slide 14, compare with it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.prepare import simplifier
from lodbench.kernels.cluster.target import GridTarget
from lodbench.kernels.cluster.vertex_average.host import prepare
from lodbench.kernels.parameters import Range
from lodbench.kernels.system import System


@dataclass(frozen=True)
class Params(GridTarget):
    """How far to simplify; targets are those of `GridTarget`, and `cells` comes first.

    Attributes:
        chunks: maps that are summed apart, 1 to 64; the number decides how sums are rounded, so it belongs here.
        remove_duplicates: of output triangles with the same three vertices, whichever way they face, keep the first.
    """

    chunks: Annotated[int, Range(1, 64)] = 2
    remove_duplicates: bool = False


SYSTEM = System(
    name="vertex_average",
    family="cluster",
    source="Rossignac & Borrel 1993; DeCoro & Tatarchuk 2007, slide 14",
    takes=(TriangleMesh,),
    prepare=prepare,
    cases={"cells_64": Params(64), "tenth": Params(target_reduction=0.9)},
    verbs={"simplify": simplifier(prepare, Params)},
)
