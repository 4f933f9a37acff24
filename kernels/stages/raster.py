"""Draw a surface that is on the device: vertex transform, raster and fragment stages, image left on the device."""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.opencl.device import Device, Unsupported
from lodbench.kernels.opencl.launch import Launch, Program
from lodbench.kernels.opencl.memory import Buffer
from lodbench.kernels.opencl.timeline import Timeline
from lodbench.kernels.parameters import Range, check
from lodbench.kernels.stages.camera import to_screen
from lodbench.kernels.stages.scan import chunk_local
from lodbench.kernels.stages.shading import Shading, lights
from lodbench.kernels.system import DeviceSurface, Frame, View

TILE = 64  # pixels per side
EMPTY_ID = 0xFFFFFFFF  # what `ids` holds where nothing was drawn
Side: TypeAlias = Annotated[int, Range(1, 16384)]  # pixels; the guard band of sub-pixels ends there
FLAGS_OPEN = 16  # words of counters before the flags of the tiles, as in screen.cl
EMPTY_KEY = (0x3F800000 << 32) | EMPTY_ID  # depth 1 and no triangle, as in screen.cl
LARGE_PIXELS = 4096  # of a triangle's box: above, and above 1/256 of the image, tiles share it
LARGE_CAPACITY = 1 << 15  # such triangles; one too many is drawn where it is found
MAPS = 16  # private maps at most: each costs 8 bytes per pixel that it touches
GPU_ITEMS = 1 << 14
ATOMICS = "cl_khr_int64_extended_atomics"
VERTEX, RASTER, FRAGMENT = "vertex_transform", "raster", "fragment"


