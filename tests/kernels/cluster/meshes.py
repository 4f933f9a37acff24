"""Small meshes whose clustering can be told by hand."""

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh


def _lattice(rows, columns):
    """Two triangles per square of a lattice of (rows + 1) * (columns + 1) vertices."""
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    a = (i * (columns + 1) + j).ravel()
    b, c, d = a + columns + 1, a + columns + 2, a + 1
    return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def single_triangle():
    return TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])


def tetrahedron():
    return TriangleMesh(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    )


def flat_lattice(n):
    """A square of n * n squares in z = 0, sides n."""
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0), indexing="ij")
    return TriangleMesh(np.stack([x, y, 0 * x], -1).reshape(-1, 3), _lattice(n, n))


def nine_point_plane():
    return flat_lattice(2)


def wavy_sheet(n=40):
    """An open sheet of 2 n^2 triangles with hills, so that every kind of cell occurs."""
    x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    z = 0.1 * np.sin(9 * x) * np.cos(7 * y) + 0.2 * np.abs(x - 0.5)
    return TriangleMesh(np.stack([x, y, z], -1).reshape(-1, 3), _lattice(n, n))


def cube(n=4):
    """The unit cube's surface, n * n squares a side, not welded."""
    x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    face = np.stack([x, y, 0 * x], -1).reshape(-1, 3)
    positions, triangles = [], []
    for axis in range(3):
        for side in (0.0, 1.0):
            triangles.append(_lattice(n, n) + len(positions) * len(face))
            positions.append(np.roll(face + np.array([0, 0, side]), axis, axis=1))
    return TriangleMesh(np.concatenate(positions), np.concatenate(triangles))


def sphere(rows=12, columns=18):
    """A closed unit sphere: 2 * columns * (rows - 1) triangles."""
    polar = np.linspace(0, np.pi, rows + 1)[1:-1]
    around = np.arange(columns) * 2 * np.pi / columns
    z = np.outer(np.cos(polar), np.ones(columns))
    x, y = np.outer(np.sin(polar), np.cos(around)), np.outer(np.sin(polar), np.sin(around))
    ring = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(rows - 2), np.arange(columns), indexing="ij")
    a, b = (i * columns + j).ravel(), (i * columns + (j + 1) % columns).ravel()
    c, top, bottom = np.arange(columns), len(ring), len(ring) + 1
    d = (c + 1) % columns
    last = (rows - 2) * columns
    triangles = [
        np.stack([a, a + columns, b], 1),
        np.stack([b, a + columns, b + columns], 1),
        np.stack([np.full(columns, top), c, d], 1),
        np.stack([np.full(columns, bottom), last + d, last + c], 1),
    ]
    return TriangleMesh(np.concatenate([ring, [[0, 0, 1], [0, 0, -1]]]), np.concatenate(triangles))
