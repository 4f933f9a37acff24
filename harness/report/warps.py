"""Pictures of warped clustering grids beside even ones: the first mesh with a region, the first with an eye."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.plan.focus import Focus
from lodbench.harness.record.record import GroupRecord, RunRecord
from lodbench.harness.report.compared import Picture, subject_pictures
from lodbench.kernels.opencl import Device
from lodbench.kernels.render import mesh_view


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
            yield from subject_pictures(f"{kind} warp", group, mesh, view, device)


def focus_of(group: GroupRecord) -> Focus | None:
    """The group's focus, as its record keeps it."""
    kept = group.config.get("focus")
    return Focus(tuple(kept["at"]), kept["radius"]) if kept else None
