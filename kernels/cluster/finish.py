"""What the host does to a clustered mesh where asked: drop what is turned over, carry attributes, part its sheets."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import ATTRIBUTES, TriangleMesh
from lodbench.kernels.cluster import turned
from lodbench.kernels.cluster.attributes import carry
from lodbench.kernels.cluster.clustering import Clustering
from lodbench.kernels.cluster.manifold import part
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
    distinct = getattr(prepared.params, "remove_duplicates", False)
    clustered = mesh, simplified, vertex_map, distinct
    turned_over: int | None = None  # counted later, where no triangle was dropped
    if asked.remove_flipped or asked.attributes or asked.manifold:
        fates = turned.fates(mesh, simplified, vertex_map)
        sources = turned.sources(fates, *clustered, asked.remove_flipped)
        if asked.remove_flipped:
            triangles = vertex_map[mesh.triangles[sources]].reshape(-1, 3)
            counters["flipped_removed"] = simplified.triangle_count - len(triangles)
            simplified, vertex_map = turned.with_triangles(simplified, vertex_map, triangles)
            turned_over = 0
        places = simplified
        if asked.attributes:
            with made.setup.host("attributes"):
                carried = carry(mesh, simplified, vertex_map, sources)
            simplified, vertex_map = carried.mesh, carried.vertex_map
            counters["split_vertices"] = carried.split
        if asked.manifold:
            with made.setup.host("manifold"):
                simplified, vertex_map, sources, more = _parted(
                    mesh, places, simplified, vertex_map, sources
                )
            counters |= more
            places = simplified
            turned_over = int(np.count_nonzero(fates[sources] == turned.TURNED))
        if "target" in counters:
            counters |= missed(int(counters["target"]), simplified.triangle_count)
    else:
        places = simplified

    def idle() -> dict[str, int]:
        if turned_over is None:
            return turned.counted(*clustered)
        repeated = turned.duplicates(places.triangles, places.vertex_count)
        return dict(zip(turned.COUNTED, (repeated, turned_over), strict=True))

    sizes = {"vertices": simplified.vertex_count, "triangles": simplified.triangle_count}
    told = Counters({**sizes, **counters}, turned.COUNTED, idle)
    return replace(
        made, mesh=simplified, vertex_map=vertex_map, levels=(simplified,), counters=told
    )


def _parted(
    mesh: TriangleMesh,
    places: TriangleMesh,
    simplified: TriangleMesh,
    vertex_map: NDArray[np.uint32],
    sources: Index,
) -> tuple[TriangleMesh, NDArray[np.uint32], Index, dict[str, int]]:
    """The mesh with a vertex for each fan, in the order of those they were, its map, sources and counters.

    Args:
        mesh: the input.
        places: the output before its vertices were split at seams.
        simplified: the output.
        vertex_map: (n,) of the input's vertices.
        sources: (m,) the input triangle of each output triangle.
    """
    found = part(places.positions, places.triangles)
    sources, before = sources[found.rows], simplified.triangles[found.rows].astype(np.uint64)
    count = np.uint64(found.fans.max(initial=-1) + 1)
    keys, at = np.unique(before * count + found.fans.astype(np.uint64), return_inverse=True)
    triangles = at.reshape(-1, 3).astype(np.uint32)
    own = (keys // max(count, np.uint64(1))).astype(np.intp)
    # an input vertex is where its first corner that is left is, or else where any of its output vertex' is
    first = np.full(simplified.vertex_count + 1, NO_VERTEX)
    first[own[::-1]] = np.arange(len(own), dtype=np.uint32)[::-1]
    mapped = first[np.minimum(vertex_map, np.uint32(simplified.vertex_count))]
    mapped[mesh.triangles[sources].ravel()[::-1]] = triangles.ravel()[::-1]
    kept = {
        name: values[own]
        for name in ("positions", *ATTRIBUTES)
        if (values := getattr(simplified, name)) is not None
    }
    used = len(np.unique(before))
    counters = {
        "parted_vertices": len(own) - used,
        "back_to_back_removed": simplified.triangle_count - len(triangles),
    }
    return replace(simplified, triangles=triangles, **kept), mapped, sources, counters
