"""Pictures of a chain of levels of detail: each level from one camera, as DeCoro & Tatarchuk 2007, slides 20 to 22."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels import simplify_mesh
from lodbench.kernels.opencl import Device
from lodbench.kernels.render import render
from lodbench.kernels.system import View

DRAWN_FROM = "level_chain"  # the system that these pictures are about
LEVELS = 4
REDUCTION = 0.9


def chain_pictures(
    name: str, mesh: TriangleMesh, view: View, device: Device, table: str = ""
) -> Iterator[tuple[dict[str, Any], NDArray[np.uint8]]]:
    """Each level that has triangles, finest first, in flat colours.

    Args:
        name: of the dataset.
        mesh: its surface.
        view: of all of them.
        device: what simplifies and draws.
        table: that the pictures belong to.

    Yields:
        `file`, `caption` and `series`, and the pixels.
    """
    result = simplify_mesh(
        device, mesh, target_reduction=REDUCTION, method=DRAWN_FROM, levels=LEVELS
    )
    for number, level in enumerate(result.levels, 1):
        if not level.triangle_count:
            continue
        picture = {
            "file": f"chain_{number}_{name}.png",
            "caption": f"{name}, level {number} of a chain: {level.triangle_count:,} triangles",
            "series": "chain",
            "table": table,
            "level": number,
        }
        yield picture, render(level, camera=view, colour="flat", device=device)
