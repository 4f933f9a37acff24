"""A grid whose mesh has the target once its sheets are parted: triangles that back each other leave it short."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.clustering import Clustering
from lodbench.kernels.cluster.links import troubled
from lodbench.kernels.cluster.manifold import part
from lodbench.kernels.cluster.target import ClusterTarget
from lodbench.kernels.cluster.unchanged import Unchanged
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.system import run

CLOSER = 0.99  # share of the target that is near enough
MOST = 4  # grids tried

T = TypeVar("T", bound=ClusterTarget)


def nearer(
    device: Device,
    mesh: TriangleMesh,
    params: T,
    first: Clustering,
    frame: Timeline,
    prepare: Callable[[Device, TriangleMesh, T], Clustering | Unchanged],
) -> tuple[Clustering, Timeline]:
    """The clustering that leaves most triangles of at most the target, and its frame; at most `MOST` are tried.

    Args:
        device, mesh: as for the system.
        params: with a target.
        first: its subject, which has run.
        frame: of that.
        prepare: the system's.
    """
    found = first.found
    if found is None or found.cells is None or not hasattr(params, "cells"):
        return first, frame
    best, tried, cells, most = (first, frame), first, found.cells, 0
    low, high = 0.0, math.inf  # cells that leave too few, and too many
    for turn in range(MOST):
        (clustered, _) = tried.read_back()
        bad = troubled(device, clustered.triangles, clustered.vertex_count)
        left = len(part(clustered.positions, clustered.triangles, bad).rows)
        if most < left <= found.target:
            best, most = (tried, frame), left
        low, high = (max(low, cells), high) if left <= found.target else (low, min(high, cells))
        if CLOSER * found.target <= left <= found.target or not left or turn == MOST - 1:
            break
        cells *= math.sqrt(0.5 * (1 + CLOSER) * found.target / left)
        if not low < cells < high:
            cells = math.sqrt(low * high)
        asked = replace(params, target_count=None, target_reduction=None, cells=cells)
        again = prepare(device, mesh, asked)
        if not isinstance(again, Clustering):
            break
        frame = run(device, again)
        again.found = replace(found, cells=cells, counts=found.counts + turn + 1)
        tried = again
    return best
