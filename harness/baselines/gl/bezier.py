"""What the subjects share that draw Bezier patches by an OpenGL driver's shaders: parameters, feedback, the check."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.finest import finest
from lodbench.datasets_gen.surfaces import BezierPatches, TriangleMesh
from lodbench.harness.baselines.gl.drawn import Drawn
from lodbench.kernels.bezier.lattice import lattice_parameters, side_vertices
from lodbench.kernels.bezier.params import Level
from lodbench.kernels.bezier.reference import normals_at, points_at
from lodbench.kernels.bezier.tessellated import vertex_total
from lodbench.kernels.exactness import verdict
from lodbench.kernels.opencl import Device
from lodbench.kernels.parameters import Parameters
from lodbench.kernels.render import mesh_view
from lodbench.kernels.stages.raster import Side
from lodbench.kernels.stages.shading import Shading
from lodbench.kernels.system import Check, System

KEPT = ("surface_position", "shaded_normal", "weights", "patch_number")
RECORD = np.dtype([("point", "3f4"), ("normal", "3f4"), ("uv", "2f4"), ("patch", "i4")])


@dataclass(frozen=True)
class Params(Parameters):
    """What is drawn.

    Attributes:
        level: of resolution, 0 to 10: a patch has 2^level segments along each side.
        output: "image", the whole frame into an image; or "points", the stages before the raster alone, their points
            and normals kept by transform feedback.
        width, height: of the image, pixels; a frame's view may say otherwise only by being an error.
    """

    level: Level = 4
    output: Literal["image", "points"] = "image"
    width: Side = 1280
    height: Side = 1024


class DrawnPatches(Drawn):
    """Bezier patches in an OpenGL driver, ready to be drawn; subclasses say by which shaders.

    Attributes:
        patches: as they came.
        params: of the subject.
        segments: 2^level.

    Raises:
        ValueError: more vertices than 32-bit indices can name.
        Unsupported: no OpenGL driver.
    """

    def __init__(
        self, patches: BezierPatches, params: Params, shading: Shading | None = None
    ) -> None:
        self.patches, self.params = patches, params
        self.segments = 1 << params.level
        vertex_total(len(patches.points), side_vertices(params.level) ** 2)
        view = mesh_view(finest(patches), size=(params.width, params.height))
        super().__init__(len(patches.points), params, view, shading)

    def feedback_bytes(self) -> int:
        """Of three rows for each triangle."""
        return RECORD.itemsize * 3 * self.coarse * 2 * self.segments**2

    def kept(self) -> NDArray[Any]:
        """What the stages give, of dtype `RECORD`: three rows per triangle, or as `result` says."""
        return np.frombuffer(self.feedback(), RECORD)

    def result(self) -> Sequence[TriangleMesh]:
        """The triangles as the stages gave them, three points each."""
        kept = self.kept()
        triangles = np.arange(len(kept), dtype=np.uint32).reshape(-1, 3)
        return [TriangleMesh(kept["point"].copy(), triangles, kept["normal"].copy())]

    def check(self) -> Check:
        """Points and normals of some patches in float64, and that every virtual vertex came."""
        kept, chosen = self.kept(), self.chosen()
        rows = kept[np.isin(kept["patch"], chosen)]
        number = np.searchsorted(chosen, rows["patch"])
        steps = rows["uv"] * np.float32(self.segments)
        row, column = np.rint(steps).astype(np.int64).clip(0, self.segments).T
        place = row * (self.segments + 1) + column
        P = self.patches.points[chosen].astype(np.float64)
        u, v = lattice_parameters(self.params.level)
        normals, certain = normals_at(P, u, v)
        box = self.patches.points.reshape(-1, 3).astype(np.float64)
        size = np.linalg.norm(np.ptp(box, axis=0)) if len(box) else 1.0
        size = max(float(size), float(np.abs(box).max(initial=0)), 1e-37)
        off = np.abs(rows["point"] - points_at(P, u, v)[number, place])
        turned = np.linalg.norm(rows["normal"] - normals[number, place], axis=-1)
        came = np.zeros(certain.shape, np.bool_)
        came[number, place] = True
        beside = np.abs(steps - np.stack([row, column], axis=1)).max(initial=0)
        return verdict(
            off.max(initial=0) / size,
            turned[certain[number, place]].max(initial=0),
            f"{len(chosen)} of {self.coarse} patches",
            beside if came.all() else np.inf,
        )

    def counters(self) -> Mapping[str, int | float]:
        """What a frame draws, every vertex of a patch once."""
        return {
            "vertices": self.coarse * (self.segments + 1) ** 2,
            "triangles": self.coarse * 2 * self.segments**2,
            "patches": self.coarse,
            "segments": self.segments,
        }


def gl_bezier_system(name: str, source: str, subject: type[DrawnPatches]) -> System[Params]:
    """A baseline that draws patches by what `subject` is; see `System` for the arguments."""

    def prepare(device: Device, patches: BezierPatches, params: Params) -> DrawnPatches:
        return subject(patches, params)

    cases = {"image_4": Params(4), "points_4": Params(4, "points")}
    return System(name, "baselines", source, (BezierPatches,), prepare, cases, runs_on="gl")
