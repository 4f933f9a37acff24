"""A closed genus-0 mesh on the unit sphere: the three modes, what is accepted, and the cache on disk."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.geometry_image.parameterisation import accept, embedding, laplacian, stars
from lodbench.kernels.geometry_image.parameterisation.cache import (
    cache_path,
    read_arrays,
    write_arrays,
)
from lodbench.kernels.geometry_image.parameterisation.checks import require_sphere
from lodbench.kernels.geometry_image.parameterisation.device_stars import DeviceSweep
from lodbench.kernels.geometry_image.parameterisation.hierarchy import Faces, Points
from lodbench.kernels.geometry_image.parameterisation.params import MODES, Mode
from lodbench.kernels.opencl import Device, Unsupported
from lodbench.kernels.parameters import check

METHOD = 1  # part of the cache's key: another number for another way of computing

Progress = Callable[[str, float, "float | None"], None]
"""(what is being done, share done 0..1, seconds left or None)."""


class NotOneToOne(Unsupported):
    """The mode left triangles turned over; another mode, or seed, may not."""


@dataclass(frozen=True)
class SphericalMap:
    """A mesh and its one-to-one image on the unit sphere.

    ```
    sphere     (n, 3) float64   unit length, one per vertex in use
    triangles  (m, 3) int64     rows of `sphere` and of `used`
    used       (n,)   int64     the mesh's vertices that a triangle names
    ```
    Attributes:
        mode: how it was made.
        seed: of what is random in it.
        repaired: triangles that were turned over before the repair; always 0 for `coarse_to_fine`.
        seconds: what making it took; of the first time where it came from the cache.
        from_cache: read from disk.
    """

    sphere: Points
    triangles: Faces
    used: NDArray[np.int64]
    mode: str
    seed: int
    repaired: int
    seconds: float
    from_cache: bool

    @property
    def flipped(self) -> int:
        return len(accept.flipped(self.sphere, self.triangles))

    @property
    def degree(self) -> float:
        return accept.degree(self.sphere, self.triangles)


class _Clock:
    """Turns shares of the work into seconds left."""

    def __init__(self, progress: Progress | None, what: str) -> None:
        self._progress, self._what, self._start = progress, what, time.perf_counter()

    def __call__(self, share: float) -> None:
        if self._progress is not None:
            spent = time.perf_counter() - self._start
            left = spent * (1 - share) / share if share > 0.02 else None
            self._progress(self._what, min(share, 1.0), left)


def spherical_map(
    mesh: TriangleMesh,
    mode: str = "coarse_to_fine",
    seed: int = 0,
    device: Device | None = None,
    cache: bool = True,
    progress: Progress | None = None,
) -> SphericalMap:
    """Each vertex's place on the unit sphere; accepted only where no triangle is turned over and the degree is 1.

    Args:
        mesh: one closed, oriented surface of genus 0.
        mode: "coarse_to_fine"; or, for comparison, "cmcf" (conformalised mean curvature flow) or "ray" (the paper's
            rays from the centre), both with repair.
        seed: of the order of collapses and the colourings; the comparison modes have nothing random.
        device: moves the vertices in `coarse_to_fine` if it has float64; None: the host does, several times slower.
        cache: look on disk first, and write what was made there.
        progress: called now and then with what is done, the share done, and the seconds left.

    Raises:
        NotSpherical: the mesh is open, not manifold, in several pieces, of another genus, or without area.
        NotOneToOne: the mode failed.
        ValueError: no such mode.

    Source: Praun & Hoppe 2003 (`coarse_to_fine`, a reconstruction); Kazhdan, Solomon & Ben-Chen 2012 (`cmcf`);
    Wang et al., section 2 (`ray`).
    """
    check("mode", mode, Mode)
    surface, triangles, used = require_sphere(mesh)
    on_device = mode == MODES[0] and device is not None and DeviceSweep.possible(device)
    maker = device.facts.driver if on_device and device is not None else "host"
    path = cache_path(f"{METHOD}|{mode}|{seed}|{maker}", mesh.positions, mesh.triangles)
    if cache:
        try:
            held = read_arrays(path)
            kept = SphericalMap(
                np.asarray(held["sphere"], np.float64), triangles, used, mode, seed,
                int(held["repaired"]), float(held["seconds"]), True,
            )  # fmt: skip
            if kept.sphere.shape == surface.shape and not kept.flipped:
                return kept
        except KeyError:
            pass
    clock = _Clock(progress, "parameterisation")
    start = time.perf_counter()
    repaired = 0
    if mode == "coarse_to_fine":
        sweep = DeviceSweep(device) if on_device and device is not None else stars.sweep
        sphere = embedding.coarse_to_fine(surface, triangles, seed, sweep, clock)
    else:
        if mode == "cmcf":
            sphere = laplacian.curvature_flow(surface, triangles, clock)
            free = np.zeros(len(sphere), bool)
        else:
            sphere, free = laplacian.centre_rays(surface, triangles)
        repaired = len(accept.flipped(sphere, triangles))
        sphere, _ = laplacian.repair(sphere, triangles, free)
    made = SphericalMap(
        sphere, triangles, used, mode, seed, repaired, time.perf_counter() - start, False
    )
    flips, degree = made.flipped, made.degree
    if flips or abs(degree - 1) > accept.AREA_TOLERANCE:
        raise NotOneToOne(
            f"needs a one-to-one map onto the sphere, {mode} left {flips} of {len(triangles)} triangles "
            f"turned over ({repaired} before repair) and covers the sphere {degree:.6g} times"
        )
    if cache:
        write_arrays(path, sphere=sphere, repaired=repaired, seconds=made.seconds)
    return made
