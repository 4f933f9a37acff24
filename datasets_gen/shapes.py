"""Generated solids that stand in for scans and parts: eared, pierced, with handles, bumpy, sharp, creased."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import distance_transform_edt

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import geodesic_sphere, revolved


def blob_with_ears(segments: int) -> TriangleMesh:
    """A long capsule with two ears, bent into a horseshoe: closed, genus 0, not star-shaped.

    20 * segments^2 triangles. The sphere goes through three maps of space, each one-to-one on it: ears are
    drawn out, the body is stretched, and the long axis is wound round a circle by 230 degrees.
    """
    ball = geodesic_sphere(segments)
    points = ball.positions.astype(np.float64)
    drawn = points.copy()
    for ear in ((0.0, 0.8, 0.6), (0.0, -0.8, 0.6)):
        drawn += 0.9 * np.exp((points @ ear - 1) / 0.06)[:, None] * ear
    x, y, z = (drawn * (0.6, 0.6, 1.8)).T
    radius = 0.9
    angle = z / radius
    bent = np.stack(
        [radius - (radius - x) * np.cos(angle), y, (radius - x) * np.sin(angle)], axis=1
    )
    return TriangleMesh(bent, ball.triangles).with_normals()


def plate(block: int, genus: int, sharp: bool = False) -> TriangleMesh:
    """A plate with `genus` square holes: closed, genus as given; about 32 * block^2 * genus triangles.

    Every hole is `block` quads wide in a frame of `block` quads. Rounded towards all rims, or `sharp`: flat
    faces and right angles, as in a machine part. No holes: one solid square of 3 * block quads a side.
    """
    for argument, value, least in (("block", block, 1), ("genus", genus, 0)):
        if value < least:
            raise ValueError(f"{argument}: expected at least {least}, got {value}")
    columns = int(np.ceil(np.sqrt(max(genus, 1))))
    rows = -(-max(genus, 1) // columns)
    present = np.ones((rows, columns, 3 * block, 3 * block), bool)
    for hole in range(genus):
        row, column = divmod(hole, columns)
        present[row, column, block : 2 * block, block : 2 * block] = False
    present = present.transpose(0, 2, 1, 3).reshape(rows * 3 * block, columns * 3 * block)

    # a grid point is inside where all four quads around it are there
    padded = np.pad(present, 1)
    around = [padded[i : i + len(present) + 1, :][:, j:][:, : present.shape[1] + 1] for i, j in
              ((0, 0), (0, 1), (1, 0), (1, 1))]  # fmt: skip
    used, inside = np.any(around, axis=0), np.all(around, axis=0)
    width = 0.5 * block
    depth = np.clip(np.asarray(distance_transform_edt(inside)) / width, 0, 1)
    rim = 0.25 * block
    height = np.full(depth.shape, 3 * rim) if sharp else rim + width * np.sqrt(depth * (2 - depth))

    number = np.where(used, np.cumsum(used).reshape(used.shape) - 1, 0)
    y, x = np.nonzero(used)
    top = np.stack([x, y, height[used]], axis=1)
    positions = np.concatenate([top, top * (1, 1, -1)]) / (3.0 * block)
    count = len(top)
    q, p = np.nonzero(present)
    a, b, c, d = number[q, p], number[q, p + 1], number[q + 1, p + 1], number[q + 1, p]
    upper = np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)
    lower = upper[:, ::-1] + count
    # a wall stands on each side of a quad that has no neighbour there
    sides = ((a, b, -1, 0), (b, c, 0, 1), (c, d, 1, 0), (d, a, 0, -1))
    alone = [~padded[q + 1 + down, p + 1 + right] for _, _, down, right in sides]
    start = np.concatenate([side[0][mask] for side, mask in zip(sides, alone, strict=True)])
    end = np.concatenate([side[1][mask] for side, mask in zip(sides, alone, strict=True)])
    wall = np.stack([start, start + count, end + count, start, end + count, end], axis=1)
    triangles = np.concatenate([upper, lower, wall.reshape(-1, 3)])
    return TriangleMesh(positions, triangles).with_normals()


def spool(slices: int) -> TriangleMesh:
    """A spool about y, domed at both ends, with tags: its two rims are creases, all else is smooth.

    2 * slices^2 triangles: as many rings as slices, the rims at three and seven tenths of them. A rim's vertices have
    sharpness 1, so that the edges along it crease and no others; tension and bias are 0 everywhere.
    """
    if slices < 6:
        raise ValueError(f"slices: expected at least 6, got {slices}")
    rim = round(0.3 * (slices + 1))
    rings = np.arange(1, slices + 1)
    toward = np.minimum(rings, slices + 1 - rings)  # rings from the nearer pole
    dome = np.minimum(toward / rim, 1.0) * (np.pi / 2)
    waist = np.clip((rings - rim) / (slices + 1 - 2 * rim), 0, 1)
    radius = np.where(toward <= rim, np.sin(dome), 1 - 0.45 * np.sin(np.pi * waist))
    height = np.where(rings <= rim, 1, np.where(slices + 1 - rings <= rim, -1, 0)) * np.cos(dome)
    height = 0.5 * height + 0.55 * (1 - 2 * waist)
    around = 2 * np.pi * np.arange(slices) / slices
    ring = np.stack(
        [
            np.outer(radius, np.sin(around)),
            np.repeat(height[:, None], slices, axis=1),
            np.outer(radius, np.cos(around)),
        ],
        axis=2,
    )
    positions = np.concatenate([[(0, 1.05, 0)], ring.reshape(-1, 3), [(0, -1.05, 0)]])
    tags = np.zeros((len(positions), 3))
    tags[1:-1, 1] = np.repeat(toward == rim, slices)
    return TriangleMesh(positions, revolved(slices, slices), tags=tags).with_normals()


def bumpy(mesh: TriangleMesh, height: float = 0.004, seed: int = 0) -> TriangleMesh:
    """`mesh` displaced along its normals by 24 seeded sines, as rough as a scan; the same triangles.

    `height` is the root mean square of the displacement as a fraction of the box diagonal; wavelengths are
    log-uniform from 1/5 to 1/60 of the diagonal.
    """
    random = np.random.default_rng(seed)
    count = 24
    lengths = mesh.diagonal / np.exp(random.uniform(np.log(5), np.log(60), count))
    directions = random.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    shifts = random.uniform(0, 2 * np.pi, count)
    share = lengths / np.sqrt(0.5 * (lengths**2).sum())
    positions = mesh.positions.astype(np.float64)
    bump = np.zeros(len(positions))
    for length, direction, shift, weight in zip(lengths, directions, shifts, share, strict=True):
        bump += weight * np.sin(positions @ direction * (2 * np.pi / length) + shift)
    smooth = mesh.with_normals().normals
    assert smooth is not None
    moved = positions + (height * mesh.diagonal * bump)[:, None] * smooth
    return TriangleMesh(moved, mesh.triangles, uvs=mesh.uvs).with_normals()


def pierced(mesh: TriangleMesh, holes: int, share: float = 0.01, seed: int = 0) -> TriangleMesh:
    """`mesh` without the triangles around `holes` seeded points far from one another: open borders.

    `share` is the radius of a hole as a fraction of the box diagonal. Vertices left without a triangle go.
    """
    positions = mesh.positions.astype(np.float64)
    first = int(np.random.default_rng(seed).integers(len(positions)))
    nearest = np.linalg.norm(positions - positions[first], axis=1)
    keep = np.ones(mesh.triangle_count, bool)
    for _ in range(holes):
        centre = positions[int(nearest.argmax())]  # farthest from the point before and all holes
        distance = np.linalg.norm(positions - centre, axis=1)
        nearest = np.minimum(nearest, distance)
        keep &= ~(distance < share * mesh.diagonal)[mesh.triangles].any(axis=1)
    return _kept(mesh, keep)


def opened(mesh: TriangleMesh, share: float = 0.2) -> TriangleMesh:
    """`mesh` without the triangles whose corners all lie in the top `share` of its height in z."""
    low, high = mesh.box
    above = mesh.positions[:, 2] > high[2] - share * (high[2] - low[2])
    return _kept(mesh, ~above[mesh.triangles].all(axis=1))


def _kept(mesh: TriangleMesh, keep: np.ndarray) -> TriangleMesh:
    """The triangles of `mesh` where `keep` is set, in order, with the vertices that they use, in order."""
    triangles = mesh.triangles[keep]
    used = np.zeros(mesh.vertex_count, bool)
    used[triangles] = True
    number = np.cumsum(used) - 1
    attributes = (mesh.normals, mesh.uvs, mesh.colours, mesh.tags)
    return TriangleMesh(
        mesh.positions[used],
        number[triangles],
        *(None if values is None else values[used] for values in attributes),
        edge_tags=None if mesh.edge_tags is None else mesh.edge_tags[keep],
    )
