"""Draw a surface that is on the device: vertex transform, raster and fragment stages, image left on the device."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.device import Device, Unsupported
from lodbench.kernels.program import Buffer
from lodbench.kernels.stages.scan import chunk_local
from lodbench.kernels.stages.timeline import Timeline
from lodbench.kernels.system import DeviceSurface, Frame, View

TILE = 64  # pixels per side
EMPTY_ID = 0xFFFFFFFF  # what `ids` holds where nothing was drawn
LARGEST_SIDE = 16384  # pixels; sub-pixel coordinates of the guard band end there
FLAGS_OPEN = 16  # words of counters before the flags of the tiles, as in screen.cl
EMPTY_KEY = (0x3F800000 << 32) | EMPTY_ID  # depth 1 and no triangle, as in screen.cl
LARGE_PIXELS = 4096  # of a triangle's box: above, and above 1/256 of the image, tiles share it
LARGE_CAPACITY = 1 << 15  # triangles that are shared out by tiles; one too many is drawn where it is found
MAPS = 8  # private maps at most: each costs 8 bytes per pixel that it touches
GPU_ITEMS = 1 << 14

VERTEX, RASTER, FRAGMENT = "vertex_transform", "raster", "fragment"

Colour = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Look:
    """How a surface is drawn.

    Attributes:
        smooth: light by interpolated normals; else, or where the surface has none, by facets.
        wireframe: draw the edges over the surface.
        line_width: of the edges, pixels.
        by_triangle: a scattered colour per triangle id.
        values: float32, one per vertex or one per triangle (or per instance), 0..1 over the colour map; or None.
        values_of: "vertices" or "triangles": what `values` counts.
        colour_map: (256, 3) float32, linear red, green, blue 0..1.
        cull: leave out triangles that face away.
        surface: the surface's colour, linear.
        background: colours of the first and the last row, linear.
    """

    smooth: bool = True
    wireframe: bool = False
    line_width: float = 1.0
    by_triangle: bool = False
    values: NDArray[np.float32] | None = None
    values_of: str = "vertices"
    colour_map: NDArray[np.float32] | None = None
    cull: bool = False
    surface: Colour = (0.60, 0.57, 0.53)
    background: tuple[Colour, Colour] = ((0.88, 0.89, 0.91), (0.52, 0.54, 0.57))


class Raster:
    """Draws a `DeviceSurface` into an image on the device; passed as `raster` to `run`.

    Each compute unit draws into a map of its own, one 64-bit key (depth above triangle id) per pixel, and the smallest
    key wins: no order, no schedule and no number of maps can change a bit, and equal depths go to the lower id. GPUs
    share one map through 64-bit atomics. Triangles too large for one item are shared out by tiles of 64 x 64 pixels.
    Everything is allocated and every kernel compiled here; a call only enqueues.

    Args:
        device: where the surface is.
        surface: of any topology; later calls may pass others of the same capacity.
        width: pixels, 1 to 16384.
        height: pixels, 1 to 16384.
        look: how it is drawn.
        view: what is seen in frames that bring no view.
        maps: private maps; None takes one per compute unit, at most 8.
        shared: one map with atomics; None: where the device is no CPU.
        count: count how often each pixel is covered in place of keeping the nearest; no image then.

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
        look: Look = Look(),
        *,
        view: View | None = None,
        maps: int | None = None,
        shared: bool | None = None,
        count: bool = False,
    ) -> None:
        for name, size in (("width", width), ("height", height)):
            if not 1 <= size <= LARGEST_SIDE:
                raise ValueError(f"{name}: expected 1 to {LARGEST_SIDE} pixels, got {size}")
        self.device, self.width, self.height, self.look = device, width, height, look
        self._view = view
        self._shared = not device.is_cpu if shared is None else shared
        if self._shared and "cl_khr_int64_extended_atomics" not in device.facts.extensions:
            raise Unsupported(
                "needs cl_khr_int64_extended_atomics for a shared map, device has none"
            )
        self._count = count
        self._maps = 1 if self._shared else maps or min(device.facts.compute_units, MAPS)
        self._across = -(-width // TILE)
        self._tiles = self._across * -(-height // TILE)
        self._across = -(-width // TILE)
        self._tiles = self._across * -(-height // TILE)
        self._capacity = (surface.vertex_count, surface.triangle_count)
        self._allocate(surface)
        self._bind_launches(surface)

    def _allocate(self, surface: DeviceSurface) -> None:
        device, look = self.device, self.look
        rows = -(-max(surface.vertex_count, 1) // 8) * 8
        self._screen = device.allocate("screen", (rows, 4), np.int32)
        self._flags = device.allocate("flags", FLAGS_OPEN + self._maps * self._tiles, np.uint32)
        self._keys = device.allocate("keys", (self._maps, self._tiles, TILE * TILE), np.int64)
        self._large = device.allocate("large", (LARGE_CAPACITY, 16), np.int32)
        self._image = device.allocate("image", (self.height, self._across * TILE), np.uint32)
        ramp = np.linspace(0, 1, 256, dtype=np.float32)[:, None].repeat(4, 1)
        if look.colour_map is not None:
            ramp[:, :3] = np.asarray(look.colour_map, np.float32)[:, :3]
        self._colour_map = device.upload("colour_map", ramp)
        values = np.zeros(1, np.float32) if look.values is None else look.values
        self._values = device.upload("values", values, np.float32, (None,))
        totals = np.array([surface.vertex_count, surface.triangle_count], np.uint32)
        self._totals = device.upload("live", totals)

    def _values_per(self, surface: DeviceSurface) -> int:
        """Triangles that share one value: 1, or those of an instance."""
        look = self.look
        if look.values is None:
            return 1
        have = len(look.values)
        wanted = surface.vertex_count if look.values_of == "vertices" else surface.triangle_count
        shared = look.values_of == "triangles" and have == surface.instances
        if have != wanted and not shared:
            raise ValueError(f"values: expected {wanted} of {look.values_of}, got {have}")
        return surface.triangle_count // surface.instances if have != wanted else 1

    def _bind_launches(self, surface: DeviceSurface) -> None:
        """Build, bind and run once on nothing, so that every kernel is compiled before the first frame."""
        device, look = self.device, self.look
        smooth = look.smooth and surface.normals is not None
        colour = 1 if look.by_triangle else 0
        if look.values is not None:
            colour = 3 if look.values_of == "vertices" else 2
        build = device.build
        vertex = build("stages/vertex.cl")
        raster = build(
            "stages/raster.cl",
            defines={name: 1 for name, on in (("SHARED", self._shared), ("COUNT", self._count)) if on},
        )
        fragment = build(
            "stages/fragment.cl",
            defines={
                "SMOOTH": int(smooth),
                "COLOUR": colour,
                "WIRE": int(look.wireframe),
                "INSTANCED": int(surface.instances > 1),
            },
        )
        local = chunk_local(device)
        nothing = device.upload("live", np.zeros(2, np.uint32))
        items = GPU_ITEMS if self._shared else self._maps
        size = dict(width=self.width, height=self.height)
        to_screen = np.zeros(16, np.float32)
        large_pixels = max(LARGE_PIXELS, self.width * self.height // 256)
        self._vertex = vertex.launch(
            "stages_vertex_transform",
            max(-(-surface.vertex_count // 8), 1),
            stage=VERTEX,
            positions=surface.positions,
            live=nothing,
            screen=self._screen,
            flags=self._flags,
            to_screen=to_screen,
            tiles_open=int(self._shared),
            flag_count=self._flags.shape[0],
            vertex_count=surface.vertex_count,
        )
        self._triangles = raster.launch(
            "stages_raster_triangles",
            items,
            stage=RASTER,
            local=local,
            screen=self._screen,
            triangles=surface.triangles,
            positions=surface.positions,
            live=nothing,
            keys=self._keys,
            flags=self._flags,
            large=self._large,
            to_screen=to_screen,
            instance_vertices=surface.instance_vertices,
            cull=int(look.cull),
            **size,
            large_pixels=large_pixels,
            large_capacity=LARGE_CAPACITY,
            pattern_count=max(surface.triangle_count // surface.instances, 1),
            triangle_count=surface.triangle_count,
            map_count=self._maps,
            item_count=items,
        )
        self._large_ones = raster.launch(
            "stages_raster_large",
            self._tiles,
            stage=RASTER,
            local=local,
            large=self._large,
            keys=self._keys,
            flags=self._flags,
            **size,
            cull=int(look.cull),
            large_capacity=LARGE_CAPACITY,
            tile_count=self._tiles,
        )
        top, bottom = look.background
        self._shade = fragment.launch(
            "stages_fragment_shade",
            self._tiles * TILE,
            stage=FRAGMENT,
            keys=self._keys,
            flags=self._flags,
            triangles=surface.triangles,
            positions=surface.positions,
            normals=surface.normals if smooth else surface.positions,
            values=self._values,
            colour_map=self._colour_map,
            image=self._image,
            to_screen=to_screen,
            key_light=(0, 0, 1, 1),
            fill_light=(0, 0, 1, 1),
            sky_light=(0, 0, 1, 1),
            highlight=(0, 0, 1, 1),
            surface_colour=(*look.surface, 1),
            background_top=(*top, 1),
            background_bottom=(*bottom, 1),
            line_width=look.line_width,
            instance_vertices=surface.instance_vertices,
            triangles_per_value=self._values_per(surface),
            **size,
            pattern_count=max(surface.triangle_count // surface.instances, 1),
            vertex_count=surface.vertex_count,
            map_count=self._maps,
            tile_count=self._tiles,
        )
        self._enqueue(Timeline())
        device.wait()
        live = surface.counts or self._totals
        self._vertex.set(live=live)
        self._triangles.set(live=live)
        self._surface = surface
        self._seen: View | None = None

    def _enqueue(self, timeline: Timeline) -> None:
        self._vertex(timeline)
        if self._shared:
            self.device.fill(timeline, RASTER, self._keys, 0 if self._count else EMPTY_KEY)
        self._triangles(timeline)
        self._large_ones(timeline)
        if not self._count:
            self._shade(timeline)

    def _rebind(self, surface: DeviceSurface) -> None:
        """Point the launches at another surface of the same capacity and topology."""
        kept, have = self._surface, (surface.vertex_count, surface.triangle_count)
        if (
            have != self._capacity
            or surface.instances != kept.instances
            or (surface.normals is None) != (kept.normals is None)
        ):
            raise ValueError(f"surface: expected the capacity {self._capacity}, got {have}")
        live = surface.counts or self._totals
        self._vertex.set(positions=surface.positions, live=live)
        self._triangles.set(
            positions=surface.positions, triangles=surface.triangles, live=live
        )
        self._shade.set(positions=surface.positions, triangles=surface.triangles)
        if self.look.smooth and surface.normals is not None:
            self._shade.set(normals=surface.normals)
        self._surface = surface

    def __call__(self, surface: DeviceSurface, frame: Frame, timeline: Timeline) -> None:
        """Enqueue the stages that draw `surface` as `frame.view` sees it; never waits.

        Raises:
            ValueError: no view, a view of another size, or a surface of another capacity.
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
        rows = self.device.read(self._image).view(np.uint8)
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
        opened = self.device.read(self._flags)[FLAGS_OPEN:].reshape(self._maps, self._tiles)
        maps = self.device.read(self._keys)
        one = merge.reduce(np.where(opened[:, :, None] > 0, maps, np.int64(empty)), axis=0)
        tiles = one.reshape(-1, self._across, TILE, TILE).swapaxes(1, 2)
        return np.ascontiguousarray(
            tiles.reshape(-1, self._across * TILE)[: self.height, : self.width]
        )

    @property
    def scratch_bytes(self) -> int:
        """Device bytes that drawing needs beside the surface."""
        buffers = (self._screen, self._flags, self._keys, self._large, self._image)
        return sum(buffer.size_bytes for buffer in buffers)


def to_screen(view: View) -> NDArray[np.float32]:
    """World to fixed-point screen, (16,) float32: rows of x, y (sub-pixels, y down), depth 0..1 and w, times w."""
    m = view.world_to_clip
    rows = np.stack(
        [
            128.0 * view.width * (m[0] + m[3]),
            128.0 * view.height * (m[3] - m[1]),
            0.5 * (m[2] + m[3]),
            m[3],
        ]
    )
    return rows.astype(np.float32).ravel()


def lights(view: View) -> dict[str, tuple[float, float, float, float]]:
    """The lights of a view, fixed to the camera: key from the upper left, fill from the right, sky from above."""
    right = view.world_to_clip[0, :3] / np.linalg.norm(view.world_to_clip[0, :3])
    up = view.world_to_clip[1, :3] / np.linalg.norm(view.world_to_clip[1, :3])
    back = np.cross(right, up)

    def aim(x: float, y: float, z: float, strength: float) -> tuple[float, float, float, float]:
        direction = right * x + up * y + back * z
        direction = direction / np.linalg.norm(direction)
        return (*map(float, direction), strength)

    key = aim(-0.45, 0.55, 0.70, 0.0)
    half = np.array(key[:3]) + back
    return {
        "key_light": (*key[:3], 0.95),
        "fill_light": aim(0.80, 0.10, 0.55, 0.22),
        "sky_light": aim(0.0, 1.0, 0.15, 0.30),
        "highlight": (*map(float, half / np.linalg.norm(half)), 0.10),
    }
