"""Bezier patches as one writes it in NumPy: the basis times control points times the basis, float32, in blocks.

Points come out as planes of x, y and z, NumPy's faster form; two products of four terms each are faster than one of
sixteen. Normals take the same products of the derivatives, a cross product and a division. Blocks of a few patches
stay in the caches between the passes over a normal, and the output is allocated before the clock starts.

Source: Q(u, v) = U B V of Concheiro 2013, section 1.2, on NumPy.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lodbench.datasets_gen.surfaces import BezierPatches, Floats, TriangleMesh
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.kernels.bezier.lattice import lattice_triangles, side_vertices
from lodbench.kernels.bezier.params import BezierParams
from lodbench.kernels.bezier.reference import bernstein, bernstein_slopes
from lodbench.kernels.bezier.tessellated import judged, vertex_total
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.system import Check, Frame

__all__ = ["Params", "SYSTEM"]

BLOCK = 1 << 14  # vertices: three planes of three vectors fit a second-level cache
LEAST = np.float32(1e-30)  # of a squared length

Params = BezierParams


def prepare(device: Device, patches: BezierPatches, params: BezierParams) -> HostPrepared:
    """Control points as planes, outputs and scratch allocated."""
    setup = Timeline()
    with setup.host("allocate"):
        count, side = len(patches.points), side_vertices(params.level)
        vertices = vertex_total(count, side * side)
        t = np.arange(side) / (side - 1)
        basis, slopes = (b(t).astype(np.float32) for b in (bernstein, bernstein_slopes))
        P = np.ascontiguousarray(patches.points.transpose(0, 3, 1, 2))
        positions = np.zeros((count, 3, side, side), np.float32)
        normals = np.zeros_like(positions) if params.normals else None
        block = max(BLOCK // (side * side), 1)
        scratch = np.zeros((4, min(block, count), 3, side, side), np.float32)

    def product(left: Floats, middle: Floats, right: Floats, out: Floats) -> None:
        np.matmul(left, np.matmul(middle, right.T), out=out)

    def call(frame: Frame) -> tuple[Floats, Floats | None]:
        if normals is None:
            product(basis, P, basis, positions)
            return positions, None
        for first in range(0, count, block):
            rows = slice(first, min(first + block, count))
            along_u, along_v, term, other = scratch[:, : rows.stop - first]
            part, square, length = normals[rows], other, term[:, 0]
            product(basis, P[rows], basis, positions[rows])
            product(slopes, np.diff(P[rows], axis=2), basis, along_u)
            product(basis, np.diff(P[rows], axis=3), slopes, along_v)
            for k in range(3):
                i, j = (k + 1) % 3, (k + 2) % 3
                np.multiply(along_u[:, i], along_v[:, j], out=part[:, k])
                np.multiply(along_u[:, j], along_v[:, i], out=term[:, k])
            np.subtract(part, term, out=part)
            np.multiply(part, part, out=square)
            np.add(square[:, 0], square[:, 1], out=length)
            np.add(length, square[:, 2], out=length)
            np.maximum(length, LEAST, out=length)
            np.sqrt(length, out=length)
            np.divide(part, length[:, None], out=part)
        return positions, normals

    def packed(planes: Floats) -> Floats:
        return planes.reshape(count, 3, side * side).transpose(0, 2, 1).reshape(-1, 3)

    def read(output: tuple[Floats, Floats | None]) -> list[TriangleMesh]:
        first = np.arange(count)[:, None, None] * side * side
        triangles = (lattice_triangles(params.level)[None] + first).reshape(-1, 3)
        normals = None if output[1] is None else packed(output[1])
        return [TriangleMesh(packed(output[0]), triangles, normals)]

    def verdict(meshes: Any) -> Check:
        (mesh,) = meshes
        return judged(patches, params.level, mesh.positions, mesh.normals, np.arange(side * side))

    made = HostPrepared(device, call, read, verdict, setup, input_bytes=P.nbytes)
    made.count = lambda output: {"patches": count, "vertices": vertices}
    return made


SYSTEM = host_system(
    "numpy_bezier",
    "Concheiro 2013, section 1.2, on NumPy",
    prepare,
    {
        "level_4": Params(4),
        "level_7": Params(7),
        "positions_7": Params(7, normals=False),
    },
    takes=(BezierPatches,),
)
