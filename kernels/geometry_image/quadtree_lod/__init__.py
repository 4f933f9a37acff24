"""A closed surface drawn from its geometry image in as much detail as the view asks for, without cracks.

A quadtree over the image holds, per node, how far the surface lies from the node's two flat triangles. One pass over
all nodes, packed in one texture, picks those that are fine enough while their parents are not; the picked nodes cover
the image once. Each becomes two triangles, or a fan over its perimeter where a neighbour is finer.

The paper compares errors with one threshold that follows the viewer's distance from the model; `view="node"` compares
each node's error as it appears on screen (reconstruction). How nodes of different depth meet is not said in the paper:
here every corner of a finer neighbour stays in the perimeter, so the surface is closed for any choice of nodes.

Source: Wang, Liu, Feng & Li (Hohai University), Multiresolution rendering of complex triangular mesh model based on
GPU, sections 2 and 3, figures 2-4.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh
from lodbench.kernels.geometry_image.quadtree_lod.host import QuadtreeLod, prepare
from lodbench.kernels.geometry_image.quadtree_lod.params import Params
from lodbench.kernels.opencl import Device
from lodbench.kernels.result import Result
from lodbench.kernels.system import System, run
from lodbench.kernels.targets import Target, missed

__all__ = ["Params", "SYSTEM", "QuadtreeLod", "simplify"]


def level_for(triangle_count: int) -> int:
    """The image level whose full resolution has at least so many triangles; 3 to 11."""
    return min(max(math.ceil(math.log(max(triangle_count, 1) / 2, 4)), 3), 11)


def simplify(
    device: Device,
    mesh: TriangleMesh | GeometryImage,
    *,
    target_reduction: float | None = None,
    target_count: int | None = None,
    cells: Any = None,
    **options: Any,
) -> Result:
    """The surface with at most `target_count` triangles, or within `threshold`; `options` are those of `Params`.

    Args:
        device: where it is done.
        mesh: closed, oriented, genus 0; it is laid out on a sphere first, or that is read from the cache. Or a
            finished geometry image.
        target_reduction: share of the triangles removed; 0 gives a mesh as it came.
        target_count: triangles at most; a mesh that has no more comes back as it came. With either, `counters` gets
            `target` and `target_gap`, triangles short of it: negative where fewer than 8 were asked for.
        cells: must be None: this method has no grid.
        **options: see `Params`; `n` defaults to the least level that has as many triangles as the mesh, and with a
            target vertices are fitted and errors are shares.

    Raises:
        NotSpherical: the mesh is open, not manifold, in pieces, or of another genus.
    """
    if cells is not None:
        raise ValueError(f"cells: expected None for quadtree_lod, got {cells}")
    asked = Target(target_reduction=target_reduction, target_count=target_count)
    target = asked.triangles(mesh.triangle_count)
    if target is not None:
        options = {"placement": "fitted", "error_metric": "rms_share"} | options
    if isinstance(mesh, TriangleMesh):
        options.setdefault("n", level_for(mesh.triangle_count))
    params = Params.named(target_reduction=target_reduction, target_count=target_count, **options)
    if isinstance(mesh, TriangleMesh) and target is not None and target == mesh.triangle_count:
        own = np.arange(mesh.vertex_count, dtype=np.uint32)
        counters = {"vertices": mesh.vertex_count, "triangles": target, **missed(target, target)}
        return Result(mesh, own, (mesh,), counters)
    prepared = prepare(device, mesh, params)
    frame = run(device, prepared)
    simplified = prepared.result()[0]
    counters = dict(prepared.counters())
    if target is not None:
        counters |= missed(target, simplified.triangle_count)
    return Result(simplified, None, (simplified,), counters, prepared.setup, frame)


SYSTEM = System(
    name="quadtree_lod",
    family="geometry_image",
    source="Wang, Liu, Feng & Li, sections 2-3, figures 2-4",
    takes=(TriangleMesh, GeometryImage),
    prepare=prepare,
    cases={
        "thousandth": Params(n=6),
        "full": Params(n=6, threshold=0.0),
        "coarsest": Params(n=6, threshold=1e6),
        "node": Params(n=6, view="node"),
        "fitted": Params(n=6, placement="fitted", error_metric="rms_share", target_count=2000),
    },
    verbs={"simplify": simplify},
)
