"""Adaptive patterns over triangles that lie sorted by their pattern: does binning them pay?

The chapter draws the triangles of one pattern together, which saves a change of vertex buffer for each. Here one launch
takes any patterns in the mesh's own order; sorted, neighbours in the launch read the same part of the pool. Sorting is
done once, before the clock starts, which favours it: where tags follow a view it would be due in every frame.

Source: Boubekeur & Schlick 2007, GPU Gems 3, chapter 5.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.opencl import Device
from lodbench.kernels.refine.adaptive_patterns import AdaptivePatterns, Params
from lodbench.kernels.refine.adaptive_patterns.reference import edge_depths, pattern_numbers
from lodbench.kernels.refine.adaptive_patterns.tags import expected_tags, spans
from lodbench.kernels.refine.attributes import canonical
from lodbench.kernels.system import System

__all__ = ["Params", "SYSTEM", "binned"]


def binned(mesh: TriangleMesh, params: Params) -> TriangleMesh:
    """The mesh, its triangles by the pattern that they take without a view, the same pattern's in their order."""
    mesh = canonical(mesh)
    if not mesh.triangle_count:
        return mesh
    tags = expected_tags(
        params, mesh.positions, spans(mesh, mesh.diagonal), None, mesh.diagonal
    ).astype(np.float32)
    depths, _ = edge_depths(mesh.triangles, tags, params.finest)
    order = np.argsort(pattern_numbers(depths, params.finest), kind="stable")
    edge_tags = None if mesh.edge_tags is None else mesh.edge_tags[order]
    return replace(mesh, triangles=mesh.triangles[order], edge_tags=edge_tags)


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> AdaptivePatterns:
    """As `adaptive_patterns`, of the sorted mesh."""
    return AdaptivePatterns(device, binned(mesh, params), params)


SYSTEM = System(
    name="binned_adaptive_patterns",
    family="baselines",
    source="Boubekeur & Schlick 2007, GPU Gems 3, chapter 5",
    takes=(TriangleMesh,),
    prepare=prepare,
    cases={"curvature_32": Params(32, indices=False)},
    notes="adaptive_patterns over triangles that lie sorted by their pattern",
)
