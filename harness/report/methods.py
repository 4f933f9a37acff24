"""One mesh by every method at the same number of triangles, in one strip, coloured by the distance to the input."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.measure.quality import located
from lodbench.harness.plan import registry
from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.report.amounts import rounded
from lodbench.kernels.opencl import Device, Unsupported
from lodbench.kernels.render import mesh_view, render
from lodbench.kernels.system import run

TABLE, REDUCTION = "pareto", 0.99
ACROSS = 4  # pictures in a row
RANGE = (0.0, 0.004)  # of the colours, distance as a share of the diagonal

Picture = tuple[dict[str, Any], NDArray[np.uint8]]


def method_pictures(record: RunRecord, size: tuple[int, int], device: Device) -> Iterator[Picture]:
    """The strip of the first group of the table at a hundredth of the triangles.

    Args:
        record: the run.
        size: of each part of the strip, pixels.
        device: what simplifies and draws.

    Yields:
        `file`, `caption` and `series`, and the pixels.
    """
    for group in record.groups:
        if group.table == TABLE and group.facts.get("reduction") == REDUCTION:
            found = [s for s in group.subjects.values() if s.status == "ok" and s.quality]
            found = [
                s
                for s in found
                if not s.label.endswith(("_call", "_one_core")) or s.label == "hybrid_call"
            ]
            if found:
                yield _strip(group, found, size, device)
            return


def _strip(
    group: GroupRecord, subjects: list[SubjectRecord], size: tuple[int, int], device: Device
) -> Picture:
    mesh = catalogue.find(group.dataset).surface
    assert isinstance(mesh, TriangleMesh)
    mesh = mesh.with_origin(None)
    view, parts, said = mesh_view(mesh, size=size), [], []
    for subject in subjects:
        system = registry.system(subject.system)
        params = registry.parameters(system, None, subject.params or {})
        try:
            prepared: Any = system.prepare(device, mesh, params)
        except Unsupported:
            continue
        run(device, prepared)
        (made,) = prepared.result()
        look = {"colour": distances(mesh, made), "colour_range": RANGE, "wireframe": True}
        parts.append(render(made, camera=view, device=device, **look))
        off = rounded((subject.quality or {}).get("rms_error") or 0.0, 2)
        said.append(f"{subject.label} ({made.triangle_count:,}, {off})")
    caption = (
        f"{group.dataset}, row by row, with triangles and RMS error: {', '.join(said)}; the brighter the farther from "
        f"the input, up to {RANGE[1]:g} of the diagonal"
    )
    return {"file": f"methods_{group.dataset}.png", "series": "methods", "caption": caption}, tiled(
        parts
    )


def distances(mesh: TriangleMesh, made: TriangleMesh) -> NDArray[np.float64]:
    """Of the middle of each triangle of `made` to the mesh, (m,), share of the diagonal."""
    squared, _ = located(mesh).nearest(located(made, mesh).positions[made.triangles].mean(axis=1))
    return np.sqrt(squared)


def tiled(parts: list[NDArray[np.uint8]]) -> NDArray[np.uint8]:
    """Pictures of one size, (h, w, 3), in rows of `ACROSS`; white where the last row is short."""
    blank = np.full_like(parts[0], 255)
    across = min(ACROSS, len(parts))
    parts = parts + [blank] * (-len(parts) % across)
    rows = [np.concatenate(parts[at : at + across], axis=1) for at in range(0, len(parts), across)]
    return np.concatenate(rows)
