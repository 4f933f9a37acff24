"""Pictures of tessellated patches: the first model of a run at falling levels, triangles over shading.

Source: Concheiro 2013, figure 2.9 (models), for what is shown.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.harness.plan import registry
from lodbench.harness.record.record import GroupRecord, RunRecord
from lodbench.kernels import tessellate_surface
from lodbench.kernels.opencl import Device
from lodbench.kernels.render import mesh_view, render

LEVELS = (5, 4, 3, 2, 1, 0)


def tessellation_pictures(
    record: RunRecord, size: tuple[int, int], device: Device
) -> Iterator[tuple[dict[str, Any], NDArray[np.uint8]]]:
    """The first patches that were tessellated, by the preferred system.

    Args:
        record: the run.
        size: of a picture, pixels.
        device: what tessellates and draws.

    Yields:
        `file`, `caption` and `series`, and the pixels.
    """
    group = next((group for group in record.groups if _tessellates(group)), None)
    name = group.dataset if group else ""
    patches = catalogue.find(name).surface if group else None
    if group is None or not isinstance(patches, BezierPatches):
        return
    meshes = {level: tessellate_surface(device, patches, level=level).mesh for level in LEVELS}
    view = mesh_view(meshes[LEVELS[0]], size=size, up="z")
    for number, (level, mesh) in enumerate(meshes.items()):
        caption = f"{name}, level {level}: {mesh.triangle_count:,} triangles"
        yield (
            {
                "file": f"level_{number}_{name}.png",
                "caption": caption,
                "series": "levels of patches",
                "table": group.table,
                "level": number,
            },
            render(mesh, camera=view, wireframe=True, device=device),
        )


def _tessellates(group: GroupRecord) -> bool:
    known = registry.registry().systems
    return any(
        subject.system in known and "tessellate" in known[subject.system].verbs
        for subject in group.subjects.values()
    )
