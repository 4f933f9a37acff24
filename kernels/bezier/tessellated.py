"""What the family's systems share on a device: the upload, the output, seams, the check against float64."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import BezierPatches, Floats, TriangleMesh
from lodbench.kernels.bezier import borders
from lodbench.kernels.bezier.arrangement import Arrangement
from lodbench.kernels.bezier.lattice import lattice_parameters, stored_map
from lodbench.kernels.bezier.params import BezierParams
from lodbench.kernels.bezier.reference import normals_at, patch_scales, points_at
from lodbench.kernels.exactness import verdict
from lodbench.kernels.launching import group_size
from lodbench.kernels.opencl import Buffer, Device
from lodbench.kernels.subject import POINT, DeviceSubject
from lodbench.kernels.system import Check, DeviceSurface, Stored

CHECKED = 128  # patches that a check looks at
CONTROL_FLOATS = 64
LARGEST = 1e36  # coordinate: a patch's coefficients by powers are 64 times that at the most


def control_rows(points: Floats) -> Floats:
    """Patches as kernels read them, (m, 64) float32: see `bezier/patch.cl`; zeros lose their sign."""
    rows = np.zeros((len(points), 16, 4), np.float32)
    rows[:, :, :3] = points.reshape(-1, 16, 3) + np.float32(0)
    rows[:, 0, 3] = patch_scales(points)
    return rows.reshape(-1, CONTROL_FLOATS)


def check_size(points: Floats) -> None:
    """Refuse coordinates that the sums cannot bear.

    Raises:
        ValueError: larger than `LARGEST`.
    """
    if (size := float(np.abs(points).max(initial=0))) > LARGEST:
        raise ValueError(f"points: expected coordinates up to {LARGEST:g}, got {size:g}")


class Tessellated(DeviceSubject):
    """Patches of one level, all vertices of a patch one after the other.

    A system allocates what else it has, adds the steps that write `positions` and `normals`, and calls `finish`.

    Attributes:
        arrangement: of each patch's output.
        controls: on the device, as `control_rows`.
        positions, normals: of the output; there are no normals where none are asked for.

    Raises:
        ValueError: more vertices than 32-bit indices can name, or a coordinate that the sums cannot bear.
        Unsupported: the output does not fit the device's memory.
    """

    def __init__(
        self,
        device: Device,
        patches: BezierPatches,
        params: BezierParams,
        arrangement: Arrangement,
    ) -> None:
        super().__init__(device)
        self._patches, self._params = patches, params
        self.arrangement = arrangement
        self.count = len(patches.points)
        slots = len(arrangement.places)
        check_size(patches.points)
        self.vertices = vertex_total(self.count, slots)
        with self.setup.host("borders"):
            self._borders = borders.borders_of(patches.points)
        with self.setup.host("upload"):
            self.controls = self.upload("controls", control_rows(patches.points), np.float32)
            triangles = self.upload("triangles", arrangement.triangles, role="pattern")
        self.positions = self.allocate("positions", (self.vertices, 3), np.float32, "output")
        shape = (self.vertices, 3) if params.normals else (0, 3)
        self.normals = self.allocate("normals", shape, np.float32, "output")
        surface = DeviceSurface(
            self.positions,
            self.normals if params.normals else None,
            triangles,
            self.vertices,
            self.count * len(arrangement.triangles),
            instances=self.count,
            instance_vertices=slots,
        )
        self.output = (surface,)

    @property
    def vertex_bytes(self) -> int:
        """Of one vertex of the output."""
        return POINT * (1 + self._params.normals)

    def upload_map(self) -> Buffer:
        """The parametric map of the level."""
        return self.upload("map", stored_map(self._params.level), role="pattern")

    def finish(self) -> None:
        """The last step of a frame, normals along smooth borders; then one frame to warm up."""
        if self._params.normals:
            with self.setup.host("borders"):
                found = borders.seams(self._borders, self._params.level)
                pairs = self.arrangement.slot_pairs(found)
            with self.setup.host("upload"):
                buffer = self.upload("pairs", pairs, role="pattern")
            if len(pairs):
                with self.setup.host("build"):
                    program = self.device.build("bezier/seams.cl")
                launch = program.launch(
                    "bezier_seams", -(-len(pairs) // 32), stage="seams", local=group_size(self.device), pairs=buffer,
                    normals=self.normals, pair_count=len(pairs),
                )  # fmt: skip
                self.add(launch, bytes=(8 + 2 * POINT) * len(pairs))
        self.warm_up()

    # afterwards

    def result(self) -> Sequence[TriangleMesh]:
        """The last frame's mesh; patches share nothing."""
        positions, normals = self._read()
        first = np.arange(self.count, dtype=np.uint32) * np.uint32(len(self.arrangement.places))
        triangles = self.arrangement.triangles[None] + first[:, None, None]
        return [TriangleMesh(positions, triangles.reshape(-1, 3), normals)]

    def welded(self) -> TriangleMesh:
        """The last frame's mesh with every shared vertex once, and triangles at collapsed edges left out.

        Where patches meet at an angle a vertex has the mean of their normals.
        """
        positions, normals = self._read()
        vertex, count = borders.sharing(self._borders, self._params.level)
        vertex = vertex[:, self.arrangement.places].ravel()
        first = np.empty(count, np.int64)
        first[vertex[::-1]] = np.arange(len(vertex))[::-1]
        starts = np.arange(self.count)[:, None, None] * len(self.arrangement.places)
        triangles = vertex[(self.arrangement.triangles[None] + starts).reshape(-1, 3)]
        a, b, c = triangles.T
        triangles = triangles[(a != b) & (b != c) & (c != a)]
        if normals is not None:
            normals = shared_normals(normals, vertex, first)
        return TriangleMesh(positions[first], triangles, normals)

    def _read(self) -> tuple[Floats, Floats | None]:
        self.live()
        wanted: list[Any] = [(self.positions, None), (self.normals, None)]
        positions, normals = self.device.read_all(*wanted)
        return positions, normals if self._params.normals else None

    def check(self) -> Check:
        """Points and normals of some patches, spread over all, against float64."""
        positions, normals = self._read()
        return judged(
            self._patches, self._params.level, positions, normals, self.arrangement.places
        )

    def more_counters(self) -> Mapping[str, int | float]:
        """The patches, and which of their borders are one."""
        return {
            "patches": self.count,
            "segments": 1 << self._params.level,
            "launches": len(self._steps),
            **self._borders.counts(),
        }

    def stored(self) -> Stored:
        """Stored are the map and the control points; a static buffer stores every vertex and index."""
        vertices, triangles = self.live()
        return Stored(
            stored_vertices=len(self.arrangement.places),
            stored_bytes=self._bytes["pattern"] + self._bytes["input"],
            static_vertices=vertices,
            static_bytes=self.vertex_bytes * vertices + POINT * triangles,
        )


