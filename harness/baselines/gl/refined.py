"""What the subjects that draw a refined mesh share: their parameters, what comes back for checks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Floats, TriangleMesh
from lodbench.harness.baselines.gl.drawn import Drawn
from lodbench.kernels.opencl import Device
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
from lodbench.kernels.system import Check, System


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


class Refined(Drawn):
    """A refined mesh in an OpenGL driver, ready to be drawn; subclasses say by which shaders.

    Attributes:
        reference: the surface in float64.

    Raises:
        Unsupported: no OpenGL driver.
    """

    reference: Reference = staticmethod(flat)

    def __init__(self, mesh: TriangleMesh, params: Params, shading: Shading | None = None) -> None:
        self.params = params
        self.mesh = canonical(mesh)
        view = mesh_view(self.mesh, size=(params.width, params.height))
        super().__init__(self.mesh.triangle_count, params, view, shading)

    def feedback_bytes(self) -> int:
        """Of points and normals of every instance of the pattern."""
        return 24 * self.coarse * lattice_vertex_count(self.params.segments)

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


def gl_system(
    name: str, source: str, subject: type[Refined], cases: Mapping[str, Params]
) -> System[Params]:
    """A baseline that draws a mesh by what `subject` is; see `System` for the arguments."""

    def prepare(device: Device, mesh: TriangleMesh, params: Params) -> Refined:
        return subject(mesh, params)

    return System(name, "baselines", source, (TriangleMesh,), prepare, cases, runs_on="gl")
