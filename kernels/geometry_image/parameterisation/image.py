"""From a mesh to its geometry image: the sphere turned and unfolded, positions and normals sampled on the square."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh
from lodbench.kernels.geometry_image.parameterisation import octahedron, rotation
from lodbench.kernels.geometry_image.parameterisation.cache import (
    cache_path,
    read_arrays,
    write_arrays,
)
from lodbench.kernels.geometry_image.parameterisation.hierarchy import Points
from lodbench.kernels.geometry_image.parameterisation.locate import Locator
from lodbench.kernels.geometry_image.parameterisation.params import Level, Seed, Turn
from lodbench.kernels.geometry_image.parameterisation.spherical import (
    Progress,
    SphericalMap,
    spherical_map,
)
from lodbench.kernels.opencl import Device
from lodbench.kernels.parameters import check


@dataclass(frozen=True, eq=False)
class Made:
    """A geometry image with how it came about; seconds per step, and whether the sphere was read from disk."""

    image: GeometryImage
    spherical: SphericalMap
    rotation: Points
    seconds: dict[str, float]


def resample(
    mesh: TriangleMesh, spherical: SphericalMap, n: int, turn: Points, locator: Locator
) -> GeometryImage:
    """Positions and normals of the mesh at the samples of the (2^n + 1)^2 image.

    Seam duplicates are computed once and copied, so they are equal bit for bit.

    Source: Wang et al., section 2; Praun & Hoppe 2003, section 5.
    """
    side = (1 << n) + 1
    face, weights = locator.image(n, turn)
    corners = spherical.used[spherical.triangles[face]]
    normals = mesh.with_normals().normals
    assert normals is not None
    sampled = []
    for values in (mesh.positions, normals):
        total = np.zeros((side, side, 3))
        for k in range(3):
            total += weights[..., k, None] * values[corners[..., k]]
        sampled.append(total)
    length = np.linalg.norm(sampled[1], axis=-1, keepdims=True)
    unit = np.where(length > 0, sampled[1] / np.where(length > 0, length, 1), (0.0, 0.0, 1.0))
    return GeometryImage(sampled[0].astype(np.float32), unit.astype(np.float32), mesh.origin)


def _best_turn(
    mesh: TriangleMesh, spherical: SphericalMap, locator: Locator, cache: bool
) -> Points:
    """The chosen rotation, from disk where it was chosen before."""
    surface = mesh.positions[spherical.used].astype(np.float64)
    path = cache_path(f"rotation {rotation.METHOD}", spherical.sphere, spherical.triangles, surface)
    kept = read_arrays(path).get("rotation") if cache else None
    if kept is not None and kept.shape == (3, 3):
        return kept
    chosen = rotation.choose(spherical.sphere, surface, spherical.triangles, locator)
    if cache:
        write_arrays(path, rotation=chosen)
    return chosen


def make(
    mesh: TriangleMesh,
    n: int = 8,
    mode: str = "coarse_to_fine",
    seed: int = 0,
    turn: str = "best",
    device: Device | None = None,
    cache: bool = True,
    progress: Progress | None = None,
) -> Made:
    """`geometry_image`, with what was learnt on the way; see there."""
    n, seed = check("n", n, Level), check("seed", seed, Seed)
    check("turn", turn, Turn)
    seconds: dict[str, float] = {}
    start = time.perf_counter()

    def step(name: str) -> None:
        nonlocal start
        now = time.perf_counter()
        seconds[name] = now - start
        start = now

    spherical = spherical_map(mesh, mode, seed, device, cache, progress)
    step("parameterise")
    locator = Locator(spherical.sphere, spherical.triangles)
    chosen = np.eye(3)
    if turn == "best":
        if progress is not None:
            progress("rotation", 0.0, None)
        chosen = _best_turn(mesh, spherical, locator, cache)
    step("rotation")
    if progress is not None:
        progress("resampling", 0.0, None)
    image = resample(mesh, spherical, n, chosen, locator)
    step("resample")
    return Made(image, spherical, chosen, seconds)


def geometry_image(
    mesh: TriangleMesh,
    n: int = 8,
    mode: str = "coarse_to_fine",
    seed: int = 0,
    turn: str = "best",
    device: Device | None = None,
    cache: bool = True,
    progress: Progress | None = None,
) -> GeometryImage:
    """The mesh as a square image of (2^n + 1)^2 samples over an unfolded octahedron.

    Args:
        mesh: one closed, oriented surface of genus 0.
        n: 1 to 11.
        mode: how the mesh is laid out on the sphere: "coarse_to_fine", "cmcf" or "ray".
        seed: of what is random in that.
        turn: "best" tries some rotations of the sphere and keeps the one with the smallest error, "identity" none.
        device: makes the first step several times faster.
        cache: keep the sphere on disk, by the mesh's content and the parameters.
        progress: called with (what, share done, seconds left or None).

    Returns:
        Positions and unit normals, float32; samples of the border that are one point are equal bit for bit.

    Raises:
        NotSpherical: the mesh cannot be laid out on a sphere; the text says what was found.
        NotOneToOne: the mode left triangles turned over.
        ValueError: n, mode or turn out of range.

    Source: Wang et al., section 2; the steps are a reconstruction after Praun & Hoppe 2003.
    """
    return make(mesh, n, mode, seed, turn, device, cache, progress).image


def as_pictures(image: GeometryImage) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Positions, the bounding box scaled to 0..255, and normals as red, green, blue: (side, side, 3) uint8 each.

    Source: Gu, Gortler & Hoppe 2002, figure 1.
    """
    low, high = image.positions.min((0, 1)), image.positions.max((0, 1))
    extent = np.where(high > low, high - low, 1)
    positions = (image.positions - low) / extent
    normals = np.clip(image.normals * 0.5 + 0.5, 0, 1)
    return (positions * 255).round().astype(np.uint8), (normals * 255).round().astype(np.uint8)


def full_mesh(image: GeometryImage, step: int = 1) -> TriangleMesh:
    """All cells of the image, or of every `step`-th sample of it, as two triangles each; seam duplicates welded.

    Args:
        image: (2^n + 1)^2 samples.
        step: a power of two below 2^n: the uniform mip level that many samples apart.
    """
    last = image.positions.shape[0] - 1
    n = last.bit_length() - 1
    if step < 1 or step & (step - 1) or step >= last:
        raise ValueError(f"step: expected a power of two below {last}, got {step}")
    own = octahedron.canonical(n)[::step, ::step]
    p, q, r, s = own[:-1, :-1], own[:-1, 1:], own[1:, 1:], own[1:, :-1]
    cells = last // step
    right = 2 * np.arange(cells) >= cells
    anti = (right[:, None] == right[None, :])[..., None]
    one = np.where(anti, np.stack([p, q, s], -1), np.stack([p, q, r], -1))
    two = np.where(anti, np.stack([q, r, s], -1), np.stack([p, r, s], -1))
    faces = np.stack([one, two], axis=2).reshape(-1, 3)
    used, faces = np.unique(faces, return_inverse=True)
    faces = faces.reshape(-1, 3)
    return TriangleMesh(
        image.positions.reshape(-1, 3)[used],
        faces,
        image.normals.reshape(-1, 3)[used],
        origin=image.origin,
    )
