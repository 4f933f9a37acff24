"""Pictures of adaptive tessellations: one level for all, on edges, inside too; and the tests; coloured by level.

Source: Concheiro 2013, figures 4.5 and 3.17, for what is shown.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.harness.plan import registry
from lodbench.harness.record.record import RunRecord
from lodbench.kernels.bezier.candidates import DEEPEST
from lodbench.kernels.opencl import Device
from lodbench.kernels.render import mesh_view, render
from lodbench.kernels.system import run

LEVEL = 5
MEAN = {"test": "mean"}
ANIMAL = "elephant_gumbo"  # by the test mean, where it was tessellated
SHOWN = (
    ("vst", {}, "one level for all"),
    ("semi_adaptive", {"test": "distance"}, "by distance, on edges"),
    ("dabt", {"test": "distance"}, "by distance, on edges and inside"),
    ("dabt", {"test": "flat"}, "by the angle between normals"),
    ("dabt", {"test": "length"}, "by length"),
    ("dabt", MEAN, "by the mean error of grids"),
)


def adaptive_pictures(
    record: RunRecord, size: tuple[int, int], device: Device
) -> Iterator[tuple[dict[str, Any], NDArray[np.uint8]]]:
    """The first model that was tessellated adaptively, at medium quality, from one camera, and `ANIMAL` by one test.

    Args:
        record: the run.
        size: of a picture, pixels.
        device: what tessellates and draws.

    Yields:
        `file`, `caption` and `series`, and the pixels.
    """
    groups = [
        group
        for group in record.groups
        if any(subject.system == "dabt" for subject in group.subjects.values())
    ]
    names = [re.sub(r"_x\d+$", "", group.dataset) for group in groups]
    shown: list[Any] = [(groups[0], names[0], *each) for each in SHOWN] if groups else []
    animal = next((g for g, name in zip(groups, names, strict=True) if name == ANIMAL), None)
    if animal and names[0] != ANIMAL:
        shown.append((animal, ANIMAL, "dabt", MEAN, "by the mean error of grids"))
    views = {}
    for number, (group, name, system, test, words) in enumerate(shown):
        patches = catalogue.find(name).surface
        if not isinstance(patches, BezierPatches):
            continue
        options = {"level": LEVEL, **test, **({"quality": "medium"} if test else {})}
        owner = registry.system(system)
        prepared: Any = owner.prepare(device, patches, registry.parameters(owner, None, options))
        run(device, prepared)
        (mesh,) = prepared.result()
        levels = np.full(mesh.triangle_count, DEEPEST) if not test else prepared.triangle_levels()
        view = views.setdefault(name, mesh_view(mesh, size=size, up="z"))
        caption = f"{name}, {system}, {words}: {mesh.triangle_count:,} triangles"
        pixels = render(
            mesh,
            camera=view,
            colour=levels,
            colour_range=(0.0, DEEPEST),
            wireframe=True,
            device=device,
        )
        file = f"adaptive_{number}_{system}_{name}.png"
        about = {"series": "adaptive tessellation", "table": group.table}
        yield {"file": file, "caption": caption, **about}, pixels
