"""The whole set-up as a subject: a mesh laid out on the sphere, turned, unfolded and sampled.

Its output is the full image's surface, so a table can put time, turned-over triangles, area distortion and error of
the three ways to the sphere side by side. A way that fails is skipped with the reason.

Source: Wang et al., section 2 (`ray`); Kazhdan, Solomon & Ben-Chen 2012 (`cmcf`); Praun & Hoppe 2003
(`coarse_to_fine`, a reconstruction).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.kernels.geometry_image.parameterisation import (
    Level,
    Made,
    Mode,
    Seed,
    Turn,
    full_mesh,
    make,
)
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.parameters import Parameters
from lodbench.kernels.system import Check

LEAST_SHARE = 0.01  # of the surface: the quantile of relative area that is reported


@dataclass(frozen=True)
class Params(Parameters):
    """What is made, and how.

    Attributes:
        n: (2^n + 1)^2 samples, 1 to 11.
        mode: "coarse_to_fine", "cmcf" or "ray".
        seed: of what is random in it.
        turn: "best" or "identity".
        cache: take the sphere from disk, where `prepare` sees to it that it is; False makes it each time.
    """

    n: Level = 8
    mode: Mode = "coarse_to_fine"
    seed: Seed = 0
    turn: Turn = "best"
    cache: bool = False


def relative_areas(mesh: TriangleMesh, made: Made) -> tuple[np.ndarray, np.ndarray]:
    """Each triangle's share of the sphere over its share of the surface, and the latter."""
    triangles, sphere = made.spherical.triangles, made.spherical.sphere
    a, b, c = (sphere[triangles[:, k]] for k in range(3))
    # small triangles: the flat area is the spherical one to a part in a thousand where it matters
    on_sphere = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    surface = mesh.positions[made.spherical.used].astype(np.float64)
    p, q, r = (surface[triangles[:, k]] for k in range(3))
    in_space = np.linalg.norm(np.cross(q - p, r - p), axis=1)
    share = in_space / in_space.sum()
    keep = share > 0
    return on_sphere[keep] / on_sphere.sum() / share[keep], share[keep]


def _count(mesh: TriangleMesh, made: Made | None) -> Mapping[str, int | float]:
    if made is None:
        return {}
    relative, share = relative_areas(mesh, made)
    order = np.argsort(relative)
    least = np.searchsorted(np.cumsum(share[order]), LEAST_SHARE)
    return {
        "flipped": made.spherical.flipped,
        "flipped_before_repair": made.spherical.repaired,
        "degree": made.spherical.degree,
        "area_min": float(relative.min()),
        "area_max": float(relative.max()),
        "area_least_hundredth": float(relative[order[min(least, len(order) - 1)]]),
        **{f"{step}_s": seconds for step, seconds in made.seconds.items()},
    }


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> HostPrepared:
    """The mesh as it is: everything happens in the call, the star optimisation on the device.

    Raises:
        NotSpherical: a sphere is to be kept and there is none, as the mesh is not one closed surface of genus 0.
    """
    setup = Timeline()
    empty = TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int))
    last: list[Made | None] = [None]

    def call(_) -> Made | None:
        if not mesh.triangle_count:
            return None
        last[0] = make(mesh, params.n, params.mode, params.seed, params.turn, device, params.cache)
        return last[0]

    if params.cache:
        with setup.host("fill_cache"):
            call(None)

    def verdict(_) -> Check:
        made = last[0]
        off = abs(made.spherical.degree - 1) + made.spherical.flipped if made else 0.0
        return Check(off < 1e-6, "triangles turned over, and degree off 1", off, 1e-6)

    return HostPrepared(
        device,
        call,
        read=lambda made: [full_mesh(made.image) if made else empty],
        verdict=verdict,
        setup=setup,
        input_bytes=mesh.positions.nbytes + mesh.triangles.nbytes,
        count=lambda made: _count(mesh, made),
    )


SYSTEM = host_system(
    "make_geometry_image",
    "Wang, Liu, Feng & Li, section 2; Praun & Hoppe 2003; Kazhdan, Solomon & Ben-Chen 2012",
    prepare,
    {"coarse_to_fine": Params(n=5), "cmcf": Params(n=5, mode="cmcf")},
)
