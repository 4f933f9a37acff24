"""Refinement by an OpenGL driver's tessellation stages: control and evaluation shaders, equal spacing.

Source: OpenGL 4.0 specification, section 2.12; the modern answer to Boubekeur & Schlick 2005.
"""

from __future__ import annotations

from lodbench.harness.baselines.gl.patches import Patches
from lodbench.harness.baselines.gl.refined import Params, gl_system

__all__ = ["Params", "SYSTEM", "Tessellation"]


class Tessellation(Patches):
    """Flat triangles."""

    control, evaluation = "tessellation.tesc", "tessellation.tese"


SYSTEM = gl_system(
    "gl_tessellation",
    "OpenGL 4.0 tessellation, equal spacing",
    Tessellation,
    {"image_8": Params(8), "points_8": Params(8, "points")},
)
