"""Patches as a fixed-function tessellator cuts them: factors by edge, integer or fractional spacing, a domain shader.

A patch has as many segments inside as its largest factor asks for. Each edge has its own factor; where that gives fewer
segments, the vertices on it come together in its own, so that neighbours agree to the bit on every border. Each vertex
is evaluated from the control points by itself, as a domain shader does. Fractional spacing keeps segments of length
1 / factor and puts a shorter one at both ends, so that vertices move smoothly as the factor grows.

Source: Direct3D 11 functional specification, tessellation stages; OpenGL 4.0 specification, section 2.12. Both leave
the inside of a patch to rings; here it is a parametric map's grid, of as many triangles (reconstruction).
Concheiro 2013, chapter 2, and GRAPP 2014 compare with the hardware's.
"""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels.bezier.dx11.host import Dx11
from lodbench.kernels.bezier.dx11.params import Params
from lodbench.kernels.system import System

__all__ = ["Dx11", "Params", "SYSTEM"]

SYSTEM = System(
    name="dx11",
    family="bezier",
    source="Direct3D 11, tessellation stages; Concheiro 2013, chapter 2",
    takes=(BezierPatches,),
    prepare=Dx11,
    cases={
        "level_4": Params(4),
        "level_2": Params(2),
        "odd": Params(factor=6.4, spacing="odd"),
        "even": Params(factor=6.4, spacing="even"),
        "by_length": Params(factor=7.0, edges="length"),
        "odd_by_length": Params(factor=7.5, edges="length", spacing="odd"),
        "positions_4": Params(4, normals=False),
    },
)
