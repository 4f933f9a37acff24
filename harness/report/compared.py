"""Pictures of what each subject of a group made of one mesh, side by side: where tables compare them by eye."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.plan import registry
from lodbench.harness.record.record import GroupRecord, SubjectRecord
from lodbench.harness.report.amounts import rounded
from lodbench.kernels.opencl import Device
from lodbench.kernels.render import render
from lodbench.kernels.system import View, run

Picture = tuple[dict[str, Any], NDArray[np.uint8]]

TABLES = {"borders": "border", "dt07_grids": "grid"}
"""Of which the first group is drawn, and in which series."""


def subject_pictures(
    series: str, group: GroupRecord, mesh: TriangleMesh, view: View, device: Device
) -> Iterator[Picture]:
    """What each subject that is all right leaves of the mesh, as wireframes over flat colours.

    Args:
        series: of the pictures.
        group: whose subjects are drawn.
        mesh: the group's dataset.
        view: of all of them.
        device: what simplifies and draws.

    Yields:
        `file`, `caption` and `series`, and the pixels.
    """
    for number, subject in enumerate(group.subjects.values()):
        if subject.status == "ok":
            simplified = _simplified(subject, mesh, device)
            said = f"{simplified.triangle_count:,} triangles{_error(subject)}"
            picture = {
                "file": f"{series.replace(' ', '_')}_{number}_{group.dataset}.png",
                "series": series,
                "table": group.table,
                "caption": f"{group.dataset}, {subject.label}: {said}",
            }
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
    for key, where in (("rms_error_inside", " inside"), ("rms_error", "")):
        if quality.get(key) is not None:
            return f", RMS error {rounded(quality[key], 2)} of the diagonal{where}"
    return ""
