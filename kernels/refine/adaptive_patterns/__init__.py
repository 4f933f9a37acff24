"""Adaptive mesh refinement: a pattern for each coarse triangle out of a pool, by the depths of its three edges.

Each coarse vertex has a depth tag: by the eye's distance, by length on the screen, by curvature, mixed, or given. An
edge's depth is the mean of its ends' tags, the same from both sides, so that neighbours meet without cracks whatever
their patterns. Tags, selection, scan and refinement run on the device; the surface is flat, of PN or of ST triangles,
and displaced as the uniform patterns' is. With geomorphing, the vertices of a level come out of their edges.

What tags are made of, which triangles a pattern has and how levels blend is not told: these are reconstructions.

Source: Boubekeur & Schlick 2007, Generic Adaptive Mesh Refinement, GPU Gems 3, chapter 5; the same authors' A Flexible
Kernel for Adaptive Mesh Refinement on GPU, Computer Graphics Forum 27(1), 2008.
"""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.refine.adaptive_patterns.host import AdaptivePatterns
from lodbench.kernels.refine.adaptive_patterns.params import Params
from lodbench.kernels.refine.adaptive_patterns.refine import refine
from lodbench.kernels.system import System

__all__ = ["AdaptivePatterns", "Params", "SYSTEM", "refine"]

SYSTEM = System(
    name="adaptive_patterns",
    family="refine",
    source="Boubekeur & Schlick 2007, GPU Gems 3, chapter 5; Computer Graphics Forum 27(1), 2008",
    takes=(TriangleMesh,),
    prepare=AdaptivePatterns,
    cases={
        "curvature_32": Params(32),
        "distance_32": Params(32, by="distance"),
        "screen_32": Params(32, by="screen"),
        "mixed_32": Params(32, by="mixed"),
        "flat_32": Params(32, surface="flat", by="distance", indices=False),
        "morphing_32": Params(32, by="screen", geomorphing=True),
        "perlin_32": Params(32, by="distance", displacement="perlin", amplitude=0.02),
        "tagged_32": Params(32, surface="st_triangles", sharpness=0.5, tension=0.25),
    },
    verbs={"refine": refine},
)
