"""Refinement as one writes it in NumPy: two matrix products and a normalisation, float32, in blocks.

Points times weights is a product of (3 m, k) by (k, n): points and normals come out as planes of x, y and z, which is
NumPy's faster form (packed vectors take three times as long). Blocks of a few coarse triangles stay in the caches
between the passes over a normal, and the output is allocated before the clock starts.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
from lodbench.kernels.refine.reference import Reference, largest_error
from lodbench.kernels.refine.surface import TOLERANCE
from lodbench.kernels.system import Check, Frame, System

BLOCK = (
    1 << 15
)  # vertices: three planes of normals, their squares and lengths fit a second-level cache
LEAST = np.float32(
    1e-30
)  # of a squared length, as in the kernel: normals that cancel have no direction
CHECKED = 64  # coarse triangles that a check looks at


@dataclass(frozen=True)
class Params(Parameters):
    """`segments`: parts that each coarse edge is cut into, 1 to 4096."""

    segments: Segments = 16


@dataclass(frozen=True)
class Evaluated:
    """A surface that is linear in what each coarse triangle has.

    Attributes:
        controls: of a canonical mesh, what its triangles have for points (m, k, 3) and for normals (m, j, 3), float32.
        weights: of (w, u, v), (n, 3), how much each of them counts: (n, k) and (n, j), float64.
        reference: the same surface in float64.
    """

    controls: Callable[[TriangleMesh], tuple[Floats, Floats]]
    weights: Callable[[NDArray[np.float64]], tuple[NDArray[np.float64], NDArray[np.float64]]]
    reference: Reference


def prepare(device: Device, mesh: TriangleMesh, params: Params, surface: Evaluated) -> HostPrepared:
    """What the triangles have as matrices, outputs and scratch allocated."""
    setup = Timeline()
    with setup.host("allocate"):
        mesh = canonical(mesh)
        wuv = lattice_weights(params.segments)
        point_weights, normal_weights = (
            np.ascontiguousarray(weights.astype(np.float32).T) for weights in surface.weights(wuv)
        )
        P, N = (_planes(values) for values in surface.controls(mesh))
        count, vertices = mesh.triangle_count, lattice_vertex_count(params.segments)
        positions, normals = (np.zeros((count, 3, vertices), np.float32) for _ in range(2))
        block = max(BLOCK // vertices, 1)
        squares = np.zeros((min(block, count), 3, vertices), np.float32)
        lengths = np.zeros((min(block, count), 1, vertices), np.float32)

    def call(frame: Frame) -> tuple[Floats, Floats]:
        for first in range(0, count, block):
            rows = slice(first, min(first + block, count))
            planes = slice(3 * first, 3 * rows.stop)
            part, square = normals[rows], squares[: rows.stop - first]
            length = lengths[: rows.stop - first]
            np.matmul(P[planes], point_weights, out=positions[rows].reshape(-1, vertices))
            np.matmul(N[planes], normal_weights, out=part.reshape(-1, vertices))
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
        last = max(count - 1, 0)
        chosen = np.unique(np.linspace(0, last, min(CHECKED, count)).astype(np.int64))
        corners = mesh.triangles[chosen]
        worst = 0.0
        if count:
            worst = largest_error(
                positions[chosen].transpose(0, 2, 1),
                normals[chosen].transpose(0, 2, 1),
                mesh.positions[corners].astype(np.float64),
                np.asarray(mesh.normals, np.float64)[corners],
                Wave(),
                surface.reference,
                wuv,
            )
        what = (
            "largest error of points (over the largest coordinate) and of unit normals, "
            f"{len(chosen)} of {count} coarse triangles"
        )
        return Check(worst <= TOLERANCE, what, worst, TOLERANCE)

    return HostPrepared(device, call, read, verdict, setup, input_bytes=P.nbytes + N.nbytes)


def _planes(values: Floats) -> Floats:
    """(m, k, 3) as the matrix (3 m, k): rows x y z of each triangle."""
    return np.ascontiguousarray(values.transpose(0, 2, 1)).reshape(-1, values.shape[1])


def gemm_system(
    name: str, source: str, surface: Evaluated, cases: Mapping[str, Params]
) -> System[Params]:
    """A baseline that evaluates `surface`; see `System` for the other arguments."""

    def prepared(device: Device, mesh: TriangleMesh, params: Params) -> HostPrepared:
        return prepare(device, mesh, params, surface)

    return host_system(name, source, prepared, cases)
