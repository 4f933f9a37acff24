"""What the host does to a clustered mesh where asked: drop what is turned over, carry attributes, part its sheets."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import ATTRIBUTES, TriangleMesh
from lodbench.kernels.cluster import turned
from lodbench.kernels.cluster.attributes import carry
from lodbench.kernels.cluster.clustering import Clustering
from lodbench.kernels.cluster.links import troubled
from lodbench.kernels.cluster.manifold import Parted, part
from lodbench.kernels.cluster.turned import NO_VERTEX
from lodbench.kernels.result import Counters, Result
from lodbench.kernels.targets import missed

Index = NDArray[np.intp]


@dataclass(frozen=True)
class Asked:
    """What is to be done.

    Attributes:
        attributes: carry normals, uvs, colours and tags.
        remove_flipped: drop triangles that are turned over.
        manifold: part sheets that meet.
    """

    attributes: bool
    remove_flipped: bool
    manifold: bool


def finished(prepared: Clustering, mesh: TriangleMesh, made: Result, asked: Asked) -> Result:
    """The result with what is asked for done to it, and its counters.

    Args:
        prepared: has run.
        mesh: its input.
        made: its mesh and map.
        asked: what is to be done, in the order of its fields but that attributes follow the triangles dropped.
    """
    simplified, vertex_map, counters = made.mesh, made.vertex_map, dict(prepared.more_counters())
    assert vertex_map is not None
    distinct = prepared.params.remove_duplicates
    clustered, rows = (simplified, vertex_map), None
    places = simplified  # with a vertex for each place: those of seams of attributes are apart
    if asked.remove_flipped or asked.attributes or asked.manifold:
        rows = _sources(prepared, mesh, simplified, vertex_map, asked.remove_flipped)
        if asked.remove_flipped:
            triangles = vertex_map[mesh.triangles[rows]].reshape(-1, 3)
            counters["flipped_removed"] = simplified.triangle_count - len(triangles)
            simplified, vertex_map = turned.with_triangles(simplified, vertex_map, triangles)
        places = simplified
        if asked.attributes:
            with made.setup.host("attributes"):
                carried = carry(mesh, simplified, vertex_map, rows)
            simplified, vertex_map = carried.mesh, carried.vertex_map
            counters["split_vertices"] = carried.split
        if asked.manifold:
            with made.setup.host("manifold"):
                bad = troubled(prepared.device, places.triangles, places.vertex_count)
                found = part(places.positions, places.triangles, bad)
                simplified, vertex_map, rows, more = _parted(
                    mesh, found, len(bad), simplified, vertex_map, rows
                )
            counters |= more
            places = simplified
        if "target" in counters:
            counters |= missed(int(counters["target"]), simplified.triangle_count)

    def idle() -> dict[str, int]:
        if rows is None:
            return turned.counted(mesh, *clustered, distinct)
        repeated = turned.duplicates(places.triangles, places.vertex_count)
        over = 0 if asked.remove_flipped else turned.turned_over(mesh, places, rows)
        return dict(zip(turned.COUNTED, (repeated, over), strict=True))

    sizes = {"vertices": simplified.vertex_count, "triangles": simplified.triangle_count}
    told = Counters({**sizes, **counters}, turned.COUNTED, idle)
    return replace(
        made, mesh=simplified, vertex_map=vertex_map, levels=(simplified,), counters=told
    )


def _sources(
    prepared: Clustering,
    mesh: TriangleMesh,
    simplified: TriangleMesh,
    vertex_map: NDArray[np.uint32],
    remove_flipped: bool,
) -> Index:
    """The input triangle of each output triangle, ascending, without those that are turned over where they go."""
    if remove_flipped:
        fates = turned.fates(mesh, simplified, vertex_map)
        distinct = prepared.params.remove_duplicates
        return turned.sources(fates, mesh, simplified, vertex_map, distinct, remove_flipped)
    rows = prepared.sources()
    if prepared.params.remove_duplicates:
        triangles = vertex_map[mesh.triangles[rows]].reshape(-1, 3)
        rows = rows[turned.first_of_each(triangles, simplified.vertex_count)]
    return rows


def _parted(
    mesh: TriangleMesh,
    found: Parted,
    places: int,
    simplified: TriangleMesh,
    vertex_map: NDArray[np.uint32],
    sources: Index,
) -> tuple[TriangleMesh, NDArray[np.uint32], Index, dict[str, int]]:
    """The mesh with a vertex for each fan, in the order of those they were, its map, sources and counters.

    Args:
        mesh: the input.
        found: the fans of its corners.
        places: of its vertices, before some were split at seams.
        simplified: the output, whose vertices may have been split at seams.
        vertex_map: (n,) of the input's vertices.
        sources: (m,) the input triangle of each output triangle.
    """
    sources, before = sources[found.rows], simplified.triangles[found.rows]
    parted = np.flatnonzero(found.fans.reshape(-1) >= places)
    corners, count = before.reshape(-1), np.uint64(found.fans.max(initial=-1) + 1)
    fans = found.fans.reshape(-1)[parted].astype(np.uint64)
    keys, at = np.unique(corners[parted].astype(np.uint64) * count + fans, return_inverse=True)
    owns = (keys // max(count, np.uint64(1))).astype(np.intp)
    sizes = np.zeros(simplified.vertex_count, np.intp)  # output vertices of each one before
    sizes[corners] = 1
    used = int(sizes.sum())
    sizes[owns] = 0
    sizes += np.bincount(owns, minlength=len(sizes))
    starts = np.cumsum(sizes) - sizes
    triangles = starts.astype(np.uint32)[corners]
    triangles[parted] += (at.reshape(-1) - np.searchsorted(owns, corners[parted])).astype(np.uint32)
    own = np.repeat(np.arange(len(sizes)), sizes)
    # an input vertex is where its first corner that is left is, or else where any of its output vertex' is
    first = np.append(np.where(sizes > 0, starts, NO_VERTEX), NO_VERTEX).astype(np.uint32)
    mapped = first[np.minimum(vertex_map, np.uint32(simplified.vertex_count))]
    mapped[mesh.triangles[sources[parted // 3], parted % 3][::-1]] = triangles[parted][::-1]
    kept = {
        name: values[own]
        for name in ("positions", *ATTRIBUTES)
        if (values := getattr(simplified, name)) is not None
    }
    counters = {
        "parted_vertices": len(own) - used,
        "back_to_back_removed": simplified.triangle_count - len(before),
    }
    triangles = triangles.reshape(-1, 3)
    return replace(simplified, triangles=triangles, **kept), mapped, sources, counters
