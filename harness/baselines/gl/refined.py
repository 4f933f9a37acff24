"""What the subjects that draw a refined surface share: the frame, the image, what comes back for checks."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Floats, TriangleMesh
from lodbench.harness.baselines.gl.driver import Canvas, assign, context, view_uniforms
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.parameters import Parameters, Range
from lodbench.kernels.refine.attributes import canonical
from lodbench.kernels.refine.displacement import Wave
from lodbench.kernels.refine.lattice import lattice_vertex_count, lattice_weights, refined_mesh
from lodbench.kernels.refine.pattern.reference import flat
from lodbench.kernels.refine.reference import Reference, largest_error
from lodbench.kernels.refine.surface import TOLERANCE
from lodbench.kernels.render import mesh_view
from lodbench.kernels.stages.raster import Side
from lodbench.kernels.stages.shading import Shading
from lodbench.kernels.system import Check, Footprint, Frame, System, Traffic, View

STAGE = "draw"
CHECKED = 64  # coarse triangles that a check looks at


@dataclass(frozen=True)
class Params(Parameters):
    """What is drawn.

    Attributes:
        segments: parts that each coarse edge is cut into, at least 1.
        output: "image", the whole frame into an image; or "points", the vertex stages alone, their points and normals
            kept by transform feedback.
        width, height: of the image, pixels; a frame's view may say otherwise only by being an error.
    """

    segments: Annotated[int, Range(1)] = 1
    output: Literal["image", "points"] = "image"
    width: Side = 1280
    height: Side = 1024


class Refined(ABC):
    """A refined surface in an OpenGL driver, ready to be drawn; subclasses say by which shaders.

    A frame ends when the driver has finished it, so its wall time is the driver's. There is no output on the device.

    Attributes:
        reference: the surface in float64.

    Raises:
        Unsupported: no OpenGL driver.
    """

    output: tuple[()] = ()
    reference: Reference = staticmethod(flat)

    def __init__(self, mesh: TriangleMesh, params: Params, shading: Shading | None = None) -> None:
        self.setup = Timeline()
        self.params, self.shading = params, shading or Shading()
        self.mesh = canonical(mesh)
        self.coarse = self.mesh.triangle_count
        with self.setup.host("context"):
            self.gl = context()
        with self.setup.host("build"):
            self.canvas = Canvas(params.width, params.height, self.shading)
            self.draw_program, self.feedback_program = self.programs()
        self._view = mesh_view(self.mesh, size=(params.width, params.height))
        self._kept: Any = None
        self.bytes = 0
        if self.coarse:
            with self.setup.host("upload"):
                self.upload()
            if params.output == "points":
                self._kept = self.gl.buffer(reserve=self.feedback_bytes())
            with self.setup.host("first_launch"):
                # have the driver compile: one triangle is enough for that
                self._issue(self._view, 1)

    @abstractmethod
    def programs(self) -> tuple[Any, Any]:
        """(for images, for transform feedback)."""

    @abstractmethod
    def upload(self) -> None:
        """Make the vertex arrays; count what they hold in `bytes`."""

    @abstractmethod
    def draw(self, coarse: int) -> None:
        """Issue the draw call of an image, with the first `coarse` triangles refined."""

    @abstractmethod
    def keep(self, buffer: Any) -> None:
        """Issue the call that leaves points and normals in `buffer`."""

    def feedback_bytes(self) -> int:
        """Of what `keep` writes: points and normals of every instance of the pattern."""
        return 24 * self.coarse * lattice_vertex_count(self.params.segments)

    def buffer(self, values: NDArray[Any]) -> Any:
        """A buffer of the driver that holds `values`."""
        data = np.ascontiguousarray(values)
        self.bytes += data.nbytes
        return self.gl.buffer(data.tobytes())

    def enqueue(self, frame: Frame, timeline: Timeline) -> None:
        """Draw and wait until it is done.

        Raises:
            ValueError: a view of another size than the image.
        """
        view = frame.view or self._view
        if (view.width, view.height) != (self.canvas.width, self.canvas.height):
            raise ValueError(
                f"view: expected {self.canvas.width} x {self.canvas.height} pixels, "
                f"got {view.width} x {view.height}"
            )
        with timeline.host(STAGE):
            context()
            self._issue(view, self.coarse)

    def _issue(self, view: View, coarse: int) -> None:
        """Draw the image with the first `coarse` triangles, or keep all points; and wait until it is done."""
        if self.params.output == "points":
            if coarse:
                self._keep_in(self._kept, view)
        else:
            assign(self.draw_program, self.uniforms(view))
            self.canvas.begin()
            if coarse:
                self.draw(coarse)
        self.gl.finish()

    def uniforms(self, view: View) -> dict[str, Any]:
        """What the shaders are told of a view."""
        return view_uniforms(view, self.shading)

    def _keep_in(self, buffer: Any, view: View) -> None:
        assign(self.feedback_program, self.uniforms(view))
        self.canvas.target.use()  # no window: without a target even discarded drawing is an error
        self.keep(buffer)

    def image(self) -> NDArray[np.uint8]:
        """The last frame, (height, width, 3) uint8, row 0 on top."""
        return self.canvas.image()

    def feedback(self) -> bytes:
        """What the vertex stages give, through transform feedback."""
        if not self.coarse:
            return b""
        gl = context()
        buffer = self._kept or gl.buffer(reserve=self.feedback_bytes())
        buffer.clear()  # fewer may come than there is room for
        self._keep_in(buffer, self._view)
        gl.finish()
        return buffer.read()

    def points_and_normals(self) -> tuple[Floats, Floats]:
        """(coarse triangles, pattern vertices, 3) float32 each."""
        vertices = lattice_vertex_count(self.params.segments)
        both = np.frombuffer(self.feedback(), np.float32).reshape(self.coarse, vertices, 6)
        return both[..., :3], both[..., 3:]

    def result(self) -> Sequence[TriangleMesh]:
        """The refined mesh as the vertex stages gave it; instances share nothing."""
        points, normals = self.points_and_normals()
        flat = points.reshape(-1, 3), normals.reshape(-1, 3)
        return [refined_mesh(self.mesh, self.params.segments, *flat)]

    def check(self) -> Check:
        """Points and normals of some coarse triangles against the float64 reference."""
        chosen = self.chosen()
        worst = 0.0
        if len(chosen):
            points, normals = self.points_and_normals()
            worst = largest_error(
                points[chosen],
                normals[chosen],
                *self.corners(chosen),
                Wave(),
                self.reference,
                lattice_weights(self.params.segments),
            )
        what = (
            "largest error of points (over the largest coordinate) and of unit normals, "
            f"{len(chosen)} of {self.coarse} coarse triangles"
        )
        return Check(worst <= TOLERANCE, what, worst, TOLERANCE)

    def chosen(self) -> NDArray[np.int64]:
        """The coarse triangles that a check looks at."""
        last = max(self.coarse - 1, 0)
        return np.unique(np.linspace(0, last, min(CHECKED, self.coarse)).astype(np.int64))

    def corners(self, chosen: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Corners of coarse triangles and their normals, (k, 3 corners, 3) float64 each."""
        return self.at(self.mesh.triangles[chosen])

    def at(self, vertices: NDArray[np.integer]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Positions and normals of coarse vertices, (..., 3) float64 each."""
        normals = np.asarray(self.mesh.normals, np.float64)
        return self.mesh.positions[vertices].astype(np.float64), normals[vertices]

    def counters(self) -> Mapping[str, int | float]:
        """What a frame draws."""
        segments = self.params.segments
        return {
            "vertices": self.coarse * lattice_vertex_count(segments),
            "triangles": self.coarse * segments**2,
            "coarse_triangles": self.coarse,
            "segments": segments,
        }

    def footprint(self) -> Footprint:
        """What the vertex arrays hold; the driver's own memory is not seen."""
        counts = self.counters()
        static = 24 * int(counts["vertices"]) + 12 * int(counts["triangles"])
        return Footprint(
            input_bytes=self.bytes,
            output_bytes=4 * self.canvas.width * self.canvas.height * 2,
            stored_bytes=self.bytes,
            static_vertices=int(counts["vertices"]),
            static_bytes=static,
        )

    def traffic(self) -> Mapping[str, Traffic]:
        """Nothing: what the driver moves is not known."""
        return {}


def gl_system(
    name: str, source: str, subject: type[Refined], cases: Mapping[str, Params]
) -> System[Params]:
    """A baseline that draws a mesh by what `subject` is; see `System` for the arguments."""

    def prepare(device: Device, mesh: TriangleMesh, params: Params) -> Refined:
        return subject(mesh, params)

    return System(name, "baselines", source, (TriangleMesh,), prepare, cases, runs_on="gl")
