"""Curved PN triangles by an OpenGL driver's tessellation stages, equal spacing: what they were made for.

The control shader makes the ten control points and six control normals of a patch anew in every frame, the evaluation
shader the point and the normal. Neither shares arithmetic with the kernels or with the NumPy reference.

Source: Vlachos et al. 2001, sections 3.1 and 3.3; OpenGL 4.0 specification, section 2.12.
"""

from __future__ import annotations

from lodbench.harness.baselines.gl.patches import Patches
from lodbench.harness.baselines.gl.refined import Params, gl_system
from lodbench.kernels.refine.pn_triangles.reference import curved

__all__ = ["Params", "PnTessellation", "SYSTEM"]


class PnTessellation(Patches):
    """Cubic triangles."""

    control, evaluation = "pn_tessellation.tesc", "pn_tessellation.tese"
    reference = staticmethod(curved)


SYSTEM = gl_system(
    "gl_pn_tessellation",
    "Vlachos et al. 2001, sections 3.1 and 3.3, in OpenGL 4.0 tessellation",
    PnTessellation,
    {"image_8": Params(8), "points_8": Params(8, "points")},
)
