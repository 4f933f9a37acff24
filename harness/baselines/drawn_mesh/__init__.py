"""A mesh that is on the device, drawn by the vertex, raster and fragment stages, and nothing before them.

What a static vertex buffer costs per frame, to be compared with the same buffer in an OpenGL driver.

Source: Burns & Hunt 2013, "The visibility buffer"; Pineda 1988 for the edge functions.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.parameters import Parameters
from lodbench.kernels.render import mesh_view, upload_surface
from lodbench.kernels.stages.camera import TABLE_SIZE
from lodbench.kernels.stages.raster import EMPTY_ID, Raster, Side
from lodbench.kernels.subject import DeviceSubject
from lodbench.kernels.system import Check, Frame, Stored, System, Traffic

__all__ = ["SYSTEM", "DrawnMesh", "Params"]

CHECKED = 1000  # pixels that a check looks at
TOLERANCE = (
    1 / 64
)  # pixels: corners are snapped to 1/256, and a float32 transform is off by as much at this size


@dataclass(frozen=True)
class Params(Parameters):
    """What is drawn.

    Attributes:
        width: of the image, pixels.
        height: of the image, pixels.
    """

    width: Side = TABLE_SIZE[0]
    height: Side = TABLE_SIZE[1]


class DrawnMesh(DeviceSubject):
    """One mesh and one image on the device; a frame draws the one into the other, and leaves no surface to draw."""

    def __init__(self, device: Device, mesh: TriangleMesh, params: Params) -> None:
        super().__init__(device)
        self._mesh = mesh
        with self.setup.host("upload"):
            surface = self._surface = upload_surface(device, mesh)
        self.hold("input", surface.positions, surface.triangles)
        if surface.normals is not None:
            self.hold("input", surface.normals)
        self._view = self._whole = mesh_view(mesh, size=(params.width, params.height))
        with self.setup.host("build"), self.holding("scratch"):
            self._raster = Raster(device, [surface], params.width, params.height, view=self._view)

    def enqueue(self, frame: Frame, timeline: Timeline) -> None:
        """Draw as `frame.view` sees it, or whole."""
        self.frame, self._view = frame, frame.view or self._whole
        self._raster([self._surface], frame, timeline)

    def live(self) -> tuple[int, int]:
        """Those of the mesh."""
        return self._mesh.vertex_count, self._mesh.triangle_count

    def result(self) -> Sequence[TriangleMesh]:
        """The mesh as it came."""
        return [self._mesh]

    def check(self) -> Check:
        """How far middles of pixels lie outside the triangle seen there, in float64; for the whole view."""
        what = f"pixels by which a pixel's middle lies outside its triangle, {CHECKED} of them"
        _, ids = self._raster.keys()
        rows, columns = np.nonzero(ids != EMPTY_ID)
        if not len(rows):
            return Check(not self._mesh.triangle_count, "pixels hit", 0, 0)
        some = np.unique(np.linspace(0, len(rows) - 1, CHECKED).astype(int))
        middles = np.stack([columns[some], rows[some]], axis=1) + 0.5
        corners = self._mesh.positions[self._mesh.triangles[ids[rows[some], columns[some]]]]
        worst = float(outside(self._on_screen(corners), middles).max())
        return Check(worst <= TOLERANCE, what, worst, TOLERANCE)

    def _on_screen(self, points: np.ndarray) -> np.ndarray:
        """(..., 3) model units to (..., 2) pixels."""
        m = self._view.world_to_clip
        x, y, _, w = np.moveaxis(points.astype(np.float64) @ m[:, :3].T + m[:, 3], -1, 0)
        size = self._view.width, self._view.height
        return np.stack([(1 + x / w) * size[0] / 2, (1 - y / w) * size[1] / 2], axis=-1)

    def stored(self) -> Stored:
        """The mesh with its normals."""
        vertices, size = self._surface.vertex_count, self._bytes["input"]
        return Stored(vertices, size, vertices, size)

    def traffic(self) -> Mapping[str, Traffic]:
        """Points read and screen points written, triangles read, pixels written."""
        vertices, triangles = self._surface.vertex_count, self._surface.triangle_count
        pixels = self._raster.width * self._raster.height
        return {
            "vertex_transform": Traffic(28 * vertices, 28 * vertices),
            "raster": Traffic(12 * triangles + 8 * pixels),
            "fragment": Traffic(12 * pixels),
        }


def outside(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """How far (n, 2) points lie outside triangles (n, 3, 2), over the worst edge; 0 inside, whichever way they turn."""
    edges = np.roll(corners, -1, axis=1) - corners
    to_points = points[:, None] - corners
    turn = np.sign(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0])
    crossed = edges[..., 0] * to_points[..., 1] - edges[..., 1] * to_points[..., 0]
    length = np.maximum(np.linalg.norm(edges, axis=-1), 1e-12)
    return np.maximum(-(turn[:, None] * crossed / length).min(axis=1), 0)


SYSTEM = System[Params](
    name="drawn_mesh",
    family="baselines",
    source="Burns & Hunt 2013; Pineda 1988",
    takes=(TriangleMesh,),
    prepare=DrawnMesh,
    cases={"table_size": Params(), "small": Params(160, 128)},
    notes="the frame of a static mesh: our stages' side of gl_static_vbo",
)
