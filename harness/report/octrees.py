"""Pictures of one mesh on a grid and on octrees with as many triangles, coloured by how fine their cells are."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.plan import registry
from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.report.amounts import rounded
from lodbench.kernels.cluster.octree import Octree
from lodbench.kernels.opencl import Device
from lodbench.kernels.render import mesh_view, render
from lodbench.kernels.system import run

OURS, UNIFORM = "octree", "quadric_clustering"
CAMERA = (120.0, 25.0)  # degrees
MOST = 3  # pictures
FINE = 1.5  # halvings of a cell's edge from the uniform grid's to either end of the colours

Picture = tuple[dict[str, Any], NDArray[np.uint8]]


def octree_pictures(record: RunRecord, size: tuple[int, int], device: Device) -> Iterator[Picture]:
    """The grid, then octrees, of the first group that has both, from one camera.

    Args:
        record: the run.
        size: of a picture, pixels.
        device: what simplifies and draws.

    Yields:
        `file`, `caption` and `series`, and the pixels.
    """
    for group in record.groups:
        found = [s for s in group.subjects.values() if s.status == "ok" and s.quality]
        grid = next((s for s in found if s.system == UNIFORM), None)
        trees = [s for s in found if s.system == OURS][: MOST - 1]
        if grid is not None and trees:
            yield from _drawn(group, [grid, *trees], size, device)
            return


def _drawn(
    group: GroupRecord, subjects: list[SubjectRecord], size: tuple[int, int], device: Device
) -> Iterator[Picture]:
    mesh = catalogue.find(group.dataset).surface
    assert isinstance(mesh, TriangleMesh)
    mesh = mesh.with_origin(None)
    view, middle = mesh_view(mesh, CAMERA, size), 0.0
    for number, subject in enumerate(subjects):
        system = registry.system(subject.system)
        params = registry.parameters(system, None, subject.params or {})
        prepared: Any = system.prepare(device, mesh, params)
        run(device, prepared)
        (simplified,) = prepared.result()
        if isinstance(prepared, Octree):
            fineness = np.log2(prepared.cells / prepared.edges())
        else:
            middle = np.log2(prepared.grid.extent)
            fineness = np.full(simplified.vertex_count, middle)
        of_faces = fineness[simplified.triangles].mean(axis=1)
        off = (subject.quality or {}).get("rms_error")
        caption = (
            f"{group.dataset}, {subject.label}: {simplified.triangle_count:,} triangles, RMS error "
            f"{rounded(off, 2) if off is not None else '-'} of the diagonal; the brighter the finer"
        )
        picture = {"file": f"octree_{number}_{group.dataset}.png", "series": "octree",
                   "table": group.table, "caption": caption}  # fmt: skip
        ends = (middle - FINE, middle + FINE)
        look = {"colour": of_faces, "colour_range": ends, "wireframe": True, "device": device}
        yield picture, render(simplified, camera=view, **look)
