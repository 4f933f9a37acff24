"""What the subdividing peers share: how often, what goes in, and whether what came out is the refined mesh.

They give a welded mesh, each vertex once and without normals, where a pattern gives instances that share nothing; the
triangles are as many. In linear ones each is split in four where it lies, which is the pattern's own surface. Loop's
scheme moves every vertex, the given ones too: a smooth surface, but another than that of curved PN triangles.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.harness.baselines.simplifier import used_only
from lodbench.harness.measure.quality import topology
from lodbench.kernels.opencl import Device, Timeline, Unsupported
from lodbench.kernels.parameters import Parameters
from lodbench.kernels.refine.lattice import Segments, lattice_sharing, lattice_weights
from lodbench.kernels.refine.refined import TOLERANCE
from lodbench.kernels.system import Check, System

Start: TypeAlias = Callable[[TriangleMesh, int], Callable[[], Any]]
"""(mesh, how many times each triangle is split in four) -> the call that is timed; what it gives, `read` reads."""
Verdict: TypeAlias = Callable[[Sequence[TriangleMesh]], Check]


@dataclass(frozen=True)
class Params(Parameters):
    """`segments`: parts that each coarse edge is cut into, a power of two up to 4096."""

    segments: Segments = 16


@dataclass(frozen=True)
class Peer:
    """A package's way of subdividing.

    Attributes:
        start: what is done once before the call, such as copying arrays; raises `Unsupported` without the package.
        read: (output of the call) -> the meshes; ValueError where it is none.
        linear: it splits triangles where they lie; else it moves vertices, within the hull of the mesh.
        any_mesh: more than two triangles may meet at an edge.
    """

    start: Start
    read: Callable[[Any], Sequence[TriangleMesh]]
    linear: bool
    any_mesh: bool = False


def halvings(segments: int) -> int:
    """How often edges are halved until there are so many segments.

    Raises:
        Unsupported: not a power of two.
    """
    if segments & (segments - 1):
        raise Unsupported(f"needs a power of two for segments, got {segments}")
    return segments.bit_length() - 1


def wide(mesh: TriangleMesh) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Points float64 and triangles int64, as the packages of arrays want them."""
    return mesh.positions.astype(np.float64), mesh.triangles.astype(np.int64)


def prepare(device: Device, mesh: TriangleMesh, params: Params, peer: Peer) -> HostPrepared:
    """The mesh without its unused vertices, in the peer's form; the call subdivides it all anew.

    Raises:
        Unsupported: the package is not installed, segments are no power of two, or an edge has more triangles than
            the peer takes.
    """
    times = halvings(params.segments)
    setup = Timeline()
    with setup.host("upload"):
        (coarse,) = used_only(mesh.positions, mesh.triangles)
        crossed = 0 if peer.any_mesh else int(topology(coarse)["nonmanifold_edges"])
        call = peer.start(coarse, times)
    if crossed:
        raise Unsupported(f"needs at most two triangles at an edge, mesh has {crossed} with more")
    empty = not coarse.triangle_count  # an error to some of the packages
    return HostPrepared(
        device,
        lambda _: None if empty else call(),
        read=lambda output: [coarse] if output is None else peer.read(output),
        verdict=refined_mesh_of(coarse, params.segments, peer.linear),
        setup=setup,
        input_bytes=coarse.positions.nbytes + coarse.triangles.nbytes,
    )


def _counts(mesh: TriangleMesh) -> NDArray[np.int64]:
    """Vertices, triangles and Euler characteristic."""
    return np.array([mesh.vertex_count, mesh.triangle_count, topology(mesh)["euler"]])


def refined_mesh_of(coarse: TriangleMesh, segments: int, linear: bool) -> Verdict:
    """Judge: as many vertices and triangles as a pattern's welded mesh, of the same Euler characteristic, in place.

    In place are, of a linear peer, exactly the points of the pattern; of another, points within the box.
    """
    _, vertices = lattice_sharing(coarse.triangles, segments)
    before = _counts(coarse)
    expected = np.array([vertices, before[1] * segments**2, before[2]])
    size = max(float(np.abs(coarse.positions).max(initial=0)), 1e-37)

    def verdict(result: Sequence[TriangleMesh]) -> Check:
        (mesh,) = result
        off = np.abs(_counts(mesh) - expected).sum()
        if off or not coarse.triangle_count:
            what = "vertices, triangles and Euler characteristic other than expected, in all"
            return Check(not off, what, float(off), 0.0)
        points = mesh.positions.astype(np.float64)
        if linear:
            what = "distance between vertices and the pattern's points, over the largest coordinate"
            corners = coarse.positions[coarse.triangles].astype(np.float64)
            there = (lattice_weights(segments) @ corners).reshape(-1, 3)
            found = max(_farthest(points, there), _farthest(there, points))
        else:
            what = "distance of vertices out of the mesh's box, over the largest coordinate"
            low, high = coarse.box
            found = float(np.maximum(low - points, points - high).max().clip(0))
        return Check(found <= TOLERANCE * size, what, found / size, TOLERANCE)

    return verdict


def _farthest(points: NDArray[np.float64], others: NDArray[np.float64]) -> float:
    """The largest distance of a point to the nearest of the others."""
    return float(KDTree(others).query(points)[0].max())


def subdivision_system(
    name: str, source: str, peer: Peer, cases: Mapping[str, Params]
) -> System[Params]:
    """A baseline that subdivides as `peer` does; see `System` for the other arguments."""

    def prepared(device: Device, mesh: TriangleMesh, params: Params) -> HostPrepared:
        return prepare(device, mesh, params, peer)

    return host_system(name, source, prepared, cases)
