import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.measure import quality
from lodbench.harness.measure.quality import distance_from, measure, topology
from lodbench.kernels.opencl.device import Unsupported

TETRAHEDRON = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], np.float32)
ZERO = {
    "open_edges": 0, "nonmanifold_edges": 0, "flipped_edges": 0, "components": 0, "euler": 0,
    "duplicate_triangles": 0, "degenerate_triangles": 0,
}  # fmt: skip


def square(height=0.0, side=1.0, cells=4):
    x, y = np.meshgrid(np.linspace(0, side, cells + 1), np.linspace(0, side, cells + 1))
    positions = np.stack([x.ravel(), y.ravel(), np.full(x.size, height)], axis=1)
    row = cells + 1
    a = (np.arange(cells)[:, None] * row + np.arange(cells)).ravel()
    triangles = np.concatenate(
        [
            np.stack([a, a + 1, a + row + 1], axis=1),
            np.stack([a, a + row + 1, a + row], axis=1),
        ]
    )
    return TriangleMesh(positions, triangles)


def moved(mesh, scale=1.0, offset=0.0):
    return TriangleMesh(mesh.positions.astype(np.float64) * scale + offset, mesh.triangles)


def changed(mesh, rows, values):
    triangles = mesh.triangles.copy()
    triangles[rows] = values
    return TriangleMesh(mesh.positions, triangles)


def test_measure_of_a_mesh_with_itself_is_zero():
    figures = measure(square(), square(), samples=1000)
    # a sample is rebuilt from three corners in float64
    assert figures["rms_error"] < 1e-15
    assert figures["max_error"] < 1e-15
    assert figures["flipped_triangles"] == 0
    assert figures["error_samples"] == 1000
    assert figures.items() >= topology(square()).items()


def test_triangle_without_area_is_not_turned_over():
    flat = square()
    needle = changed(flat, 5, flat.triangles[5, [0, 1, 1]])
    assert measure(flat, needle, samples=1000)["flipped_triangles"] == 0
    turned = changed(needle, 7, needle.triangles[7, ::-1])
    assert measure(flat, turned, samples=1000)["flipped_triangles"] == 1


def test_measure_of_parallel_planes_is_their_distance_over_the_diagonal():
    figures = measure(square(), square(height=0.25), samples=1000)
    expected = 0.25 / np.sqrt(2)
    for key in ("rms_error", "rms_error_back", "max_error"):
        assert figures[key] == pytest.approx(expected, rel=1e-6)


def test_measure_tells_the_two_directions_apart():
    # half the square is missing: its far edge is 0.5 away; from the half to the whole there is no distance
    half = TriangleMesh([[0, 0, 0], [0.5, 0, 0], [0.5, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    figures = measure(square(), half, samples=200_000)
    assert figures["rms_error_back"] < 1e-15
    assert figures["max_error"] == pytest.approx(0.5 / np.sqrt(2), rel=1e-6)
    # mean of squares: half the area at 0, half spread over 0..0.5, so sqrt(1/2 * 0.5^2 / 3); 200,000 samples give 1 %
    assert figures["rms_error"] == pytest.approx(np.sqrt(0.125 / 3) / np.sqrt(2), rel=0.01)


def test_measure_tests_vertices_that_samples_miss():
    spike = square(cells=40)
    positions = spike.positions.copy()
    positions[820, 2] = 0.5  # one vertex of 1,681
    figures = measure(TriangleMesh(positions, spike.triangles), square(cells=40), samples=10)
    assert figures["max_error"] == pytest.approx(0.5 / 1.5, rel=1e-6)


def test_measure_is_the_same_twice_and_differs_with_the_seed():
    first, again, other = (
        measure(square(), square(side=0.7), seed, samples=500) for seed in (3, 3, 4)
    )
    assert first == again
    assert first["rms_error"] != other["rms_error"]


@pytest.mark.parametrize("scale", [1e-20, 1e-3, 1e20])
def test_measure_does_not_depend_on_scale(scale):
    there, here = square(), square(height=0.1, side=0.9)
    plain = measure(there, here, samples=1000)
    scaled = measure(moved(there, scale), moved(here, scale), samples=1000)
    for key in ("rms_error", "rms_error_back", "max_error"):
        assert scaled[key] == pytest.approx(plain[key], rel=1e-5)


def test_measure_works_far_from_the_origin():
    # at 2^20 a float32 step is 1/8, and quarters are exact
    there, here = square(side=64, cells=8), square(height=4, side=64, cells=8)
    plain = measure(there, here, samples=1000)
    far = measure(moved(there, offset=2.0**20), moved(here, offset=2.0**20), samples=1000)
    assert far["rms_error"] == pytest.approx(plain["rms_error"], rel=1e-9)


def test_measure_of_empty_meshes():
    empty = TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int))
    assert measure(empty, empty)["rms_error"] == 0
    assert measure(square(), empty)["rms_error"] is None
    assert measure(empty, square())["max_error"] is None


def test_measure_of_triangles_without_area_is_finite():
    point = TriangleMesh(np.ones((3, 3)), [[0, 1, 2]])
    line = TriangleMesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2], [0, 0, 1]])
    for there in (point, line, square()):
        for here in (point, line):
            figures = measure(there, here, samples=100)
            assert np.isfinite(figures["rms_error"])
            assert np.isfinite(figures["max_error"])


def test_measure_counts_turned_triangles():
    mesh = square()
    turned = changed(mesh, [0, 5], mesh.triangles[[0, 5]][:, ::-1])
    assert measure(mesh, turned, samples=100)["flipped_triangles"] == 2
    assert measure(turned, turned, samples=100)["flipped_triangles"] == 0


