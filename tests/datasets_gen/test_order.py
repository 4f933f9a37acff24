import numpy as np
import pytest

from lodbench.datasets_gen import triangles
from lodbench.datasets_gen.order import morton_codes, spatially_sorted, welded
from lodbench.datasets_gen.surfaces import TriangleMesh
from tests.datasets_gen.topology import soup, topology


def by_row(rows):
    return rows[np.lexsort(rows.T[::-1])]


def test_morton_codes_interleave_the_bits():
    # the box is cut into 2^21 - 1 steps, so these points fall on whole steps
    top = 2**21 - 1
    points = np.array(
        [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (3, 1, 2), (top, top, top)], float
    )
    assert morton_codes(points).tolist() == [0, 1, 2, 4, 0b101011, 2**63 - 1]


@pytest.mark.parametrize("points", [np.zeros((0, 3)), np.ones((4, 3))])
def test_morton_codes_of_a_point_or_none_are_zero(points):
    assert not morton_codes(points).any()


@pytest.mark.parametrize(
    "mesh",
    [triangles.displaced_icosphere(20), triangles.terrain(17), triangles.torus(9, 5)],
    ids=["displaced", "terrain", "torus"],
)
def test_spatially_sorted_is_a_permutation_of_the_same_triangles(mesh):
    result = spatially_sorted(mesh)
    assert np.array_equal(by_row(soup(result)), by_row(soup(mesh)))
    assert topology(result).euler == topology(mesh).euler
    corners = np.column_stack([soup(mesh), mesh.normals[mesh.triangles].reshape(-1, 9)])
    again = np.column_stack([soup(result), result.normals[result.triangles].reshape(-1, 9)])
    assert np.array_equal(by_row(again), by_row(corners))


def test_spatially_sorted_numbers_vertices_by_first_use():
    mesh = spatially_sorted(triangles.displaced_icosphere(20))
    flat = mesh.triangles.ravel().astype(np.int64)
    highest_before = np.maximum.accumulate(np.concatenate([[-1], flat[:-1]]))
    assert (flat <= highest_before + 1).all()


def test_spatially_sorted_brings_neighbours_together():
    mesh = triangles.displaced_icosphere(40)
    random = np.random.default_rng(0)
    shuffled = TriangleMesh(mesh.positions, random.permutation(mesh.triangles))

    def step(m):
        return np.linalg.norm(np.diff(m.positions[m.triangles].mean(1), axis=0), axis=1).mean()

    assert step(spatially_sorted(shuffled)) < 0.1 * step(shuffled)


def test_spatially_sorted_keeps_unused_vertices_at_the_end():
    points = np.array([(9, 9, 9), (0, 0, 0), (1, 0, 0), (0, 1, 0), (8, 8, 8)], float)
    result = spatially_sorted(TriangleMesh(points, np.array([(1, 2, 3)])))
    assert result.triangles.tolist() == [[0, 1, 2]]
    assert result.positions[3:].tolist() == [[9, 9, 9], [8, 8, 8]]


def test_spatially_sorted_takes_the_tags_of_edges_along():
    mesh = triangles.icosphere(1)
    ends = np.stack([mesh.triangles, np.roll(mesh.triangles, -1, axis=1)])
    where = mesh.positions[ends].mean(0)[..., :2]
    result = spatially_sorted(TriangleMesh(mesh.positions, mesh.triangles, edge_tags=where))
    ends = np.stack([result.triangles, np.roll(result.triangles, -1, axis=1)])
    assert np.array_equal(result.edge_tags, result.positions[ends].mean(0)[..., :2])


def test_spatially_sorted_of_nothing_is_nothing():
    empty = TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), np.uint32))
    assert spatially_sorted(empty).vertex_count == 0
    assert welded(empty).vertex_count == 0


def test_welded_joins_a_soup_into_the_mesh_that_it_came_from():
    mesh = triangles.icosphere(2)
    loose = TriangleMesh(
        mesh.positions[mesh.triangles].reshape(-1, 3), np.arange(960).reshape(-1, 3)
    )
    result = welded(loose)
    assert result.vertex_count == mesh.vertex_count
    assert topology(result) == topology(mesh)
    assert np.array_equal(soup(result), soup(mesh))
    # numbered by first use
    assert result.triangles[0].tolist() == [0, 1, 2]


def test_welded_takes_both_zeros_for_one():
    points = np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0), (-0.0, -0.0, 0), (0, 1, 0), (-1, 0, 0)])
    assert welded(TriangleMesh(points, np.arange(6).reshape(2, 3))).vertex_count == 4


def test_triangles_at_one_place_keep_their_order():
    # 5,000 triangles on 4 centroids: too many for a sort that is stable by chance
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)], float)
    points = np.concatenate([corners + np.array([10 * k, 0, 0]) for k in range(4)])
    turn, place = np.arange(5000) % 3, np.arange(5000) % 4
    faces = 3 * place[:, None] + (turn[:, None] + np.arange(3)) % 3
    result = spatially_sorted(TriangleMesh(points, faces))
    came = soup(TriangleMesh(points, faces))
    expected = np.concatenate([came[place == k] for k in range(4)])
    assert np.array_equal(soup(result), expected)
