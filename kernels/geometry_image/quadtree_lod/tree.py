"""A geometry image on the device with its quadtree: errors and bounds of all nodes, packed in one texture."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.arrays import box
from lodbench.datasets_gen.surfaces import GeometryImage
from lodbench.kernels.geometry_image.quadtree_lod import reference
from lodbench.kernels.geometry_image.quadtree_lod.fit import pyramid, sample_areas
from lodbench.kernels.opencl import Device, Timeline

FOLDER = "geometry_image/quadtree_lod"


def unit_scale(diagonal: float) -> float:
    """The power of two that brings a model of this bounding-box diagonal near 1, exact in float32."""
    return math.ldexp(1.0, max(-126, min(126, -math.frexp(diagonal)[1]))) if diagonal > 0 else 1.0


class Tree:
    """Uploads the image and makes the tree, level by level, finest first.

    Errors and bounds are in model units times `scale`, a power of two that brings the model near 1: squares of
    distances neither over- nor underflow, and a model of any size has the same nodes.

    ```
    positions, normals  float  [3 * side * side]   the image's samples, row by row, side = 2^n + 1
    errors              float  [texels]            figure 3's layout: see common/quadtree.cl
    bounds              float  [4 * texels / 3]    its upper part in planes: x, y, z, radius
    levels              float  [3 * ...]           where the vertices of depth 0 to n - 1 lie, one level after the other
    ```
    """

    def __init__(
        self,
        device: Device,
        image: GeometryImage,
        placement: str,
        error_metric: str,
        setup: Timeline,
    ) -> None:
        self._device, self.image = device, image
        self.side = image.positions.shape[0]
        self.n = (self.side - 1).bit_length() - 1
        self.texels = 3 << (2 * self.n - 1)
        flat = image.positions.reshape(-1, 3)
        self.low, self.high = box(flat)
        self.diagonal = float(np.linalg.norm(self.high - self.low))
        self.scale = unit_scale(self.diagonal)
        with setup.host("upload"):
            self.positions = device.upload("image", flat)
            self.normals = device.upload("image_normals", image.normals.reshape(-1, 3))
        with setup.host("fit" if placement == "fitted" else "quadtree"):
            self.places = pyramid(image, placement)
        with setup.host("quadtree"):
            rows = np.concatenate([level.reshape(-1, 3) for level in self.places[:-1]])
            self.levels = device.upload("levels", rows)
            samples = image.positions.astype(np.float64) * self.scale
            area = sample_areas(samples).sum() if error_metric == "rms_share" else 0
            # seam duplicates are counted at both ends of a fold, where each has half its area
            self.per_area = 1 / area if area else 0.0
            self.errors = device.allocate("errors", self.texels, np.float32)
            self.bounds = device.allocate("bounds", (4, self.texels // 3), np.float32)
            self._make()
            device.wait()

    def _make(self) -> None:
        device, none = self._device, Timeline()
        device.fill(none, "quadtree", self.errors, 0)
        device.fill(none, "quadtree", self.bounds, 0)
        program = device.build(f"{FOLDER}/setup.cl")
        scaled = self.scaled_places()
        samples = device.upload("samples", scaled[-1].reshape(-1, 3))
        for depth in reversed(range(self.n)):
            shared: dict[str, Any] = {
                "positions": samples, "depth": depth, "n": self.n, "node_count": 4**depth,
                "stage": "quadtree",
                "local": 1 if depth < 4 else None,  # few nodes with many samples each: one per group
            }  # fmt: skip
            corners = device.upload("corners", scaled[depth].reshape(-1, 3))
            program.launch(
                "quadtree_lod_setup_error", 4**depth, corners=corners, errors=self.errors,
                per_area=self.per_area, **shared,
            )(none)  # fmt: skip
            program.launch("quadtree_lod_setup_bound", 4**depth, bounds=self.bounds, **shared)(none)

    def scaled_places(self) -> list[NDArray[np.float32]]:
        """Per depth, 0 to n, where a level's vertices lie, model units times `scale`."""
        return [level * np.float32(self.scale) for level in self.places]

    def read_errors(self) -> list[NDArray[np.float32]]:
        """Per depth, 0 to n, the nodes' errors, (2^d, 2^d), row y, column x; model units times `scale`."""
        return reference.unpack(self._device.read(self.errors), self.n)

    def read_bounds(self) -> list[NDArray[np.float32]]:
        """Per depth, 0 to n - 1, centre and radius of each node's sphere, (2^d, 2^d, 4); the same units."""
        return reference.unpack_upper(self._device.read(self.bounds).T, self.n)
