"""How a surface is drawn: colours, lines, lights."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.system import View

Colour = tuple[float, float, float]
Light = tuple[float, float, float, float]  # direction and strength


@dataclass(frozen=True, eq=False)
class Shading:
    """How a surface is drawn.

    Attributes:
        smooth: light by interpolated normals; else, or where the surface has none, by facets.
        wireframe: draw the edges over the surface.
        line_width: of the edges, pixels.
        by_triangle: a scattered colour per triangle id.
        values: float32, one per vertex or one per triangle (or per instance), 0..1 over the colour map; or per vertex
            (n, 3), linear red, green, blue; or None.
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
    surface: Colour = (0.56, 0.52, 0.47)
    background: tuple[Colour, Colour] = ((0.93, 0.94, 0.95), (0.66, 0.68, 0.71))

    @property
    def colour_kind(self) -> int:
        """COLOUR of stages/fragment.cl."""
        if self.values is None:
            return int(self.by_triangle)
        return 4 if self.values.ndim == 2 else 2 + (self.values_of == "vertices")


def lights(view: View) -> dict[str, Light]:
    """The lights of a view, fixed to the camera: key from the upper left, fill from the right, sky from above."""
    right = view.world_to_clip[0, :3] / np.linalg.norm(view.world_to_clip[0, :3])
    up = view.world_to_clip[1, :3] / np.linalg.norm(view.world_to_clip[1, :3])
    back = np.cross(right, up)

    def aim(direction: NDArray[np.float64], strength: float) -> Light:
        x, y, z = (float(d) for d in direction / np.linalg.norm(direction))
        return x, y, z, strength

    key = -0.60 * right + 0.62 * up + 0.50 * back
    return {
        "key_light": aim(key, 1.0),
        "fill_light": aim(0.80 * right + 0.10 * up + 0.55 * back, 0.20),
        "sky_light": aim(up + 0.15 * back, 0.16),
        "highlight": aim(key / np.linalg.norm(key) + back, 0.07),
    }
