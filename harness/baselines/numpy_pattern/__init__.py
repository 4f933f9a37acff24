"""Refinement by pattern as one writes it in NumPy: two matrix products and a normalisation, float32, in blocks.

Weights times corners is a product of (3 m, 3) by (3, n): points and normals come out as planes of x, y and z, which is
NumPy's faster form (packed vectors take three times as long). Blocks of a few coarse triangles stay in the caches
between the passes over a normal, and the output is allocated before the clock starts.

Source: the method of Boubekeur & Schlick 2005, section 3.2, on NumPy.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lodbench.datasets_gen.surfaces import Floats, TriangleMesh
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.parameters import Parameters
from lodbench.kernels.refine.attributes import canonical
from lodbench.kernels.refine.displacement import Wave
from lodbench.kernels.refine.lattice import (
    Segments,
    lattice_vertex_count,
    lattice_weights,
    refined_mesh,
)
from lodbench.kernels.refine.pattern.reference import flat
from lodbench.kernels.refine.reference import largest_error
from lodbench.kernels.refine.surface import TOLERANCE
from lodbench.kernels.system import Check, Frame

BLOCK = (
    1 << 15
)  # vertices: three planes of normals, their squares and lengths fit a second-level cache
LEAST = np.float32(
    1e-30
)  # of a squared length, as in the kernel: normals that cancel have no direction


@dataclass(frozen=True)
class Params(Parameters):
    """`segments`: parts that each coarse edge is cut into, 1 to 4096."""

    segments: Segments = 16


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> HostPrepared:
    """Corners as matrices, outputs and scratch allocated."""
    setup = Timeline()
    with setup.host("allocate"):
        mesh = canonical(mesh)
        normals_in = np.asarray(mesh.normals, np.float32)
        weights = np.ascontiguousarray(lattice_weights(params.segments).astype(np.float32).T)
        count, vertices = mesh.triangle_count, lattice_vertex_count(params.segments)
        P, N = (_planes(values[mesh.triangles]) for values in (mesh.positions, normals_in))
        positions, normals = (np.zeros((count, 3, vertices), np.float32) for _ in range(2))
        block = max(BLOCK // vertices, 1)
        squares = np.zeros((min(block, count), 3, vertices), np.float32)
        lengths = np.zeros((min(block, count), 1, vertices), np.float32)

    def call(frame: Frame) -> tuple[Floats, Floats]:
        for first in range(0, count, block):
            rows = slice(first, min(first + block, count))
            part, square = normals[rows], squares[: rows.stop - first]
            length = lengths[: rows.stop - first]
            np.matmul(
                P[3 * first : 3 * rows.stop], weights, out=positions[rows].reshape(-1, vertices)
            )
            np.matmul(N[3 * first : 3 * rows.stop], weights, out=part.reshape(-1, vertices))
            np.multiply(part, part, out=square)
            np.add(square[:, :1], square[:, 1:2], out=length)
            np.add(length, square[:, 2:], out=length)
            np.maximum(length, LEAST, out=length)
            np.sqrt(length, out=length)
            np.divide(part, length, out=part)
        return positions, normals

    def read(output: tuple[Floats, Floats]) -> list[TriangleMesh]:
        points, directions = (values.transpose(0, 2, 1).reshape(-1, 3) for values in output)
        return [refined_mesh(mesh, params.segments, points, directions)]

    def verdict(meshes: object) -> Check:
        chosen = np.unique(np.linspace(0, max(count - 1, 0), min(64, count)).astype(np.int64))
        corners = mesh.triangles[chosen]
        worst = 0.0
        if count:
            worst = largest_error(
                positions[chosen].transpose(0, 2, 1),
                normals[chosen].transpose(0, 2, 1),
                mesh.positions[corners].astype(np.float64),
                normals_in[corners].astype(np.float64),
                Wave(),
                flat,
                lattice_weights(params.segments),
            )
        what = (
            "largest error of points (over the largest coordinate) and of unit normals, "
            f"{len(chosen)} of {count} coarse triangles"
        )
        return Check(worst <= TOLERANCE, what, worst, TOLERANCE)

    return HostPrepared(device, call, read, verdict, setup, input_bytes=P.nbytes + N.nbytes)


def _planes(corners: Floats) -> Floats:
    """(m, 3 corners, 3) as the matrix (3 m, 3 corners): rows x y z of each triangle."""
    return np.ascontiguousarray(corners.transpose(0, 2, 1)).reshape(-1, 3)


SYSTEM = host_system(
    "numpy_pattern",
    "the method of Boubekeur & Schlick 2005, section 3.2, on NumPy",
    prepare,
    {"flat_16": Params(16), "flat_64": Params(64), "flat_128": Params(128)},
)
