"""Pictures of warped clustering grids beside even ones: the first mesh with a region, the first with an eye."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.plan import registry
from lodbench.harness.plan.focus import Focus
from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.report.amounts import rounded
from lodbench.kernels.opencl import Device
from lodbench.kernels.render import mesh_view, render
from lodbench.kernels.system import View, run

Picture = tuple[dict[str, Any], NDArray[np.uint8]]


def warp_pictures(record: RunRecord, size: tuple[int, int], device: Device) -> Iterator[Picture]:
    """Each subject of the first group whose focus is a ball, seen as a whole, and of the first whose focus is an eye.

    Args:
        record: the run.
        size: of a picture, pixels, of the shape of the tables' images.
        device: what simplifies and draws.

    Yields:
        `file`, `caption` and `series`, and the pixels.
    """
    found = [(group, focus_of(group)) for group in record.groups]
    balls = [(group, focus) for group, focus in found if focus and focus.radius]
    eyes = [(group, focus) for group, focus in found if focus and not focus.radius]
    for kind, groups in (("region", balls), ("view", eyes)):
        for group, focus in groups[:1]:
            mesh = catalogue.find(group.dataset).surface
            assert isinstance(mesh, TriangleMesh)
            mesh = mesh.with_origin(None)
            view = mesh_view(mesh, size=size)
            if kind == "view":
                view = replace(focus.view(mesh), width=size[0], height=size[1])
            yield from _subjects(kind, group, mesh, view, device)


def focus_of(group: GroupRecord) -> Focus | None:
    """The group's focus, as its record keeps it."""
    kept = group.config.get("focus")
    return Focus(tuple(kept["at"]), kept["radius"]) if kept else None


def _subjects(
    kind: str, group: GroupRecord, mesh: TriangleMesh, view: View, device: Device
) -> Iterator[Picture]:
    for number, subject in enumerate(group.subjects.values()):
        if subject.status == "ok":
            picture = {
                "file": f"warp_{kind}_{number}_{group.dataset}.png",
                "series": f"{kind} warp",
            }
            simplified = _simplified(subject, mesh, device)
            picture["caption"] = (
                f"{group.dataset}, {subject.label}: {simplified.triangle_count:,} triangles{_error(subject)}"
            )
            look = {"colour": "flat", "wireframe": True}
            yield picture, render(simplified, camera=view, device=device, **look)


def _simplified(subject: SubjectRecord, mesh: TriangleMesh, device: Device) -> TriangleMesh:
    system = registry.system(subject.system)
    prepared = system.prepare(device, mesh, registry.parameters(system, None, subject.params or {}))
    run(device, prepared)
    return prepared.result()[0]


def _error(subject: SubjectRecord) -> str:
    quality = subject.quality or {}
    if quality.get("rms_pixels") is not None:
        return f", RMS error {rounded(quality['rms_pixels'], 2)} pixels at 1280 x 1024"
    if quality.get("rms_error_inside") is not None:
        return f", RMS error {rounded(quality['rms_error_inside'], 2)} of the diagonal inside"
    return ""
