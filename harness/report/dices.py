"""Pictures of KSDices: the first model that was cut by pixels, with dices of 1, 8 and 16, non-uniform, and one each.

Source: Concheiro 2013, figure 6.15, for what is shown.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.finest import finest
from lodbench.datasets_gen.nurbs_surface import NurbsModel
from lodbench.harness.record.record import RunRecord
from lodbench.kernels.nurbs.rpns import Params, Rpns
from lodbench.kernels.opencl import Device
from lodbench.kernels.render import mesh_view, render
from lodbench.kernels.system import Frame, run

TABLE, LEVEL = "rc13_6_15", 7
ZOOM = 3.0  # from the view of the whole
SHOWN: tuple[tuple[str, dict[str, Any]], ...] = (
    ("1 pixel a dice", {"pixel_area": 1.0}),
    ("8 pixels", {"pixel_area": 8.0}),
    ("16 pixels", {"pixel_area": 16.0}),
    ("64 pixels", {"pixel_area": 64.0}),
    ("64 pixels, non-uniform", {"pixel_area": 64.0, "sampling": "non_uniform"}),
    ("one dice", {"sampling": "one"}),
)


def dice_pictures(
    record: RunRecord, size: tuple[int, int], device: Device
) -> Iterator[tuple[dict[str, Any], NDArray[np.uint8]]]:
    """The first model of the table, as it is cut for this view, triangles over shading.

    Args:
        record: the run.
        size: of a picture, pixels.
        device: what tessellates and draws.

    Yields:
        `file`, `caption` and `series`, and the pixels.
    """
    name = next((group.dataset for group in record.groups if group.table == TABLE), None)
    model = None if name is None else catalogue.find(name).surface
    if not isinstance(model, NurbsModel):
        return
    model, _ = model.recentred()
    whole = mesh_view(finest(model), size=size)
    view = replace(whole, world_to_clip=np.diag([ZOOM, ZOOM, 1, 1]) @ whole.world_to_clip)
    for number, (words, options) in enumerate(SHOWN):
        own = {"sampling": "adaptive", "level": LEVEL} | options
        prepared = Rpns(device, model, Params(**own))
        run(device, prepared, Frame(view))
        (mesh,) = prepared.result()
        dices = prepared.counters()["dices"]
        yield (
            {
                "file": f"dices_{number}_{name}.png",
                "caption": f"{name}, {words}: {dices:,} KSDices",
                "series": "KSDices",
            },
            render(mesh, camera=view, wireframe=True, device=device),
        )
