"""What the family's systems share on a device: the upload, basis functions, the output, borders, the check."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lodbench.datasets_gen.nurbs_surface import NurbsModel
from lodbench.datasets_gen.surfaces import Floats, TriangleMesh
from lodbench.kernels.launching import group_size
from lodbench.kernels.nurbs.borders import borders_of, shared_vertices
from lodbench.kernels.nurbs.grids import Grid, placed, tables_of
from lodbench.kernels.nurbs.judged import judged
from lodbench.kernels.nurbs.params import BASES, NurbsParams
from lodbench.kernels.nurbs.reference import homogeneous, quad_scales
from lodbench.kernels.nurbs.samples import Samples, by_side, by_span
from lodbench.kernels.nurbs.vertices import vertex_launch
from lodbench.kernels.opencl import Device
from lodbench.kernels.subject import POINT, DeviceSubject
from lodbench.kernels.system import Check, DeviceSurface, Stored

PLANES = 15  # of basis functions and slopes at each sample: see `nurbs/basis.cl`
LARGEST = 1e30  # coordinate


def sampled(model: NurbsModel, params: NurbsParams) -> list[tuple[Samples, Samples]]:
    """The samples of each surface along u and v."""
    segments = 1 << params.level
    found = []
    for s in model.surfaces:
        sides = (s.knots_u, s.degree_u), (s.knots_v, s.degree_v)
        if params.per == "span":
            u, v = (by_span(knots, segments) for knots, _ in sides)
        else:
            u, v = (by_side(knots, degree, segments) for knots, degree in sides)
        found.append((u, v))
    return found


class Tessellated(DeviceSubject):
    """Surfaces on grids, all vertices of a surface one after the other.

    A system adds the steps that come before or after, and calls `finish` when all of a frame's are there.

    Attributes:
        model: about the origin that float32 counts from.
        grids: of each surface.
        buffers: on the device, by the names that kernels have for them.
        defines: the constants of `nurbs/surface.cl` for this model.

    Raises:
        ValueError: more vertices than 32-bit indices can name, or a coordinate that the sums cannot bear.
        Unsupported: the output does not fit the device's memory.
    """

    def __init__(
        self,
        device: Device,
        model: NurbsModel,
        params: NurbsParams,
        samples: Sequence[tuple[Samples, Samples]],
    ) -> None:
        super().__init__(device)
        self.model, self._params = model, params
        self.grids = placed(samples)
        self.vertices = vertex_total(self.grids)
        size = max((float(np.abs(s.points).max()) for s in model.surfaces), default=0.0)
        if size > LARGEST:
            raise ValueError(f"points: expected coordinates up to {LARGEST:g}, got {size:g}")
        with self.setup.host("borders"):
            self._borders = borders_of(model)
            self.shared = shared_vertices(model, self.grids, self._borders, params.normals)
        with self.setup.host("tables"):
            tables = tables_of(model, self.grids)
            nets = [homogeneous(s).reshape(-1, 4) for s in model.surfaces]
            controls = np.concatenate([np.zeros((0, 4)), *nets]).astype(np.float32)
            scales = [quad_scales(s).ravel() for s in model.surfaces]
            triangles = [grid.triangles() for grid in self.grids]
        rational = any(s.rational for s in model.surfaces)
        self.defines = {"NORMALS": int(params.normals), "RATIONAL": int(rational)}
        with self.setup.host("upload"):
            self.buffers = {
                "surfaces": self.upload("surfaces", tables.surfaces, np.uint32, role="pattern"),
                "samples": self.upload("samples", tables.samples, np.uint32, role="pattern"),
                "spans": self.upload("spans", tables.spans, np.float32),
                "places": self.upload("places", tables.places, np.float32, role="pattern"),
                "controls": self.upload("controls", controls, np.float32),
                "scales": self.upload(
                    "scales", np.concatenate([np.zeros(0, np.float32), *scales]), np.float32
                ),
            }
            octets = self.upload("octets", tables.octets, np.uint32, role="pattern")
            none = np.zeros((0, 3), np.uint32)
            indices = self.upload(
                "triangles", np.concatenate([none, *triangles]), np.uint32, role="pattern"
            )
        self.buffers["weights"] = self.allocate("weights", (PLANES, tables.stride), np.float32)
        self.positions = self.allocate("positions", (self.vertices, 3), np.float32, "output")
        shape = (self.vertices, 3) if params.normals else (0, 3)
        self.normals = self.allocate("normals", shape, np.float32, "output")
        self.output = (
            DeviceSurface(
                self.positions, self.normals if params.normals else None, indices, self.vertices,
                indices.shape[0],
            ),
        )  # fmt: skip
        if not self.vertices:
            return
        most = max(max(s.degree_u, s.degree_v) for s in model.surfaces)
        basis = {
            "BASIS": BASES.index(params.basis),
            "NORMALS": int(params.normals),
            "MOST_DEGREE": next(degree for degree in (3, 5, 7) if most <= degree),
        }
        with self.setup.host("build"):
            program = device.build("nurbs/basis.cl", defines=basis)
        launch = program.launch(
            "nurbs_basis", len(tables.octets), stage="basis", local=group_size(device), octets=octets,
            spans=self.buffers["spans"], places=self.buffers["places"], weights=self.buffers["weights"],
            stride=tables.stride, octet_count=len(tables.octets),
        )  # fmt: skip
        self.add(launch, bytes=4 * PLANES * len(tables.samples))
        self._add_vertices()

    def _add_vertices(self) -> None:
        """The step that writes every vertex."""
        size = self.vertex_bytes * self.vertices
        terms = [s.degree_v + 1 for s in self.model.surfaces]
        each = [6 * term * (3 if self._params.normals else 1) for term in terms]
        flops = sum(e * grid.vertices for e, grid in zip(each, self.grids, strict=True))
        read = self.buffers["controls"].size_bytes + self.buffers["weights"].size_bytes
        launch = vertex_launch(self, size)
        self.add(launch, bytes=size + read, flops=flops)

    @property
    def vertex_bytes(self) -> int:
        """Of one vertex of the output."""
        return POINT * (1 + self._params.normals)

    def finish(self) -> None:
        """The last steps of a frame, and then one frame to warm up."""
        self.share()
        self.warm_up()

    def share(self) -> None:
        """The steps that give vertices on shared borders what they have in common."""
        found = self.shared
        pairs = np.stack([found.vertices, found.roots], axis=1).astype(np.uint32)
        wanted = [(pairs, self.positions)]
        if self._params.normals:
            wanted.append((pairs[found.smooth], self.normals))
        for rows, buffer in wanted:
            if not len(rows):
                continue
            with self.setup.host("upload"):
                held = self.upload("pairs", rows, role="pattern")
            with self.setup.host("build"):
                program = self.device.build("bezier/seams.cl")
            launch = program.launch(
                "bezier_seams", -(-len(rows) // 32), stage="seams", local=group_size(self.device),
                pairs=held, normals=buffer, pair_count=len(rows),
            )  # fmt: skip
            self.add(launch, bytes=(8 + 2 * POINT) * len(rows))

    # afterwards

    def result(self) -> Sequence[TriangleMesh]:
        """The last frame's mesh; surfaces share nothing."""
        positions, normals = self._read()
        return [TriangleMesh(positions, self._triangles(), normals)]

    def parts(self) -> list[TriangleMesh]:
        """A mesh for each surface; where surfaces share a border, its points are the same to the bit in both."""
        positions, normals = self._read()
        made = []
        for grid in self.grids:
            rows = slice(grid.first, grid.first + grid.vertices)
            own = None if normals is None else normals[rows]
            triangles = Grid(grid.u, grid.v, 0).triangles()
            made.append(_without_folds(TriangleMesh(positions[rows], triangles, own)))
        return made

    def welded(self) -> TriangleMesh:
        """The last frame's mesh with every shared vertex once, and triangles at collapsed edges left out.

        Where surfaces meet at an angle a vertex has the mean of their normals.
        """
        positions, normals = self._read()
        root = np.arange(self.vertices)
        root[self.shared.vertices] = self.shared.roots
        first = np.flatnonzero(root == np.arange(self.vertices))
        number = np.zeros(self.vertices, np.uint32)
        number[first] = np.arange(len(first), dtype=np.uint32)
        vertex = number[root]
        triangles = vertex[self._triangles()]
        a, b, c = triangles.T
        triangles = triangles[(a != b) & (b != c) & (c != a)]
        if normals is not None:
            sharp = np.unique(self.shared.roots[~self.shared.smooth])
            rows = np.flatnonzero(np.isin(root, sharp))
            sums = [np.bincount(vertex[rows], normals[rows, k], len(first)) for k in range(3)]
            mean = np.stack(sums, axis=1)[number[sharp]]
            length = np.linalg.norm(mean, axis=1, keepdims=True)
            normals = normals[first]
            kept = normals[number[sharp]]
            unit = mean / np.where(length > 0, length, 1)
            normals[number[sharp]] = np.where(length > 1e-6, unit, kept)
        return TriangleMesh(positions[first], triangles, normals)

    def _triangles(self) -> Any:
        none = np.zeros((0, 3), np.uint32)
        return np.concatenate([none, *(grid.triangles() for grid in self.grids)])

    def _read(self) -> tuple[Floats, Floats | None]:
        self.live()
        wanted: list[Any] = [(self.positions, None), (self.normals, None)]
        positions, normals = self.device.read_all(*wanted)
        return positions, normals if self._params.normals else None

    def check(self) -> Check:
        """Points and normals of some rows, spread over all surfaces, against float64."""
        positions, normals = self._read()
        return judged(self.model, self.grids, positions, normals)

    def more_counters(self) -> Mapping[str, int | float]:
        """The surfaces, their KSQuads, the rows and columns of all grids, and which borders are one."""
        return {
            "surfaces": len(self.model.surfaces),
            "quads": self.model.span_count,
            "side_samples": sum(grid.rows + grid.columns for grid in self.grids),
            "launches": len(self._steps),
            **self._borders.counts(),
        }

    def stored(self) -> Stored:
        """Stored are the control points and the tables; a static buffer stores every vertex and index."""
        vertices, triangles = self.live()
        return Stored(
            stored_vertices=sum(s.points.shape[0] * s.points.shape[1] for s in self.model.surfaces),
            stored_bytes=self._bytes["pattern"] + self._bytes["input"],
            static_vertices=vertices,
            static_bytes=self.vertex_bytes * vertices + POINT * triangles,
        )


def _without_folds(mesh: TriangleMesh) -> TriangleMesh:
    """Without triangles two of whose corners are one place, as at a collapsed edge."""
    corners = mesh.positions[mesh.triangles]
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    same = [(p == q).all(axis=1) for p, q in ((a, b), (b, c), (c, a))]
    kept = ~np.any(same, axis=0)
    return mesh if kept.all() else TriangleMesh(mesh.positions, mesh.triangles[kept], mesh.normals)


def vertex_total(grids: Sequence[Grid]) -> int:
    """Vertices of all grids.

    Raises:
        ValueError: more than 32-bit indices can name.
    """
    total = sum(grid.vertices for grid in grids)
    if total > 2**32:
        raise ValueError(f"level: expected at most 2**32 vertices in all, got {total:,}")
    return total
