"""Draw surfaces that are on the device: vertex transform, raster and fragment stages, image left on the device."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.opencl import Device, Timeline, Unsupported
from lodbench.kernels.parameters import Range, check
from lodbench.kernels.stages.camera import to_screen
from lodbench.kernels.stages.drawing import COUNTERS, RASTER, Drawing
from lodbench.kernels.stages.scan import chunk_local
from lodbench.kernels.stages.shading import Shading, lights
from lodbench.kernels.system import DeviceSurface, Frame, View

TILE = 64  # pixels per side
EMPTY_ID = 0xFFFFFFFF  # what `ids` holds where nothing was drawn
Side: TypeAlias = Annotated[int, Range(1, 16384)]  # pixels; the guard band of sub-pixels ends there
EMPTY_KEY = (0x3F800000 << 32) | EMPTY_ID  # depth 1 and no triangle, as in screen.cl
LARGE_PIXELS = 4096  # of a triangle's box: above, and above 1/256 of the image, tiles share it
LARGE_CAPACITY = 1 << 15  # such triangles; one too many is drawn where it is found
MAPS = 16  # private maps at most, as in screen.cl: each costs 8 bytes per pixel that it touches
GPU_ITEMS = 1 << 14
KEY_BYTES = 8
ATOMICS = "cl_khr_int64_extended_atomics"


class Raster:
    """Draws the surfaces of a frame into one image on the device; passed as `raster` to `run`.

    Each compute unit draws into a map of its own, one 64-bit key (depth above triangle id) per pixel, and the smallest
    key wins: no order, no schedule and no number of maps can change a bit, and equal depths go to the lower id, which
    counts on from surface to surface. GPUs share one map through 64-bit atomics. Triangles too large for one item are
    shared out by tiles of 64 x 64 pixels. Everything is allocated and every kernel compiled here; a call only enqueues,
    unless its frame has more surfaces, or larger ones, than any before it.

    Args:
        device: where the surfaces are.
        surfaces: those of a frame, of any topology, sized by their capacity; later calls may pass others of the same
            kinds in the same places, instanced or not, with normals or without: how many is up to each frame.
        width: pixels, 1 to 16384.
        height: pixels, 1 to 16384.
        shading: how they are drawn; values colour a frame of one surface only.
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
        surfaces: Sequence[DeviceSurface],
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
        room = device.memory_limit // (4 * KEY_BYTES * TILE * TILE * self._tiles)
        self._maps = min(maps or max(min(device.facts.compute_units, room), 1), MAPS)
        if self._shared:
            self._maps = 1
        self._local = chunk_local(device) if local is None else local
        self._seen: View | None = None
        self._allocate()
        self._drawings: list[Drawing] = []
        self._bind(surfaces)

    def _allocate(self) -> None:
        device, shading = self.device, self.shading
        ramp = np.linspace(0, 1, 256, dtype=np.float32)[:, None].repeat(4, 1)
        if shading.colour_map is not None:
            ramp[:, :3] = np.asarray(shading.colour_map, np.float32)[:, :3]
        values = np.zeros(1, np.float32) if shading.values is None else np.ravel(shading.values)
        self._buffers = {
            "flags": device.allocate("flags", COUNTERS + self._maps * self._tiles, np.uint32),
            "keys": device.allocate("keys", (self._maps, self._tiles, TILE * TILE), np.int64),
            "large": device.allocate("large", (LARGE_CAPACITY, 16), np.int32),
            "image": device.allocate("image", (self.height, self._across * TILE), np.uint32),
            "colour_map": device.upload("colour_map", ramp),
            "values": device.upload("values", values, np.float32, (None,)),
        }
        none = (0.0, 0.0, 1.0, 0.0)
        self._arguments: dict[str, Any] = {
            **self._buffers,
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
            "flag_count": COUNTERS + self._maps * self._tiles,
            "map_count": self._maps,
            "tile_count": self._tiles,
            "item_count": GPU_ITEMS if self._shared else self._maps,
            "rows_per_item": TILE if device.is_cpu else 1,
        }

    def _bind(self, surfaces: Sequence[DeviceSurface]) -> Sequence[Drawing]:
        """The drawings of these surfaces, made where there were fewer so far.

        Raises:
            ValueError: no surface, another kind than before in its place, or more triangles than ids.
            Unsupported: no room.
        """
        if not surfaces:
            raise ValueError("surfaces: expected at least one, got none")
        if len(surfaces) > 1 and self.shading.values is not None:
            raise ValueError(f"values: expected one surface to colour, got {len(surfaces)}")
        if (total := sum(surface.triangle_count for surface in surfaces)) >= EMPTY_ID:
            raise ValueError(f"surfaces: expected fewer than 2**32 - 1 triangles, got {total:,}")
        modes = {"SHARED": int(self._shared), "COUNT": int(self._count)}
        for surface in surfaces[len(self._drawings) :]:
            first = not self._drawings
            self._drawings.append(
                Drawing(
                    self.device,
                    surface,
                    self.shading,
                    self._arguments,
                    modes,
                    self._local,
                    first=first,
                )
            )
            self._clear_shared(Timeline())
            self._drawings[-1].warm(len(surfaces) > 1)
        drawings = self._drawings[: len(surfaces)]
        first_id = 0
        for drawing, surface in zip(drawings, surfaces, strict=True):
            drawing.bind(surface, first_id)
            first_id += surface.triangle_count
        return drawings

    def _clear_shared(self, timeline: Timeline) -> None:
        """Enqueue the filling of a map that all items share; private ones are cleared tile by tile, when touched."""
        if self._shared:
            empty = 0 if self._count else EMPTY_KEY
            self.device.fill(timeline, RASTER, self._buffers["keys"], empty)

    def __call__(self, surfaces: Sequence[DeviceSurface], frame: Frame, timeline: Timeline) -> None:
        """Enqueue the stages that draw `surfaces` as `frame.view` sees them; never waits.

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
        drawings = self._bind(surfaces)
        if view is not self._seen:
            camera = {"to_screen": to_screen(view), **lights(view)}
            self._seen = view
            self._arguments |= camera  # of surfaces that come later
            for drawing in self._drawings:
                drawing.change(camera)
        for place, drawing in enumerate(drawings):
            drawing.transform(timeline)
            if not place:
                self._clear_shared(timeline)
            drawing.cover(timeline)
        if not self._count:
            for drawing in drawings:
                drawing.shade(timeline, len(drawings) > 1)

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
        opened = self.device.read(self._buffers["flags"])[COUNTERS:].reshape(
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
        """Device bytes that drawing needs beside the surfaces."""
        own = sum(buffer.size_bytes for buffer in self._buffers.values())
        return own + sum(drawing.scratch_bytes for drawing in self._drawings)
