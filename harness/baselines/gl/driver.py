"""An OpenGL context without a window, and the image that it draws into."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.opencl import Unsupported
from lodbench.kernels.stages.shading import Shading, lights
from lodbench.kernels.system import View

SHADERS = Path(__file__).parent
STAGES = {
    ".vert": "vertex_shader",
    ".tesc": "tess_control_shader",
    ".tese": "tess_evaluation_shader",
    ".geom": "geometry_shader",
    ".frag": "fragment_shader",
}


def context() -> Any:
    """The one EGL context of this process, shared by all subjects, made current again.

    Raises:
        Unsupported: no moderngl, no EGL, or no driver with OpenGL 3.3.
    """
    return _context().__enter__()  # others in this process may have made theirs current


@cache
def _context() -> Any:
    try:
        import moderngl
    except ImportError as error:
        raise Unsupported(f"needs moderngl, this environment has none: {error}") from None
    try:
        return moderngl.create_standalone_context(require=330, backend="egl")  # pyright: ignore
    except Exception as error:  # the loader raises whatever the missing library raised
        raise Unsupported(
            f"needs an OpenGL 3.3 driver through EGL (libegl1, libgl1-mesa-dri), machine has: {error}"
        ) from None


def driver_name() -> str:
    """The driver's own name, such as "llvmpipe (LLVM 15.0.6, 256 bits)"."""
    return str(context().info["GL_RENDERER"])


def build(
    *files: str, varyings: Iterable[str] = (), defines: Mapping[str, int] | None = None
) -> Any:
    """The program of these shader files, relative to this folder.

    `varyings` are kept by transform feedback; `defines` stand behind the first line, which says the version.
    """
    lines = "".join(f"#define {name} {value}\n" for name, value in (defines or {}).items())
    sources = {}
    for file in files:
        version, rest = (SHADERS / file).read_text("utf-8").split("\n", 1)
        sources[STAGES[Path(file).suffix]] = f"{version}\n{lines}{rest}"
    return context().program(**sources, varyings=tuple(varyings))


def assign(program: Any, values: Mapping[str, Any]) -> None:
    """Set the uniforms that the program kept; the compiler drops unused ones."""
    for name, value in values.items():
        if name in program:
            program[name].value = value


@cache
def _function(name: str, *arguments: Any) -> Any:
    """An OpenGL entry point by its name; needs the context to be current."""
    loader = ctypes.CDLL("libEGL.so.1").eglGetProcAddress
    loader.restype, loader.argtypes = ctypes.c_void_p, [ctypes.c_char_p]
    return ctypes.CFUNCTYPE(None, *arguments)(loader(name.encode()))


def keep_patches(program: Any, buffer: Any, draw: Callable[[], None]) -> None:
    """Transform feedback of the patches that `draw` draws, as triangles: what moderngl's `transform` does not know.

    They are kept one draw call after the other, and nothing is rasterised.
    """
    gl, number = context(), ctypes.c_uint
    discard, feedback, triangles = 0x8C89, 0x8C8E, 0x0004
    _function("glUseProgram", number)(program.glo)
    _function("glBindBufferBase", number, number, number)(feedback, 0, buffer.glo)
    _function("glEnable", number)(discard)
    _function("glBeginTransformFeedback", number)(triangles)
    draw()
    _function("glEndTransformFeedback")()
    _function("glDisable", number)(discard)
    _ = gl.error  # the program was made current twice, which feedback reports and ignores


class Canvas:
    """Colour (8 bits per channel) and depth (24 bits) of one image, with its background.

    Args:
        width: pixels.
        height: pixels.
        shading: colours, as for `Raster`.
    """

    def __init__(self, width: int, height: int, shading: Shading) -> None:
        gl = self.gl = context()
        self.width, self.height, self.shading = width, height, shading
        self.colour = gl.texture((width, height), 4)
        self.depth = gl.depth_texture((width, height))
        self.target = gl.framebuffer([self.colour], self.depth)
        self._background = build("background.vert", "background.frag")
        top, bottom = shading.background
        assign(self._background, {"top": top, "bottom": bottom})
        self._nothing = gl.vertex_array(self._background, [])

    def begin(self) -> None:
        """Clear the depth and draw the background."""
        gl = self.gl
        self.target.use()
        gl.viewport = (0, 0, self.width, self.height)
        gl.disable(gl.DEPTH_TEST | gl.CULL_FACE)
        self.target.clear(depth=1.0)
        self._nothing.render(vertices=3)
        gl.enable(gl.DEPTH_TEST)
        if self.shading.cull:
            gl.enable(gl.CULL_FACE)

    def image(self) -> NDArray[np.uint8]:
        """What was drawn, (height, width, 3) uint8, row 0 on top."""
        data = np.frombuffer(self.target.read(components=3, alignment=1), np.uint8)
        return data.reshape(self.height, self.width, 3)[::-1].copy()

    def depths(self) -> NDArray[np.float32]:
        """Depth 0..1, (height, width) float32, row 0 on top."""
        data = np.frombuffer(self.depth.read(alignment=1), np.float32)
        return data.reshape(self.height, self.width)[::-1].copy()


def view_uniforms(view: View, shading: Shading) -> dict[str, Any]:
    """The uniforms of `surface.vert` and `surface.frag` for a view."""
    matrix = tuple(view.world_to_clip.T.astype(np.float32).ravel().tolist())
    return {"world_to_clip": matrix, "surface_colour": shading.surface, **lights(view)}
