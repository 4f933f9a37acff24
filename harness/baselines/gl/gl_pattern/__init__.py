"""Refinement by pattern in an OpenGL driver's vertex shader: the pattern drawn once per coarse triangle, instanced.

Source: Boubekeur & Schlick 2005, section 3.2, on real shaders; instances stand for the paper's draw calls.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.harness.baselines.gl.instanced import Instanced
from lodbench.harness.baselines.gl.refined import Params, gl_system

__all__ = ["Params", "Pattern", "SYSTEM"]


class Pattern(Instanced):
    """The corners and their normals per instance."""

    shader = "pattern.vert"

    def instances(self) -> dict[tuple[str, ...], NDArray[np.float32]]:
        """P0 P1 P2 and N0 N1 N2 of each triangle, (m, 3, 3) each."""
        mesh, normals = self.mesh, np.asarray(self.mesh.normals, np.float32)
        return {
            ("p0", "p1", "p2"): mesh.positions[mesh.triangles],
            ("n0", "n1", "n2"): normals[mesh.triangles],
        }


SYSTEM = gl_system(
    "gl_pattern",
    "Boubekeur & Schlick 2005, section 3.2, on an OpenGL driver",
    Pattern,
    {"image_16": Params(16), "points_16": Params(16, "points")},
)
