from fractions import Fraction

import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, torus
from lodbench.kernels.refine.lattice import (
    lattice_interpolation,
    lattice_rows,
    lattice_sharing,
    lattice_triangles,
    lattice_vertex_count,
    lattice_weights,
    refined_mesh,
    welded_mesh,
)

SIZES = (1, 2, 3, 4, 7, 8, 16, 31)


def doubled_area(n):
    """Twice the signed areas of the pattern's triangles in lattice steps, exactly."""
    i, j = lattice_rows(n)
    u, v = (i - j)[lattice_triangles(n)], j[lattice_triangles(n)]
    return (u[:, 1] - u[:, 0]) * (v[:, 2] - v[:, 0]) - (u[:, 2] - u[:, 0]) * (v[:, 1] - v[:, 0])


@pytest.mark.parametrize("n", SIZES)
def test_lattice_has_the_counts_of_the_paper(n):
    assert lattice_vertex_count(n) == len(lattice_weights(n)) == (n + 1) * (n + 2) // 2
    assert len(lattice_triangles(n)) == n * n


def test_lattice_of_eight_is_the_papers_figure_2():
    assert lattice_vertex_count(8) == 45
    assert len(lattice_triangles(8)) == 64


@pytest.mark.parametrize("n", SIZES)
def test_lattice_triangles_tile_the_triangle(n):
    # each is half a unit square, turning like the whole, and together they are the whole: n^2 / 2
    assert (doubled_area(n) == 1).all()
    edges = lattice_triangles(n)[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    assert len(np.unique(edges, axis=0)) == len(edges)  # each directed edge once: nothing overlaps
    undirected, uses = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    assert (uses == 1).sum() == 3 * n
    assert set(uses) <= {1, 2}
    assert len(undirected) == 3 * n * (n + 1) // 2


@pytest.mark.parametrize("n", [1, 2, 4, 8, 64])
def test_lattice_weights_nest_to_the_bit(n):
    coarse = {row.tobytes() for row in lattice_weights(n).astype(np.float32)}
    fine = {row.tobytes() for row in lattice_weights(2 * n).astype(np.float32)}
    assert coarse < fine


def test_lattice_weights_are_quotients_of_integers():
    for row, (i, j) in zip(lattice_weights(7), zip(*lattice_rows(7), strict=True), strict=True):
        exact = [Fraction(int(k), 7) for k in (7 - i, i - j, j)]
        assert sum(exact) == 1
        assert [float(x) for x in exact] == row.tolist()


@pytest.mark.parametrize("n", [1, 2, 3, 8])
@pytest.mark.parametrize("make", [lambda: icosphere(1), lambda: torus(9, 5)], ids=["ball", "torus"])
def test_lattice_sharing_counts_vertices_by_euler(make, n):
    mesh = make()
    euler = mesh.vertex_count - mesh.triangle_count // 2  # V - E + F with E = 3 F / 2
    welded, count = lattice_sharing(mesh.triangles, n)
    assert count == mesh.triangle_count * n * n // 2 + euler
    assert np.array_equal(np.unique(welded), np.arange(count))


@pytest.mark.parametrize("n", [1, 2, 5])
def test_lattice_sharing_agrees_with_equal_positions(n):
    mesh = icosphere(1)
    i, j = lattice_rows(n)
    weights = np.stack([n - i, i - j, j], axis=1)
    # integer coordinates make equality exact
    corners = np.random.default_rng(3).integers(-(1 << 20), 1 << 20, (mesh.vertex_count, 3))
    points = weights @ corners[mesh.triangles]
    welded, count = lattice_sharing(mesh.triangles, n)
    assert len(np.unique(points.reshape(-1, 3), axis=0)) == count
    order = np.argsort(welded.ravel(), kind="stable")
    same = np.diff(welded.ravel()[order]) == 0
    assert (np.diff(points.reshape(-1, 3)[order], axis=0)[same] == 0).all()


def test_welded_mesh_shares_edges_and_keeps_attributes():
    n = 4
    mesh = TriangleMesh(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [9, 9, 9]],
        [[0, 1, 2], [2, 1, 3]],
        colours=np.eye(5, 3),
        uvs=np.zeros((5, 2)),
    )
    weights = lattice_weights(n)
    points = (weights @ mesh.positions[mesh.triangles].astype(float)).reshape(-1, 3)
    refined = refined_mesh(mesh, n, points.astype(np.float32), np.zeros_like(points, np.float32))
    welded = welded_mesh(refined, mesh.triangles, n)
    assert welded.vertex_count == 2 * lattice_vertex_count(n) - (n + 1)  # one edge is shared
    assert welded.triangle_count == 2 * n * n
    assert np.array_equal(welded.positions[:4], mesh.positions[:4])  # coarse vertices in use first
    assert welded.colours is not None
    assert np.array_equal(welded.colours[:4], mesh.colours[:4])  # type: ignore[index]
    assert np.array_equal(welded.positions[welded.triangles], refined.positions[refined.triangles])


def test_lattice_sharing_of_no_triangles_is_empty():
    welded, count = lattice_sharing(np.zeros((0, 3), np.uint32), 4)
    assert welded.shape == (0, 15)
    assert count == 0


@pytest.mark.parametrize("segments, finer", [(1, 1), (1, 6), (2, 6), (3, 12), (5, 5)])
def test_interpolation_gives_each_finer_vertex_its_own_parameters(segments, finer):
    vertices, weights = lattice_interpolation(segments, finer)
    assert (weights >= 0).all() and np.allclose(weights.sum(0), 1)
    there = np.einsum("kn,knd->nd", weights, lattice_weights(segments)[vertices])
    assert np.allclose(there, lattice_weights(finer), atol=1e-15)
