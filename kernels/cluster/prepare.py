"""From what a user asks of a clustering to its subject: the grid that a number of triangles needs, and the verb."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.attributes import has_attributes
from lodbench.kernels.cluster.borders import border_vertices
from lodbench.kernels.cluster.clustering import Clustering
from lodbench.kernels.cluster.finish import Asked, finished
from lodbench.kernels.cluster.nearer import nearer
from lodbench.kernels.cluster.search import Found, find_cells
from lodbench.kernels.cluster.survivors import DeviceSurvivors
from lodbench.kernels.cluster.target import ClusterTarget
from lodbench.kernels.cluster.unchanged import Unchanged, without_duplicates
from lodbench.kernels.cluster.upload import Upload
from lodbench.kernels.cluster.warped import WarpedTarget, warp_of
from lodbench.kernels.opencl import Device
from lodbench.kernels.parameters import check
from lodbench.kernels.result import Result
from lodbench.kernels.system import run
from lodbench.kernels.targets import missed

P = TypeVar("P", bound=WarpedTarget)
T = TypeVar("T", bound=ClusterTarget)


def prepare(
    device: Device,
    mesh: TriangleMesh,
    params: P,
    make: Callable[[Upload, P, Found | None], Clustering],
    files: Sequence[str] = (),
) -> Clustering | Unchanged:
    """The mesh uploaded, the grid found where a number of triangles is asked for, and a frame ready to run.

    Where all triangles are asked for, or no grid comes nearer, the mesh itself is the result. With a target, `setup`
    has the stage "search".

    Args:
        device: where it runs.
        mesh: what is simplified.
        params: with a target, or a grid.
        make: a system's subject, of the mesh on the device and params with a grid.
        files: the system's own kernels, built with those that all clusterings share.

    Raises:
        ValueError: more than 2**27 cells.
        Unsupported: no room, or something that the device lacks.
    """
    warp = warp_of(params, mesh, device)
    upload = Upload(device, mesh, files, warp, borders=params.uses_border)
    kept = border_vertices(upload.border_edges) if params.keeps_border else None
    asked = params.triangles(mesh.triangle_count)
    if asked is None:
        return make(upload, params, None)
    distinct = params.remove_duplicates
    found = search_cells(upload, asked, distinct, kept)
    if found.cells is not None:
        params = replace(params, target_reduction=None, target_count=None, cells=found.cells)
        return make(upload, params, found)
    return unchanged(upload, asked, distinct, files, found.counts)


def unchanged(
    upload: Upload, asked: int, distinct: bool, files: Sequence[str], passes: int = 0
) -> Unchanged:
    """The mesh itself behind the contract, without duplicates where they are to go."""
    device, mesh, left = upload.device, upload.mesh, upload
    if distinct:
        left = Upload(device, without_duplicates(mesh), files)
        upload.setup.stage_s |= left.setup.stage_s
    counters = {
        "vertices_in": mesh.vertex_count, "triangles_in": mesh.triangle_count,
        "counting_passes": passes, **missed(asked, left.mesh.triangle_count),
    }  # fmt: skip
    return Unchanged(device, left.mesh, left.positions, left.triangles, upload.setup, counters)


def simplifier(
    prepare: Callable[[Device, TriangleMesh, T], Clustering | Unchanged], params: type[T]
) -> Callable[..., Result]:
    """The verb `simplify` of a clustering, made of its `prepare` and its `Params`."""

    def simplify(
        device: Device,
        mesh: TriangleMesh,
        *,
        attributes: bool = True,
        remove_flipped: bool = False,
        manifold: bool = False,
        **options: Any,
    ) -> Result:
        """The simplified mesh, by a number of triangles or by a grid; other options are those of the Params.

        With a target, `counters` also holds `target`, `target_gap` (triangles short of it, negative where every grid
        with fewer leaves none at all) and `counting_passes`. Where all triangles are asked for the result is the mesh
        as it came, points that no triangle uses among them.

        Args:
            device: where it runs.
            mesh: what is simplified.
            attributes: carry normals, uvs, colours and tags, where the mesh has them, and split vertices at seams, as
                `cluster/attributes.py` says; `split_vertices` counts those added, `setup` has the stage "attributes".
            remove_flipped: drop output triangles whose normal points against that of the input triangle that they come
                from, and vertices that no other uses; `flipped_removed` counts them. A target is met before.
            manifold: part the sheets that meet at an edge or a vertex, as `cluster/manifold.py` says: no edge has more
                than two triangles then, and a closed, oriented mesh stays closed, but for seams of attributes.
                `parted_vertices` counts those added, `back_to_back_removed` the triangles that backed each other;
                `setup` has the stage "manifold". A target is met by what is left then, on a grid, to 1 % where it can.
            **options: of the Params.
        """
        check("attributes", attributes, bool)
        check("remove_flipped", remove_flipped, bool)
        check("manifold", manifold, bool)
        asked_for = params.named(**options)
        prepared = prepare(device, mesh, asked_for)
        if isinstance(prepared, Clustering):
            prepared.map_vertices()
        frame = run(device, prepared, wait=prepared.live)
        if manifold and not remove_flipped and isinstance(prepared, Clustering):
            prepared, frame = nearer(device, mesh, asked_for, prepared, frame, prepare)
        simplified, vertex_map = prepared.read_back()
        if not attributes:
            simplified = simplified.bare()
        made = Result(simplified, vertex_map, (simplified,), {}, prepared.setup, frame)
        if isinstance(prepared, Unchanged):
            return replace(made, counters=prepared.counters())
        asked = Asked(attributes and has_attributes(mesh), remove_flipped, manifold)
        return finished(prepared, mesh, made, asked)

    return simplify


def search_cells(
    upload: Upload,
    target_count: int,
    remove_duplicates: bool = False,
    kept: NDArray[np.uint32] | None = None,
) -> Found:
    """The grid that leaves at most `target_count` triangles, as `find_cells` says; seconds go to the stage "search"."""
    with upload.setup.host("search"):
        count = DeviceSurvivors(
            upload.device, upload.program, upload.placed, upload.triangles, upload.box,
            remove_duplicates, kept,
        )  # fmt: skip
        extents = upload.box[1] - upload.box[0]
        return find_cells(count, extents, upload.mesh.triangle_count, target_count)
