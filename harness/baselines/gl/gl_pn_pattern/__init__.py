"""Curved PN triangles in an OpenGL driver's vertex shader: the pattern drawn once per coarse triangle, instanced.

Ten control points and six control normals of each triangle are made once, on the host, and are attributes of its
instance: packed they take 12 of the 16 that every driver has. In a texture buffer or a storage buffer they are no
faster to come by on llvmpipe, where the vertex stage then takes 1.1 and 1.9 times as long. What each vertex computes is
the sum of them by its own weights.

Source: Vlachos et al. 2001, sections 3.1 and 3.3; Boubekeur & Schlick 2005, appendix A, on real shaders.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.harness.baselines.curved import controls
from lodbench.harness.baselines.gl.instanced import Instanced
from lodbench.harness.baselines.gl.refined import Params, gl_system
from lodbench.kernels.refine.pn_triangles.reference import curved

__all__ = ["Params", "PnPattern", "SYSTEM"]


class PnPattern(Instanced):
    """The control net per instance."""

    shader = "pn_pattern.vert"
    reference = staticmethod(curved)

    def instances(self) -> dict[tuple[str, ...], NDArray[np.float32]]:
        """Four matrices of each triangle, (m, 4 matrices, 3 axes, 4 control points or normals)."""
        points, normals = controls(self.mesh)
        net = np.concatenate([points, normals[:, 4:], normals[:, :4]], axis=1)
        names = tuple(f"controls_{number}" for number in range(4))
        return {names: net.reshape(-1, 4, 4, 3).transpose(0, 1, 3, 2)}


SYSTEM = gl_system(
    "gl_pn_pattern",
    "Vlachos et al. 2001, sections 3.1 and 3.3, on an OpenGL driver",
    PnPattern,
    {"image_16": Params(16), "points_16": Params(16, "points")},
)
