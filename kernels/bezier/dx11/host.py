"""Factors of every edge, and the grid of a patch over all patches in one launch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from lodbench.datasets_gen.surfaces import BezierPatches, TriangleMesh
from lodbench.kernels.bezier.dx11.params import Params
from lodbench.kernels.bezier.dx11.reference import cut, place, polygon_lengths, snapped
from lodbench.kernels.bezier.lattice import grid_triangles
from lodbench.kernels.bezier.reference import Doubles, normals_at, points_at
from lodbench.kernels.bezier.tessellated import (
    CHECKED,
    CONTROL_FLOATS,
    check_size,
    control_rows,
    vertex_total,
)
from lodbench.kernels.exactness import verdict
from lodbench.kernels.launching import group_size, kernel_defines
from lodbench.kernels.opencl import Device
from lodbench.kernels.subject import POINT, DeviceSubject
from lodbench.kernels.system import Check, DeviceSurface

FLOPS = {False: 150, True: 330}  # of a vertex, counted from the kernel: without normals, and with


class Dx11(DeviceSubject):
    """Patches under fixed-function tessellation: see `lodbench.kernels.bezier.dx11`.

    Raises:
        ValueError: more vertices than 32-bit indices can name, or a coordinate that the sums cannot bear.
        Unsupported: the output does not fit the device's memory.
    """

    def __init__(self, device: Device, patches: BezierPatches, params: Params) -> None:
        super().__init__(device)
        self._patches, self._params = patches, params
        self.count = count = len(patches.points)
        check_size(patches.points)
        with self.setup.host("factors"):
            self._factors, self._cuts = self._edges(patches)
            found = cut(np.array(params.largest, np.float32), params.spacing)
            self._factor, self._segments = float(found[0]), int(found[1])
        side = self._segments + 1
        vertices = vertex_total(count, side * side)
        with self.setup.host("upload"):
            triangles = self.upload("triangles", grid_triangles(side), role="pattern")
            controls = self.upload("controls", control_rows(patches.points), np.float32)
            factors = self.upload("factors", self._factors.astype(np.float32))
            cuts = self.upload("cuts", self._cuts.astype(np.uint32))
        positions = self.allocate("positions", (vertices, 3), np.float32, "output")
        shape = (vertices if params.normals else 0, 3)
        normals = self.allocate("normals", shape, np.float32, "output")
        surface = DeviceSurface(
            positions,
            normals if params.normals else None,
            triangles,
            vertices,
            count * 2 * self._segments**2,
            instances=count,
            instance_vertices=side * side,
        )
        self.output = (surface,)
        defines = kernel_defines(device, 0) | {"NORMALS": int(params.normals)}
        with self.setup.host("build"):
            program = device.build("bezier/dx11/domain.cl", defines=defines)
        launch = program.launch(
            "dx11_domain", count * side, stage="domain", local=group_size(device), controls=controls, factors=factors,
            cuts=cuts, positions=positions, normals=normals, factor=self._factor, segments=self._segments,
            row_count=count * side,
        )  # fmt: skip
        if vertices:
            moved = POINT * (1 + params.normals) * vertices + 4 * (CONTROL_FLOATS + 8) * count
            self.add(launch, bytes=moved, flops=FLOPS[params.normals] * vertices)
        self.warm_up()

    def _edges(self, patches: BezierPatches) -> tuple[Doubles, np.ndarray]:
        """Factor and segments of every edge, (m, 4) each; patches that share one agree."""
        largest = self._params.largest
        factors = np.full((len(patches.points), 4), largest)
        if self._params.edges == "length" and len(factors):
            lengths = polygon_lengths(patches.points.astype(np.float64))
            factors = np.maximum(largest * lengths / max(float(lengths.max()), 1e-37), 1.0)
        found, cuts = cut(factors.astype(np.float32), self._params.spacing)
        return found.astype(np.float32).astype(np.float64), cuts

    def parameters(self, patch: int) -> tuple[Doubles, Doubles]:
        """U and v of the patch's vertices, (n + 1)^2 each, in float64."""
        n = self._segments
        inside = place(np.arange(n + 1), self._factor, n)
        u, v = np.meshgrid(inside, inside, indexing="ij")
        for edge, side in enumerate((v[0], v[n], u[:, 0], u[:, n])):
            own = int(self._cuts[patch, edge])
            side[:] = place(snapped(n, own), float(self._factors[patch, edge]), own)
        return u.ravel(), v.ravel()

    def result(self) -> Sequence[TriangleMesh]:
        """The last frame's mesh; patches share nothing."""
        self.live()
        (surface,) = self.output
        positions, normals = self.device.read_all(
            (surface.positions, None), (surface.normals or surface.positions, None)
        )
        side = self._segments + 1
        first = np.arange(self.count, dtype=np.uint32) * np.uint32(side * side)
        triangles = (grid_triangles(side)[None] + first[:, None, None]).reshape(-1, 3)
        return [TriangleMesh(positions, triangles, normals if surface.normals else None)]

    def check(self) -> Check:
        """Points and normals of some patches, spread over all, against float64."""
        (mesh,) = self.result()
        chosen = np.unique(np.linspace(0, max(self.count - 1, 0), min(CHECKED, self.count)))
        box = self._patches.points.reshape(-1, 3).astype(np.float64)
        size = np.linalg.norm(np.ptp(box, axis=0)) if len(box) else 1.0
        size = max(float(size), float(np.abs(box).max(initial=0)), 1e-37)
        each = (self._segments + 1) ** 2
        position = normal = 0.0
        for patch in chosen.astype(np.int64):
            rows = slice(patch * each, (patch + 1) * each)
            P = self._patches.points[patch : patch + 1].astype(np.float64)
            u, v = self.parameters(int(patch))
            off = np.abs(mesh.positions[rows] - points_at(P, u, v)[0]).max()
            position = float(np.max([position, off / size]))  # NaN is worst
            if mesh.normals is not None:
                expected, certain = normals_at(P, u, v)
                turned = np.linalg.norm(mesh.normals[rows] - expected[0], axis=-1)[certain[0]]
                normal = float(np.max([normal, turned.max(initial=0)]))
        return verdict(position, normal, f"{len(chosen)} of {self.count} patches")

    def more_counters(self) -> Mapping[str, int | float]:
        """Patches, their segments, and the fewest of any edge."""
        return {
            "patches": self.count,
            "segments": self._segments,
            "least_segments": int(self._cuts.min(initial=self._segments)),
        }
