"""What every subject of the driver shares that draws a surface: the frame, the image, feedback."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lodbench.harness.baselines.gl.driver import Canvas, assign, context, view_uniforms
from lodbench.kernels.opencl import Timeline
from lodbench.kernels.stages.shading import Shading
from lodbench.kernels.system import Footprint, Frame, Traffic, View

STAGE = "draw"
CHECKED = 128  # primitives that a check looks at


class Drawing(Protocol):
    """Parameters that say what is drawn.

    `output`: "image", the whole frame into an image; or "points", the stages before the raster alone, what they give
    kept by transform feedback. `width` and `height` of the image in pixels; a frame's view may say otherwise only by
    being an error.
    """

    @property
    def output(self) -> str: ...

    @property
    def width(self) -> int: ...

    @property
    def height(self) -> int: ...


class Drawn(ABC):
    """`coarse` primitives in an OpenGL driver, ready to be drawn finer; subclasses say by which shaders.

    A frame ends when the driver has finished it, so its wall time is the driver's. There is no output on the device.

    Raises:
        Unsupported: no OpenGL driver.
    """

    output: tuple[()] = ()

    def __init__(
        self, coarse: int, params: Drawing, view: View, shading: Shading | None = None
    ) -> None:
        self.setup = Timeline()
        self.drawing, self.shading = params, shading or Shading()
        self.coarse = coarse
        with self.setup.host("context"):
            self.gl = context()
        with self.setup.host("build"):
            self.canvas = Canvas(params.width, params.height, self.shading)
            self.draw_program, self.feedback_program = self.programs()
        self._view = view
        self._kept: Any = None
        self.bytes = 0
        if self.coarse:
            with self.setup.host("upload"):
                self.upload()
            if params.output == "points":
                self._kept = self.gl.buffer(reserve=self.feedback_bytes())
            with self.setup.host("first_launch"):
                # have the driver compile: one primitive is enough for that
                self._issue(self._view, 1)

    @abstractmethod
    def programs(self) -> tuple[Any, Any]:
        """(for images, for transform feedback)."""

    @abstractmethod
    def upload(self) -> None:
        """Make the vertex arrays; count what they hold in `bytes`."""

    @abstractmethod
    def draw(self, coarse: int) -> None:
        """Issue the draw call of an image, with the first `coarse` primitives refined."""

    @abstractmethod
    def keep(self, buffer: Any) -> None:
        """Issue the call that leaves what the stages give in `buffer`."""

    @abstractmethod
    def feedback_bytes(self) -> int:
        """Of what `keep` writes."""

    @abstractmethod
    def counters(self) -> Mapping[str, int | float]:
        """What a frame draws: `vertices` and `triangles` at the least."""

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
        """Draw the image with the first `coarse` primitives, or keep all points; and wait until it is done."""
        if self.drawing.output == "points":
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
        """What the stages before the raster give, through transform feedback."""
        if not self.coarse:
            return b""
        gl = context()
        buffer = self._kept or gl.buffer(reserve=self.feedback_bytes())
        buffer.clear()  # fewer may come than there is room for
        self._keep_in(buffer, self._view)
        gl.finish()
        return buffer.read()

    def chosen(self) -> NDArray[np.int64]:
        """The primitives that a check looks at."""
        last = max(self.coarse - 1, 0)
        return np.unique(np.linspace(0, last, min(CHECKED, self.coarse)).astype(np.int64))

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