class Raster:
    """Draws a `DeviceSurface` into an image on the device; passed as `raster` to `run`.

    Each compute unit draws into a map of its own, one 64-bit key (depth above triangle id) per pixel, and the smallest
    key wins: no order, no schedule and no number of maps can change a bit, and equal depths go to the lower id. GPUs
    share one map through 64-bit atomics. Triangles too large for one item are shared out by tiles of 64 x 64 pixels.
    Everything is allocated and every kernel compiled here; a call only enqueues.

    Args:
        device: where the surface is.
        surface: of any topology; later calls may pass others, instanced or not as it is: more vertices, more memory.
        width: pixels, 1 to 16384.
        height: pixels, 1 to 16384.
        shading: how it is drawn.
        view: what is seen in frames that bring no view.
        maps: private maps; None takes one per compute unit, at most 16.
        shared: one map with atomics; None: where the device is no CPU.
        count: count how often each pixel is covered in place of keeping the nearest; no image then.
        local: work-items per group of the raster and fragment launches; None takes what suits the device.

    Raises:
        ValueError: a size out of range, or values that fit neither vertices nor triangles.
        Unsupported: not enough memory, or no 64-bit atomics where they are needed.

    Source: Burns & Hunt 2013, "The visibility buffer"; Pineda 1988 for the edge functions.
    """

    def __init__(
        self,
        device: Device,
        surface: DeviceSurface,
        width: int = 1280,
        height: int = 1024,
        shading: Shading | None = None,
        *,
        view: View | None = None,
        maps: int | None = None,
        shared: bool | None = None,
        count: bool = False,
        local: int | None = None,
    ) -> None:
        for name, size in (("width", width), ("height", height)):
            check(name, size, Side)
        self.device, self.width, self.height = device, width, height
        self.shading = shading or Shading()
        self._view, self._count = view, count
        self._across = -(-width // TILE)
        self._tiles = self._across * -(-height // TILE)
        self._shared = not device.is_cpu if shared is None else shared
        if self._shared and ATOMICS not in device.facts.extensions:
            raise Unsupported(f"needs {ATOMICS} for a map that all items share, device has none")
        room = device.memory_limit // (4 * 8 * TILE * TILE * self._tiles)  # 8 bytes per key
        self._maps = maps or max(min(device.facts.compute_units, MAPS, room), 1)
        if self._shared:
            self._maps = 1
        self._local = chunk_local(device) if local is None else local
        self._allocate(surface)
        self._launch_all(surface)

    def _allocate(self, surface: DeviceSurface) -> None:
        device, shading = self.device, self.shading
        ramp = np.linspace(0, 1, 256, dtype=np.float32)[:, None].repeat(4, 1)
        if shading.colour_map is not None:
            ramp[:, :3] = np.asarray(shading.colour_map, np.float32)[:, :3]
        values = np.zeros(1, np.float32) if shading.values is None else np.ravel(shading.values)
        self._all = device.upload("live", np.full(2, 0xFFFFFFFF, np.uint32))  # kernels cut to size
        self._buffers = {
            "screen": self._screen(surface),
            "flags": device.allocate("flags", FLAGS_OPEN + self._maps * self._tiles, np.uint32),
            "keys": device.allocate("keys", (self._maps, self._tiles, TILE * TILE), np.int64),
            "large": device.allocate("large", (LARGE_CAPACITY, 16), np.int32),
            "image": device.allocate("image", (self.height, self._across * TILE), np.uint32),
            "colour_map": device.upload("colour_map", ramp),
            "values": device.upload("values", values, np.float32, (None,)),
        }

    def _screen(self, surface: DeviceSurface) -> Buffer:
        rows = -(-max(surface.vertex_count, 1) // 8) * 8
        return self.device.allocate("screen", (rows, 4), np.int32)

    def _values_per(self, surface: DeviceSurface) -> int:
        """Triangles that share one value: 1, or those of an instance."""
        shading = self.shading
        if shading.values is None:
            return 1
        have = len(shading.values)
        wanted = surface.vertex_count if shading.values_of == "vertices" else surface.triangle_count
        if shading.values_of == "triangles" and have == surface.instances > 1:
            return surface.triangle_count // surface.instances
        if have != wanted:
            raise ValueError(f"values: expected {wanted} of {shading.values_of}, got {have}")
        return 1

    def _of_surface(self, surface: DeviceSurface) -> dict[str, Any]:
        """The arguments that another surface changes."""
        smooth = self.shading.smooth and surface.normals is not None
        return {
            "positions": surface.positions,
            "normals": surface.normals if smooth else surface.positions,
            "triangles": surface.triangles,
            "live": self._all if surface.counts is None else surface.counts,
            "instance_vertices": surface.instance_vertices,
            "triangles_per_value": self._values_per(surface),
            "pattern_count": max(surface.triangle_count // surface.instances, 1),
            "vertex_count": surface.vertex_count,
            "triangle_count": surface.triangle_count,
        }

    def _arguments(self, surface: DeviceSurface) -> dict[str, Any]:
        """Every kernel's arguments by name; those that depend on the view are set by the first call."""
        shading = self.shading
        none = (0.0, 0.0, 1.0, 0.0)
        return {
            **self._buffers,
            **self._of_surface(surface),
            "to_screen": np.zeros(16, np.float32),
            "key_light": none,
            "fill_light": none,
            "sky_light": none,
            "highlight": none,
            "surface_colour": (*shading.surface, 1.0),
            "background_top": (*shading.background[0], 1.0),
            "background_bottom": (*shading.background[1], 1.0),
            "line_width": shading.line_width,
            "cull": int(shading.cull),
            "width": self.width,
            "height": self.height,
            "large_pixels": max(LARGE_PIXELS, self.width * self.height // 256),
            "large_capacity": LARGE_CAPACITY,
            "tiles_open": int(self._shared),
            "flag_count": FLAGS_OPEN + self._maps * self._tiles,
            "map_count": self._maps,
            "tile_count": self._tiles,
            "item_count": GPU_ITEMS if self._shared else self._maps,
            "rows_per_item": TILE if self.device.is_cpu else 1,
        }

    def _launch_all(self, surface: DeviceSurface) -> None:
        """Build, bind and run once on no triangles, so that every kernel is compiled before the first frame."""
        device, shading = self.device, self.shading
        arguments = self._arguments(surface)
        modes = (("SHARED", self._shared), ("COUNT", self._count))
        colour = 1 if shading.by_triangle else 0
        if shading.values is not None:
            colour = 4 if shading.values.ndim == 2 else 2 + (shading.values_of == "vertices")
        defines = {
            "SMOOTH": int(shading.smooth and surface.normals is not None),
            "COLOUR": colour,
            "WIRE": int(shading.wireframe),
            "INSTANCED": int(surface.instances > 1),
        }
        # one program with the vertex stage: most of a build's time goes to the driver's own headers
        files = "stages/vertex.cl", "stages/raster.cl"
        raster = device.build(*files, defines={name: 1 for name, on in modes if on})
        arguments["live"] = device.upload("live", np.zeros(2, np.uint32))

        def launch(program: Program, kernel: str, items: int, stage: str, local: Any) -> Launch:
            wanted = {p.name: arguments[p.name] for p in program.kernels[kernel]}
            return program.launch(kernel, items, stage=stage, local=local, **wanted)

        items = max(-(-surface.vertex_count // 8), 1)
        self._vertex = launch(raster, "stages_vertex_transform", items, VERTEX, None)
        self._triangles = launch(
            raster, "stages_raster_triangles", arguments["item_count"], RASTER, self._local
        )
        self._large = launch(raster, "stages_raster_large", self._tiles, RASTER, self._local)
        self._shade = launch(
            device.build("stages/fragment.cl", defines=defines),
            "stages_fragment_shade",
            self._tiles * TILE // arguments["rows_per_item"],
            FRAGMENT,
            self._local,
        )
        self._enqueue(Timeline())
        device.wait()
        self._seen: View | None = None
        self._surface, self._bound = surface, {}
        self._rebind(surface)

    def _enqueue(self, timeline: Timeline) -> None:
        self._vertex(timeline)
        if self._shared:
            empty = 0 if self._count else EMPTY_KEY
            self.device.fill(timeline, RASTER, self._buffers["keys"], empty)
        self._triangles(timeline)
        self._large(timeline)
        if not self._count:
            self._shade(timeline)

    def _rebind(self, surface: DeviceSurface) -> None:
        """Have the launches draw `surface`.

        Raises:
            ValueError: the kernels were built for another kind.
            Unsupported: no room for its vertices.
        """
        if _kind(surface) != _kind(self._surface):
            raise ValueError(f"surface: expected {_kind(self._surface)}, got {_kind(surface)}")
        wanted = self._of_surface(surface)
        changed = {name: value for name, value in wanted.items() if self._bound.get(name) != value}
        self._vertex.items = max(-(-surface.vertex_count // 8), 1)
        if surface.vertex_count > self._buffers["screen"].shape[0]:
            self._buffers["screen"] = changed["screen"] = self._screen(surface)
        for launch in (self._vertex, self._triangles, self._large, self._shade):
            launch.set(**{name: changed[name] for name in launch.parameters & changed.keys()})
        self._surface, self._bound = surface, wanted

    def __call__(self, surface: DeviceSurface, frame: Frame, timeline: Timeline) -> None:
        """Enqueue the stages that draw `surface` as `frame.view` sees it; never waits.

        Raises:
            ValueError: no view, a view of another size, or a surface that the raster was not made for.
        """
        view = frame.view or self._view
        if view is None:
            raise ValueError("frame: expected a view, got none")
        if (view.width, view.height) != (self.width, self.height):
            raise ValueError(
                f"view: expected {self.width} x {self.height} pixels, "
                f"got {view.width} x {view.height}"
            )
        if surface is not self._surface:
            self._rebind(surface)
        if view is not self._seen:
            matrix = to_screen(view)
            self._vertex.set(to_screen=matrix)
            self._triangles.set(to_screen=matrix)
            self._shade.set(to_screen=matrix, **lights(view))
            self._seen = view
        self._enqueue(timeline)

    def image(self) -> NDArray[np.uint8]:
        """The last frame, (height, width, 3) uint8, row 0 on top."""
        rows = self.device.read(self._buffers["image"]).view(np.uint8)
        return np.ascontiguousarray(rows.reshape(self.height, -1, 4)[:, : self.width, :3])

    def keys(self) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
        """Depth 0..1 and triangle id of each pixel, (height, width) each; 1 and `EMPTY_ID` where nothing is."""
        keys = self._maps_merged(np.minimum, EMPTY_KEY).view(np.uint64)
        return (keys >> np.uint64(32)).astype(np.uint32).view(np.float32), keys.astype(np.uint32)

    def coverage(self) -> NDArray[np.int64]:
        """How often each pixel was covered, (height, width); only with `count`."""
        if not self._count:
            raise ValueError("count: expected a raster made with count=True, got one that draws")
        return self._maps_merged(np.add, 0)

    def _maps_merged(self, merge: np.ufunc, empty: int) -> NDArray[np.int64]:
        opened = self.device.read(self._buffers["flags"])[FLAGS_OPEN:].reshape(
            self._maps, self._tiles
        )
        maps = self.device.read(self._buffers["keys"])
        one = merge.reduce(np.where(opened[:, :, None] > 0, maps, np.int64(empty)), axis=0)
        tiles = one.reshape(-1, self._across, TILE, TILE).swapaxes(1, 2)
        return np.ascontiguousarray(
            tiles.reshape(-1, self._across * TILE)[: self.height, : self.width]
        )

    @property
    def scratch_bytes(self) -> int:
        """Device bytes that drawing needs beside the surface."""
        return sum(buffer.size_bytes for buffer in self._buffers.values())


def _kind(surface: DeviceSurface) -> str:
    """What the kernels were built for."""
    instances = "instances" if surface.instances > 1 else "one mesh"
    return f"{instances} with {'normals' if surface.normals is not None else 'no normals'}"
