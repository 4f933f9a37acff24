"""manifold3d's `simplify`: collapses within a tolerance on a closed manifold, over all threads.

The package has no target count. Where one is asked for, the tolerance is searched for by bisection when preparing,
timed apart as "search"; the call is then one simplification with that tolerance.

Source: PyPI package manifold3d, Manifold.simplify.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.harness.baselines.simplifier import asked, at_most, meshes, peer
from lodbench.kernels.opencl import Device, Timeline, Unsupported
from lodbench.kernels.parameters import Range
from lodbench.kernels.targets import Target

TRIALS = 14  # halvings of the tolerance's logarithm over six decades: to a thousandth of it


@dataclass(frozen=True, kw_only=True)
class Params(Target):
    """`tolerance`: how far the surface may move, share of the diagonal; None searches for the target's."""

    tolerance: Annotated[float, Range(0)] | None = None


def _search(solid: Any, diagonal: float, target: int) -> float:
    """The least tolerance of those tried that comes down to the target."""
    low, high = np.log(1e-6 * diagonal), np.log(diagonal)
    for _ in range(TRIALS):
        middle = (low + high) / 2
        met = solid.simplify(float(np.exp(middle))).num_tri() <= target
        low, high = (low, middle) if met else (middle, high)
    return float(np.exp(high))


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> HostPrepared:
    """The solid is built here: the call simplifies it and reads the arrays back.

    Raises:
        Unsupported: the package is not installed, or the mesh is not a closed oriented manifold.
    """
    package = peer("manifold3d", "pip install manifold3d")
    setup = Timeline()
    with setup.host("upload"):
        solid = package.Manifold(
            package.Mesh(np.array(mesh.positions), np.array(mesh.triangles, np.uint32))
        )
    if solid.status() != package.Error.NoError:
        raise Unsupported(f"needs a closed oriented manifold, mesh is {solid.status().name}")
    target = asked(mesh, params) if params.tolerance is None else mesh.triangle_count
    with setup.host("search"):
        tolerance = (
            _search(solid, mesh.diagonal, target)
            if params.tolerance is None and mesh.diagonal
            else (params.tolerance or 0.0) * mesh.diagonal
        )

    def call(_):
        result = solid.simplify(tolerance)
        result.num_tri()  # evaluation is lazy
        return result.to_mesh()

    return HostPrepared(
        device,
        call,
        read=lambda made: meshes(made.vert_properties[:, :3], made.tri_verts),
        verdict=at_most(target, slack=0.0),
        setup=setup,
        input_bytes=mesh.positions.nbytes + mesh.triangles.nbytes,
    )


SYSTEM = host_system(
    "manifold3d",
    "PyPI manifold3d, Manifold.simplify",
    prepare,
    {"default": Params()},
)
