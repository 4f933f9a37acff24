"""The launches that draw one surface of a frame into an image that all its surfaces share."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from lodbench.kernels.opencl import Buffer, Device, Launch, Program, Timeline
from lodbench.kernels.stages.shading import Shading
from lodbench.kernels.system import DeviceSurface

VERTEX, RASTER, FRAGMENT = "vertex_transform", "raster", "fragment"
COUNTERS = 16  # words before the flags of the tiles, as FLAGS_OPEN in screen.cl


def kind(surface: DeviceSurface) -> str:
    """What kernels are built for."""
    instances = "instances" if surface.instances > 1 else "one mesh"
    return f"{instances} with {'normals' if surface.normals is not None else 'no normals'}"


class Drawing:
    """One surface's place in a frame: its vertices on the screen, and its launches.

    Args:
        device: where the surface is.
        surface: the first one that is drawn here; later ones are of its `kind`.
        shading: how it is drawn.
        shared: the arguments that every surface of the frame has in common, by name: image, keys, size ...
        modes: SHARED and COUNT as in canvas.cl, 0 or 1.
        local: work-items per group of the raster and fragment launches.
        first: the frame's first surface clears what the last frame left.
    """

    def __init__(
        self,
        device: Device,
        surface: DeviceSurface,
        shading: Shading,
        shared: Mapping[str, Any],
        modes: Mapping[str, int],
        local: int | None,
        *,
        first: bool,
    ) -> None:
        self._device, self._shading, self._local = device, shading, local
        self._first = first
        self._all = device.upload("live", np.full(2, 0xFFFFFFFF, np.uint32))  # kernels cut to size
        self._screen = self._screen_of(surface)
        self._arguments = {
            **shared,
            "screen": self._screen,
            "flag_count": shared["flag_count"] if first else COUNTERS,
            "behind": int(not first),
        }
        self._defines = {
            "SMOOTH": int(shading.smooth and surface.normals is not None),
            "COLOUR": shading.colour_kind,
            "WIRE": int(shading.wireframe),
            "INSTANCED": int(surface.instances > 1),
        }
        self._arguments |= self._of_surface(surface, 0)
        # one program with the vertex stage: most of a build's time goes to the driver's own headers
        files = "stages/vertex.cl", "stages/raster.cl"
        raster = device.build(*files, defines={name: 1 for name, on in modes.items() if on})
        self._vertex = self._launch(
            raster, "stages_vertex_transform", self._eights(surface), VERTEX, None
        )
        self._triangles = self._launch(
            raster, "stages_raster_triangles", shared["item_count"], RASTER, local
        )
        self._large = self._launch(
            raster, "stages_raster_large", shared["tile_count"], RASTER, local
        )
        self._shades: dict[bool, Launch] = {}
        self._bound: dict[str, Any] = {}
        self._surface = surface

    @staticmethod
    def _eights(surface: DeviceSurface) -> int:
        return max(-(-surface.vertex_count // 8), 1)

    def _screen_of(self, surface: DeviceSurface) -> Buffer:
        return self._device.allocate("screen", (8 * self._eights(surface), 4), np.int32)

    def _values_per(self, surface: DeviceSurface) -> int:
        """Triangles that share one value: 1, or those of an instance."""
        shading = self._shading
        if shading.values is None:
            return 1
        have = len(shading.values)
        wanted = surface.vertex_count if shading.values_of == "vertices" else surface.triangle_count
        if shading.values_of == "triangles" and have == surface.instances > 1:
            return surface.triangle_count // surface.instances
        if have != wanted:
            raise ValueError(f"values: expected {wanted} of {shading.values_of}, got {have}")
        return 1

    def _of_surface(self, surface: DeviceSurface, first_id: int) -> dict[str, Any]:
        """The arguments that another surface changes."""
        smooth = self._defines["SMOOTH"]
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
            "id_count": surface.triangle_count,
            "first_id": first_id,
        }

    def _launch(self, program: Program, kernel: str, items: int, stage: str, local: Any) -> Launch:
        wanted = {p.name: self._arguments[p.name] for p in program.kernels[kernel]}
        return program.launch(kernel, items, stage=stage, local=local, **wanted)

    def _shade(self, several: bool) -> Launch:
        """The fragment launch; one that leaves other surfaces' pixels alone where there are several."""
        if several not in self._shades:
            program = self._device.build(
                "stages/fragment.cl", defines={**self._defines, "SEVERAL": int(several)}
            )
            items = self._arguments["tile_count"] * 64 // self._arguments["rows_per_item"]
            self._shades[several] = self._launch(
                program, "stages_fragment_shade", items, FRAGMENT, self._local
            )
        return self._shades[several]

    def warm(self, several: bool) -> None:
        """Run once on no triangles and no tiles, so that every kernel is compiled before the first frame.

        A map that all items share must hold no keys.
        """
        none = self._device.upload("live", np.zeros(2, np.uint32))
        launches = [self._vertex, self._triangles, self._large, self._shade(several)]
        every = self._arguments["tile_count"] * self._arguments["map_count"] + COUNTERS
        for launch in launches:
            self._set(launch, {"live": none, "flag_count": every})
        for launch in launches:
            launch(Timeline())
        self._device.wait()
        for launch in launches:
            self._set(launch, self._arguments)

    def bind(self, surface: DeviceSurface, first_id: int) -> None:
        """Have the launches draw `surface`, whose first triangle has this id.

        Raises:
            ValueError: the kernels were built for another kind.
            Unsupported: no room for its vertices.
        """
        if surface is self._surface and self._bound.get("first_id") == first_id:
            return
        if kind(surface) != kind(self._surface):
            raise ValueError(f"surface: expected {kind(self._surface)}, got {kind(surface)}")
        wanted = self._of_surface(surface, first_id)
        changed = {name: value for name, value in wanted.items() if self._bound.get(name) != value}
        self._vertex.items = self._eights(surface)
        if surface.vertex_count > self._screen.shape[0]:
            self._screen = changed["screen"] = self._screen_of(surface)
        self.change(changed)
        self._surface, self._bound = surface, wanted

    def change(self, arguments: Mapping[str, Any]) -> None:
        """Set arguments by name, such as those of the camera, wherever a launch has them."""
        self._arguments |= arguments
        for launch in (self._vertex, self._triangles, self._large, *self._shades.values()):
            self._set(launch, arguments)

    @staticmethod
    def _set(launch: Launch, arguments: Mapping[str, Any]) -> None:
        launch.set(**{name: arguments[name] for name in launch.parameters & arguments.keys()})

    def transform(self, timeline: Timeline) -> None:
        """Enqueue the vertex stage."""
        self._vertex(timeline)

    def cover(self, timeline: Timeline) -> None:
        """Enqueue the raster stage."""
        self._triangles(timeline)
        self._large(timeline)

    def shade(self, timeline: Timeline, several: bool) -> None:
        """Enqueue the fragment stage, once all surfaces of the frame are covered."""
        self._shade(several)(timeline)

    @property
    def scratch_bytes(self) -> int:
        """Device bytes of the vertices on the screen."""
        return self._screen.size_bytes
