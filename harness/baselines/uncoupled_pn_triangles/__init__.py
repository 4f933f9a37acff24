"""The fewest segments that each curved triangle needs by itself, whatever its neighbours take: a bound, full of cracks.

A triangle gets the least number of segments at which its flat pieces are within a tolerance of its patch, measured at
`SAMPLES` parameters. No crack-free pattern can do with less everywhere: its edges must suit both sides. What adaptive
refinement of a mesh can gain over one pattern for all is therefore at most what this gains.

Source: none; Vlachos et al. 2001 for the patches.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.curved import control_weights, controls
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.parameters import Parameters, Range
from lodbench.kernels.refine.attributes import canonical
from lodbench.kernels.refine.lattice import Segments, lattice_triangles, lattice_weights
from lodbench.kernels.system import Check, Frame

__all__ = ["SYSTEM", "Params"]

SAMPLES = (
    24  # segments of a lattice of parameters where the distance is measured; one of 23 lies between
)
Doubles = NDArray[np.float64]


@dataclass(frozen=True)
class Params(Parameters):
    """What a triangle may take, and must reach.

    Attributes:
        segments: the most that an edge is cut into.
        tolerance: largest distance from a point of the patch to the flat pieces at the same parameters, as a fraction
            of the bounding-box diagonal.
        doubling: only powers of two.
    """

    segments: Segments = 64
    tolerance: Annotated[float, Range(0, open="low")] = 1e-4
    doubling: bool = False

    @property
    def sizes(self) -> list[int]:
        """Numbers of segments there are to choose from, ascending; the last is the most."""
        if not self.doubling:
            return list(range(1, self.segments + 1))
        return [1 << depth for depth in range(self.segments.bit_length())]


def flat_weights(segments: int, places: Doubles) -> Doubles:
    """What the flat pieces of a pattern make of the patch's control points, at parameters (w, u, v): (places, 10)."""
    down, along = (1 - places[:, 0]) * segments, places[:, 2] * segments
    i = np.minimum(down.astype(np.int64), segments - 1)
    j = np.minimum(along.astype(np.int64), i)
    down, along = down - i, along - j
    upright = along <= down  # else in the triangle that has its edge in the row above
    rows = np.stack([i, i + 1, np.where(upright, i + 1, i)])
    columns = np.stack([j, j + 1, np.where(upright, j, j + 1)])
    shares = np.stack([1 - np.maximum(down, along), np.minimum(down, along), abs(down - along)])
    # at the end of a row the third one has no share, and lies outside
    columns = np.minimum(columns, rows)
    at_lattice = control_weights(lattice_weights(segments))[0]
    return np.einsum("kn,kng->ng", shares, at_lattice[rows * (rows + 1) // 2 + columns])


def least_segments(points: Doubles, tolerance: float, sizes: Sequence[int]) -> NDArray[np.int64]:
    """The first of ascending `sizes` at which each patch is near enough, (m,); the last where none is.

    Args:
        points: control points, (m, 10, 3).
        tolerance: in their unit.
        sizes: numbers of segments.
    """
    places = np.concatenate([lattice_weights(n) for n in (SAMPLES, SAMPLES - 1)])
    patch = control_weights(places)[0]
    found = np.full(len(points), sizes[-1], np.int64)
    open_ones = np.arange(len(points))
    for size in sizes:
        off = (patch - flat_weights(size, places)) @ points[open_ones]
        near = (off**2).sum(axis=2).max(axis=1, initial=0) <= tolerance**2
        found[open_ones[near]] = size
        open_ones = open_ones[~near]
        if not len(open_ones):
            break
    return found


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> HostPrepared:
    """The patches, made beforehand; the call chooses segments and evaluates."""
    setup = Timeline()
    with setup.host("upload"):
        mesh = canonical(mesh)
        points = controls(mesh)[0].astype(np.float64)
        tolerance = params.tolerance * mesh.diagonal

    def call(frame: Frame) -> tuple[list[Doubles], list[NDArray[np.int64]]]:
        chosen = least_segments(points, tolerance, params.sizes)
        vertices, triangles, total = [], [], 0
        for size in np.unique(chosen):
            there = control_weights(lattice_weights(size))[0] @ points[chosen == size]
            first = total + np.arange(len(there)) * there.shape[1]
            vertices.append(there.reshape(-1, 3))
            triangles.append((lattice_triangles(size)[None] + first[:, None, None]).reshape(-1, 3))
            total += len(vertices[-1])
        return vertices, triangles

    def read(output: tuple[list[Doubles], list[NDArray[np.int64]]]) -> list[TriangleMesh]:
        vertices = np.concatenate([np.zeros((0, 3)), *output[0]]).astype(np.float32)
        triangles = np.concatenate([np.zeros((0, 3), np.int64), *output[1]]).astype(np.uint32)
        return [TriangleMesh(vertices, triangles)]

    def verdict(meshes: Sequence[TriangleMesh]) -> Check:
        expected = int((least_segments(points, tolerance, params.sizes) ** 2).sum())
        off = abs(meshes[0].triangle_count - expected)
        return Check(not off, "triangles more or fewer than expected", float(off), 0.0)

    return HostPrepared(device, call, read, verdict, setup, input_bytes=points.nbytes)


SYSTEM = host_system(
    "uncoupled_pn_triangles",
    "a bound, in NumPy; patches of Vlachos et al. 2001, section 3.1",
    prepare,
    {
        "tolerance_1e-3": Params(tolerance=1e-3),
        "doubling_1e-3": Params(tolerance=1e-3, doubling=True),
    },
    notes="each curved triangle with the fewest segments that it needs by itself; cracks wherever neighbours differ",
)
