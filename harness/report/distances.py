"""Pictures of a geometry image drawn for viewers farther and farther away: Wang et al., figures 5 and 6."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.geometry_image.parameterisation import as_pictures
from lodbench.kernels.geometry_image.quadtree_lod import Params
from lodbench.kernels.geometry_image.quadtree_lod.host import QuadtreeLod, prepare
from lodbench.kernels.geometry_image.quadtree_lod.reference import DRAWN
from lodbench.kernels.opencl import Device, Unsupported
from lodbench.kernels.render import render
from lodbench.kernels.system import Frame, View, run

DRAWN_FROM = "quadtree_lod"  # the system that these pictures are about
DISTANCES = (1, 2, 4, 8)  # times that from which the whole fits the picture
LEAST_SIDE = 512  # pixels of the geometry image's picture


def farther(view: View, centre: NDArray[np.float64], times: float) -> View:
    """The same view from so many times the distance to `centre`."""
    eye = centre + times * (view.eye - centre)
    moved = np.eye(4)
    moved[:3, 3] = view.eye - eye
    return replace(view, eye=eye, world_to_clip=view.world_to_clip @ moved)


def nodes_picture(prepared: QuadtreeLod) -> NDArray[np.uint8]:
    """The geometry image with each drawn node in one colour, its centre's position: square, (pixels, pixels, 3) uint8.

    Source: Wang et al., figure 5.
    """
    assert prepared.image is not None
    colours, _ = as_pictures(prepared.image)
    side = colours.shape[0] - 1
    picture = np.zeros((side, side, 3), np.uint8)
    for depth, level in enumerate(prepared.states):
        size = side >> depth
        centres = colours[size // 2 :: size, size // 2 :: size][: 1 << depth, : 1 << depth]
        drawn = np.repeat(np.repeat(level == DRAWN, size, axis=0), size, axis=1)
        blocks = np.repeat(np.repeat(centres, size, axis=0), size, axis=1)
        picture[drawn] = blocks[drawn]
    scale = max(LEAST_SIDE // side, 1)
    # rows of the image run upwards, those of a picture downwards
    return np.repeat(np.repeat(picture[::-1], scale, axis=0), scale, axis=1)


def distance_pictures(
    name: str, mesh: TriangleMesh, measured: View, seen: View, device: Device, table: str = ""
) -> Iterator[tuple[dict[str, Any], NDArray[np.uint8]]]:
    """The nodes drawn for each distance, and the surface that they make, from near by.

    Args:
        name: of the dataset.
        mesh: its surface; no pictures where it is not closed or not of genus 0.
        measured: the view that the tolerance of one pixel counts in; moved away for each distance.
        seen: the view of the pictures.
        device: what draws.
        table: that the pictures belong to.

    Yields:
        `file`, `caption` and `series`, and the pixels.
    """
    try:
        prepared = prepare(device, mesh, Params(pixels=1.0))
    except Unsupported:
        return
    if prepared.image is None:
        return
    centre = (prepared.tree.low + prepared.tree.high) / 2
    for number, times in enumerate(DISTANCES):
        run(device, prepared, Frame(farther(measured, centre, times)))
        surface = prepared.result()[0]
        far = "from where all of it is seen" if times == 1 else f"from {times} times as far"
        caption = f"{name} {far}: {surface.triangle_count:,} triangles"
        shown = {"caption": caption, "series": "distances", "table": table}
        nodes = {**shown, "caption": f"{caption}, their nodes"}
        yield {**nodes, "file": f"distance_{number}_nodes_{name}.png"}, nodes_picture(prepared)
        yield (
            {**shown, "file": f"distance_{number}_{name}.png"},
            render(surface, camera=seen, colour="flat", device=device),
        )
