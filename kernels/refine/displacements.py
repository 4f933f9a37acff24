"""The displacements by name."""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.refine.displacement import (
    Displacement,
    NoiseDisplacement,
    SineDisplacement,
)
from lodbench.kernels.refine.function import FunctionDisplacement
from lodbench.kernels.refine.height_map import MapDisplacement
from lodbench.kernels.refine.params import RefineParams

KINDS: dict[str, type[Displacement]] = {
    "sine": SineDisplacement,
    "perlin": NoiseDisplacement,
    "turbulence": NoiseDisplacement,
    "height_map": MapDisplacement,
    "function": FunctionDisplacement,
}


def displacement_of(params: RefineParams, mesh: TriangleMesh, diagonal: float) -> Displacement:
    """What the params ask for, over a canonical mesh."""
    still = not params.amplitude and params.displacement != "function"
    kind = Displacement if still else KINDS[params.displacement]
    return kind(params, mesh, diagonal)
