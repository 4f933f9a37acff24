"""Generic mesh refinement: one stored pattern of barycentric vertices, evaluated over every coarse triangle.

What stays in memory is the pattern and the coarse triangles' attributes, whatever the depth of refinement.
Flat interpolation, or a displacement along the normal by a sine, noise, a height map or a function of one's own,
whose normal is corrected by the chain rule (reconstruction: the paper does not say how). Level of detail: nested
patterns, one chosen per object by distance.

Source: Boubekeur & Schlick, Generic Mesh Refinement on GPU, Graphics Hardware 2005, sections 3.2, 3.3, 4 and 5.
"""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.refine.pattern.host import Pattern
from lodbench.kernels.refine.pattern.params import Params
from lodbench.kernels.refine.refining import refiner
from lodbench.kernels.system import System

__all__ = ["Params", "Pattern", "SYSTEM", "refine"]

DIMPLES = """float displace(float3 position, float3 normal, float2 uv, float time)
{
    return 0.01f * cos(9.0f * position.x + time) * cos(9.0f * position.y) * normal.z;
}
"""

refine = refiner(Pattern, Params)

SYSTEM = System(
    name="pattern",
    family="refine",
    source="Boubekeur & Schlick 2005, sections 3.2, 3.3, 4 and 5",
    takes=(TriangleMesh,),
    prepare=Pattern,
    cases={
        "flat_16": Params(16),
        "flat_64": Params(64),
        "flat_128": Params(128),
        "sine_64": Params(64, amplitude=0.02),
        "perlin_64": Params(64, displacement="perlin", amplitude=0.02),
        "turbulence_64": Params(64, displacement="turbulence", amplitude=0.02),
        "function_64": Params(64, displacement="function", function=DIMPLES),
        "per_triangle_64": Params(64, draw="per_triangle"),
        "per_triangle_128": Params(128, draw="per_triangle"),
        "levels_64": Params(64, levels=7),
    },
    verbs={"refine": refine},
)