def test_measure_refuses_no_samples():
    with pytest.raises(ValueError, match="samples: expected at least 1, got 0"):
        measure(square(), square(), samples=0)


def test_measure_says_what_to_install(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "igl", None)
    quality._located.cache_clear()
    with pytest.raises(Unsupported, match=r"pip install 'lodbench\[report\]'"):
        measure(square(), square())


def test_topology_of_a_closed_tetrahedron():
    assert topology(TriangleMesh(CORNERS, TETRAHEDRON)) == ZERO | {"components": 1, "euler": 2}


def test_topology_finds_the_hole_where_a_triangle_is_missing():
    found = topology(TriangleMesh(CORNERS, TETRAHEDRON[:3]))
    assert found == ZERO | {"open_edges": 3, "components": 1, "euler": 1}


def test_topology_finds_a_turned_face():
    mesh = TriangleMesh(CORNERS, TETRAHEDRON)
    found = topology(changed(mesh, 2, mesh.triangles[2][::-1]))
    assert found == ZERO | {"flipped_edges": 3, "components": 1, "euler": 2}


def test_topology_of_a_bow_tie_is_one_part_with_open_edges():
    positions = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [-1, 0, 0], [-1, -1, 0]]
    found = topology(TriangleMesh(positions, [[0, 1, 2], [0, 3, 4]]))
    assert found == ZERO | {"open_edges": 6, "components": 1, "euler": 5 - 6 + 2}


def test_topology_finds_an_edge_of_three_pages():
    positions = [[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0]]
    found = topology(TriangleMesh(positions, [[0, 1, 2], [0, 1, 3], [0, 1, 4]]))
    assert found == ZERO | {
        "open_edges": 6, "nonmanifold_edges": 1, "components": 1, "euler": 5 - 7 + 3,
    }  # fmt: skip


def test_topology_counts_copies_in_any_order():
    mesh = TriangleMesh(CORNERS, [*TETRAHEDRON, [2, 1, 0], [1, 0, 2], [0, 1, 3]])
    assert topology(mesh)["duplicate_triangles"] == 3


def test_topology_counts_triangles_without_area_and_ignores_loose_vertices():
    positions = [*CORNERS, [0.5, 0, 0], [9, 9, 9]]
    mesh = TriangleMesh(positions, [*TETRAHEDRON, [0, 0, 1], [2, 2, 2], [0, 1, 4]])
    found = topology(mesh)
    assert found["degenerate_triangles"] == 3
    assert found["components"] == 1


def test_topology_counts_parts():
    twice = TriangleMesh(
        np.concatenate([CORNERS, CORNERS + 5]),
        TETRAHEDRON + [[4 + i for i in t] for t in TETRAHEDRON],
    )
    assert topology(twice) == ZERO | {"components": 2, "euler": 4}


@pytest.mark.parametrize("triangles", [np.zeros((0, 3), int), np.zeros((2, 3), int)])
def test_topology_of_nothing_is_nothing(triangles):
    found = topology(TriangleMesh(CORNERS, triangles))
    assert found == ZERO | {"degenerate_triangles": len(triangles)}


def test_topology_works_with_the_largest_indices():
    # keys hold two 31-bit indices and a bit; the copy test must not lose the third index either
    count = 1 << 21
    positions = np.zeros((count, 3), np.float32)
    positions[-4:] = CORNERS
    mesh = TriangleMesh(positions, np.array(TETRAHEDRON) + count - 4)
    assert topology(mesh) == ZERO | {"components": 1, "euler": 2}


@pytest.mark.parametrize("scale", [1e-30, 1e-20, 1e20, 3e37])
def test_topology_finds_slivers_at_any_scale(scale):
    assert topology(moved(square(), scale))["degenerate_triangles"] == 0
    flat = TriangleMesh(np.array([[0, 0, 0], [1, 1, 0], [2, 2, 0]]) * scale, [[0, 1, 2]])
    assert topology(flat)["degenerate_triangles"] == 1


def test_distance_from_a_finer_surface_is_that_of_its_vertices():
    coarse, fine = icosphere(2), icosphere(5)
    found = distance_from(fine, coarse, coarse.diagonal)
    radii = np.linalg.norm(coarse.positions[coarse.triangles].mean(1), axis=1)
    assert found["compared_points"] == fine.vertex_count
    assert (
        0.9 * (1 - radii.min())
        < found["max_difference"] * coarse.diagonal
        < 1.1 * (1 - radii.min())
    )
    assert 0 < found["mean_difference"] < found["rms_difference"] < found["max_difference"]
    assert distance_from(fine, fine, 1.0)["max_difference"] < 1e-7
    with pytest.raises(ValueError, match="result: expected triangles to compare, got none"):
        distance_from(fine, TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int)), 1.0)


def test_mean_distance_counts_a_vertex_by_the_area_around_it():
    x = np.array([0.0, 1, 2, 3, 4])  # a strip whose last two squares stand one above the coarse one
    upper = np.stack([x, 0 * x, np.where(x > 1, 1.0, 0)], axis=1)
    points = np.concatenate([upper, upper + np.array([0, 1, 0])])
    a = np.arange(4)
    faces = np.concatenate([np.stack([a, a + 1, a + 6], 1), np.stack([a, a + 6, a + 5], 1)])
    flat = TriangleMesh([[-1, -1, 0], [9, -1, 0], [-1, 9, 0]], [[0, 1, 2]])
    found = distance_from(TriangleMesh(points, faces), flat, 1.0)
    slope = np.sqrt(2)
    assert found["mean_difference"] == pytest.approx((slope / 2 + 2) / (1 + slope + 2))