def shared_normals(normals: Floats, vertex: NDArray[np.uint32], first: NDArray[np.int64]) -> Floats:
    """The normal of each vertex: that of all who share it, to the bit, or else the mean of theirs."""
    shared = normals[first]
    differs = (normals != shared[vertex]).any(axis=1)
    mixed = np.zeros(len(first), bool)
    mixed[vertex[differs]] = True
    rows = np.flatnonzero(mixed[vertex])
    sums = [np.bincount(vertex[rows], normals[rows, k], len(first)) for k in range(3)]
    mean = np.stack(sums, axis=1)[mixed]
    length = np.linalg.norm(mean, axis=1, keepdims=True)
    shared[mixed] = np.where(length > 1e-6, mean / np.where(length > 0, length, 1), shared[mixed])
    return shared


def judged(
    patches: BezierPatches,
    level: int,
    positions: Floats,
    normals: Floats | None,
    places: borders.Numbers,
) -> Check:
    """Were these the points and normals of the patches? Some, spread over all, are compared with float64.

    Args:
        patches: that were tessellated.
        level: of resolution.
        positions: (m * slots, 3).
        normals: likewise, or None.
        places: (slots,) the virtual vertex of each slot.
    """
    count, slots = len(patches.points), len(places)
    chosen = np.unique(np.linspace(0, max(count - 1, 0), min(CHECKED, count)).astype(np.int64))
    P = patches.points[chosen].astype(np.float64)
    u, v = (values[places] for values in lattice_parameters(level))
    points = points_at(P, u, v)
    box = patches.points.reshape(-1, 3).astype(np.float64)
    size = max(np.linalg.norm(np.ptp(box, axis=0)), np.abs(box).max()) if len(box) else 1.0
    off = np.abs(positions.reshape(-1, slots, 3)[chosen] - points).max(initial=0)
    turned = 0.0
    if normals is not None:
        expected, certain = normals_at(P, u, v)
        apart = np.linalg.norm(normals.reshape(-1, slots, 3)[chosen] - expected, axis=-1)
        turned = apart[certain].max(initial=0)
    return verdict(off / max(size, 1e-37), turned, f"{len(chosen)} of {count} patches")


def vertex_total(patches: int, slots: int) -> int:
    """Vertices of all patches.

    Raises:
        ValueError: more than 32-bit indices can name.
    """
    if patches * slots > 2**32:
        raise ValueError(f"level: expected at most 2**32 vertices in all, got {patches * slots:,}")
    return patches * slots
