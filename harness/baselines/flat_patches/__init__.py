"""The flat refinement pattern over the corners of Bezier patches: the rate beside which tessellations stand.

A patch is two flat triangles between its corners, each under a triangular pattern of 2^level segments: as many
triangles as a tessellation has, and (n + 1)(n + 2) vertices to a patch where that has (n + 1)^2. It is another surface.

Source: Boubekeur & Schlick 2005, section 3.2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lodbench.datasets_gen.surfaces import BezierPatches, TriangleMesh
from lodbench.kernels.bezier.params import Level
from lodbench.kernels.opencl import Device
from lodbench.kernels.parameters import Parameters
from lodbench.kernels.refine import pattern
from lodbench.kernels.system import System

__all__ = ["Params", "SYSTEM", "corner_mesh"]


@dataclass(frozen=True)
class Params(Parameters):
    """`level`: of resolution, 0 to 10: an edge has 2^level segments."""

    level: Level = 4


def corner_mesh(patches: BezierPatches) -> TriangleMesh:
    """Two triangles between the corners of each patch, which shares none with its neighbours."""
    corners = patches.points[:, ::3, ::3].reshape(-1, 3)
    pair = np.array([(0, 2, 3), (0, 3, 1)])
    triangles = (4 * np.arange(len(patches.points))[:, None, None] + pair).reshape(-1, 3)
    return TriangleMesh(corners, triangles.astype(np.uint32))


def prepare(device: Device, patches: BezierPatches, params: Params) -> pattern.Pattern:
    """The pattern over the corners."""
    return pattern.Pattern(device, corner_mesh(patches), pattern.Params(1 << params.level))


SYSTEM = System[Params](
    name="flat_patches",
    family="baselines",
    source="Boubekeur & Schlick 2005, section 3.2",
    takes=(BezierPatches,),
    prepare=prepare,
    cases={"level_4": Params(4), "level_7": Params(7)},
    notes="the rate of the flat refinement pattern, beside which tessellations stand",
)
