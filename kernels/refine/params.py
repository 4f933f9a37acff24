"""The parameters that refinement by patterns has."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np

from lodbench.kernels.parameters import Parameters, Range
from lodbench.kernels.refine.function_text import check_function
from lodbench.kernels.refine.lattice import Amplitude, Segments, Waves


@dataclass(frozen=True)
class RefineParams(Parameters):
    """How finely to refine, and what raises the surface.

    Attributes:
        segments: parts that each coarse edge is cut into, 1 to 4096.
        displacement: what raises the surface along its normals: "sine", a sin(f |P|); "perlin", octaves of noise;
            "turbulence", their absolute values; "height_map", a picture; or "function", one of your own.
        amplitude: its height, as a fraction of the bounding-box diagonal; 0 for none, and of a function, which says
            how high it rises itself.
        waves: of the sine, or cells of the coarsest noise, per bounding-box diagonal; one passes per second of
            `Frame.time`.
        octaves: of the noise, each twice as fine and half as high as the one before.
        function: OpenCL C that has float displace(float3 position, float3 normal, float2 uv, float time), the height
            in model units over a point of the surface; uv is (0, 0) on a mesh without texture coordinates, time is
            that of `Frame`, s.
        height_map: a picture over the mesh's texture coordinates, repeated beyond 0 to 1: PNG of 8 or 16 bits or .npy,
            its first row at v = 1; in the API also the array itself, (h, w) of 0 to 1, uint8 or uint16.
        map_filter: of the height map: "bilinear" between the middles of its pixels, or the "nearest" pixel.
        map_bias: value of the height map that stays where it is, 0 to 1.
    """

    segments: Segments = 16
    displacement: Literal["sine", "perlin", "turbulence", "height_map", "function"] = "sine"
    amplitude: Amplitude = 0.0
    waves: Waves = 8.0
    octaves: Annotated[int, Range(1, 12)] = 4
    function: str = ""
    height_map: str | os.PathLike[Any] | np.ndarray = ""
    map_filter: Literal["bilinear", "nearest"] = "bilinear"
    map_bias: Annotated[float, Range(0, 1)] = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        has_map = not isinstance(self.height_map, str) or bool(self.height_map)
        for kind, given in (("function", bool(self.function)), ("height_map", has_map)):
            if given and self.displacement != kind:
                raise ValueError(
                    f"displacement: expected {kind!r} where there is one, got {self.displacement!r}"
                )
        if self.displacement == "height_map" and not has_map:
            raise ValueError("height_map: expected a picture's path or an array, got none")
        if self.displacement == "function":
            check_function(self.function)
            if self.amplitude:
                raise ValueError(
                    f"amplitude: expected 0 for a function, which gives model units, got {self.amplitude:g}"
                )


@dataclass(frozen=True)
class LevelParams(RefineParams):
    """How to refine every triangle alike, by one pattern or by one of several.

    Attributes:
        levels: nested patterns held ready, the coarser with half the segments of the finer; `segments` must allow
            for it. `Frame.view` chooses: each doubling of the eye's distance past `near` halves the segments.
        near: distance of the eye from the box, in diagonals, up to which the finest level is shown.
    """

    levels: Annotated[int, Range(1, 13)] = 1
    near: Annotated[float, Range(0, open="low")] = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.segments % (1 << (self.levels - 1)):
            raise ValueError(
                f"levels: expected halvings of {self.segments} segments, got {self.levels}"
            )


@dataclass(frozen=True)
class NormalOptions(Parameters):
    """Which normals curved PN triangles are shaded by.

    Attributes:
        shading_normals: "quadratic", which can show an inflection, or "linear", interpolated along the triangle.
    """

    shading_normals: Literal["quadratic", "linear"] = "quadratic"


@dataclass(frozen=True)
class TagOptions(Parameters):
    """The tags of a mesh that brings none of its own.

    A mesh's own `tags`, (n, 3) tension, sharpness and bias of each vertex, come before these; its `edge_tags`,
    (m, 3, 2) sharpness and bias of each triangle's edges, before either.

    Attributes:
        tension: of every vertex: 0 bulges as a PN triangle, 1 is straight, below 0 bulges more.
        sharpness: of every vertex; an edge creases by the product of its ends'.
        bias: of every vertex: to which side a crease leans; an edge has the mean of its ends'.
    """

    tension: Annotated[float, Range(-1, 1)] = 0.0
    sharpness: Annotated[float, Range(0, 1)] = 0.0
    bias: Annotated[float, Range(-1, 1)] = 0.0


@dataclass(frozen=True)
class SurfaceOptions(TagOptions, NormalOptions):
    """Which surface is refined, with the options of each.

    Attributes:
        surface: "flat", the triangles themselves; "pn_triangles" or "st_triangles", as those systems have them.
    """

    surface: Literal["flat", "pn_triangles", "st_triangles"] = "flat"
