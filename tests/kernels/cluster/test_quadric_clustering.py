import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.quadric_clustering import Params
from lodbench.kernels.cluster.quadric_clustering import simplify as simplify_to
from lodbench.kernels.cluster.quadric_clustering.host import prepare
from lodbench.kernels.cluster.quadric_clustering.reference import KINDS, NO_VERTEX, simplify
from lodbench.kernels.cluster.quadric_clustering.verdict import verdict
from lodbench.kernels.cluster.survivors import FILE
from lodbench.kernels.cluster.unchanged import without_duplicates
from lodbench.kernels.opencl.device import Device, Unsupported
from lodbench.kernels.opencl.timeline import Timeline
from lodbench.kernels.system import run
from tests.kernels.cluster.meshes import (
    cube,
    flat_lattice,
    nine_point_plane,
    single_triangle,
    sphere,
    tetrahedron,
    wavy_sheet,
)
from tests.tolerances import CLUSTER_PLANE, CLUSTER_RIDGE, ROUNDING32

WAYS = {
    "fused": {},
    "separate": {"strategy": "separate"},
    "slabs": {"accumulate": "slabs", "slabs": 5},
    "fixed_point": {"accumulate": "fixed_point"},
}
PLACEMENTS = ("robust", "paper", "average")
EMPTY = TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int))


def cluster(device, mesh, **params):
    prepared = prepare(device, mesh, Params(**params))
    run(device, prepared)
    return prepared


def outcome(prepared):
    (mesh,) = prepared.result()
    return mesh.positions.tobytes(), mesh.triangles.tobytes()


def shuffled(mesh, seed):
    order = np.random.default_rng(seed).permutation(mesh.triangle_count)
    return TriangleMesh(mesh.positions, mesh.triangles[order]), order


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("placement", PLACEMENTS)
@pytest.mark.parametrize("cells", [1, 2, 5, 23.7, (4, 9, 2)])
@pytest.mark.parametrize(
    "make", [nine_point_plane, tetrahedron, single_triangle, cube, sphere, wavy_sheet]
)
def test_quadric_clustering_agrees_with_reference(device, make, cells, placement, way):
    prepared = cluster(device, make(), cells=cells, placement=placement, **WAYS[way])
    check = prepared.check()
    assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"


def test_quadric_clustering_counts_agree_with_reference(device):
    prepared = cluster(device, sphere(), cells=9)
    reference = simplify(sphere(), prepared.params)
    counters = prepared.counters()
    assert counters["triangles_in"] == sphere().triangle_count
    assert counters["vertices"] == reference.mesh.vertex_count
    assert counters["triangles"] == reference.mesh.triangle_count
    assert counters["vertices"] <= counters["cells_occupied"] <= counters["cells"]
    placed = [counters[f"placed_{kind}"] for kind in KINDS]
    assert placed == np.bincount(reference.kinds, minlength=len(KINDS)).tolist()
    assert sum(placed) == counters["vertices"]


@pytest.mark.parametrize("way", WAYS)
def test_quadric_clustering_vertex_map_agrees_with_reference(device, way):
    # a vertex that no triangle uses maps to its cell's vertex where the cell has one
    mesh = sphere()
    lonely = np.concatenate([mesh.positions, [[0, 0, 0], mesh.positions[3]]])
    mesh = TriangleMesh(lonely, mesh.triangles)
    prepared = cluster(device, mesh, cells=7, **WAYS[way])
    expected = simplify(mesh, prepared.params).vertex_map
    assert np.array_equal(prepared.vertex_map(), expected)
    assert expected[-2] == NO_VERTEX
    prepared.map_vertices()  # a frame's own step, read with its counts
    for _ in range(2):
        run(device, prepared, wait=prepared.live)
        assert np.array_equal(prepared.read_back()[1], expected)


@pytest.mark.parametrize("way", WAYS)
def test_quadric_clustering_reference_sums_keep_area_and_corners(device, way):
    # each triangle gives a third of its area to each corner's cell, whose A has that trace
    mesh = sphere()
    reference = simplify(mesh, Params(64))  # every vertex its own cell: every cell is used
    p = reference.grid.points(mesh.positions).astype(np.float64)[mesh.triangles]
    area = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum() / 2
    assert np.trace(reference.A, axis1=1, axis2=2).sum() == pytest.approx(area)


def test_quadric_clustering_minimum_is_stationary_and_no_worse_than_mean():
    reference = simplify(wavy_sheet(), Params(8))
    solved = reference.kinds == KINDS.index("solved")
    assert solved.any()
    A, b, trace = reference.A, reference.b, np.trace(reference.A, axis1=1, axis2=2)
    step = reference.points - reference.means
    gradient = np.einsum("nij,nj->ni", A, step) + b + 1e-3 * trace[:, None] * step
    assert np.abs(gradient[solved]).max() < 1e-9 * trace.max()
    rise = np.einsum("ni,nij,nj->n", step, A, step) + 2 * np.einsum("ni,ni->n", b, step)
    assert (rise <= 1e-12).all()


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("placement", PLACEMENTS)
def test_quadric_clustering_of_plane_stays_in_plane(device, placement, way):
    mesh = flat_lattice(16)
    normal = np.array([0.36, 0.48, 0.8])
    turned = (
        mesh.positions @ np.linalg.qr(np.stack([normal, [1, 0, 0], [0, 1, 0]], 1))[0].T[[1, 2, 0]]
    )
    prepared = cluster(device, TriangleMesh(turned, mesh.triangles), cells=5, placement=placement,
                       **WAYS[way])  # fmt: skip
    (result,) = prepared.result()
    assert result.triangle_count
    assert np.abs(result.positions @ normal).max() < CLUSTER_PLANE * 16 / 5


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("placement", ["robust", "paper"])
def test_quadric_clustering_recovers_cube_corners(device, placement, way):
    # an odd count keeps a corner's three faces in its cell; the ridge pulls by its share of the way to the mean
    mesh = cube(12)
    (result,) = cluster(device, mesh, cells=3, placement=placement, **WAYS[way]).result()
    corners = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, -1).T
    nearest = np.linalg.norm(result.positions[None] - corners[:, None], axis=2).min(1)
    assert nearest.max() < (CLUSTER_RIDGE if placement == "robust" else CLUSTER_PLANE) / 3


@pytest.mark.parametrize("way", WAYS)
def test_quadric_clustering_average_is_mean_of_corners(device, way):
    mesh = sphere()
    prepared = cluster(device, mesh, cells=3, placement="average", **WAYS[way])
    (result,) = prepared.result()
    owner = prepared.vertex_map()[mesh.triangles].ravel()
    corners = mesh.positions[mesh.triangles].reshape(-1, 3).astype(np.float64)
    for v in range(result.vertex_count):
        assert result.positions[v] == pytest.approx(corners[owner == v].mean(0), abs=1e-5)


@pytest.mark.parametrize("way", WAYS)
def test_quadric_clustering_one_cell_leaves_nothing(device, way):
    (result,) = cluster(device, sphere(), cells=1, **WAYS[way]).result()
    assert (result.vertex_count, result.triangle_count) == (0, 0)


@pytest.mark.parametrize("way", WAYS)
def test_quadric_clustering_fine_grid_keeps_every_triangle(device, way):
    mesh = sphere()
    prepared = cluster(device, mesh, cells=300, **WAYS[way])
    (result,) = prepared.result()
    assert result.triangle_count == mesh.triangle_count
    assert np.array_equal(prepared.vertex_map()[mesh.triangles], result.triangles)


@pytest.mark.parametrize("way", WAYS)
def test_quadric_clustering_output_is_in_order_and_uses_every_vertex(device, way):
    mesh = sphere()
    prepared = cluster(device, mesh, cells=6, **WAYS[way])
    (result,) = prepared.result()
    assert np.array_equal(np.unique(result.triangles), np.arange(result.vertex_count))
    corners = prepared.vertex_map()[mesh.triangles]
    a, b, c = corners.T
    kept = corners[(a != b) & (b != c) & (c != a) & (corners != NO_VERTEX).all(1)]
    assert np.array_equal(kept, result.triangles)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("turn", [0, 1, 2])
def test_triangle_with_two_corners_in_one_cell_leaves_no_vertex(device, way, turn):
    # whichever two they are; far from the sphere, so that no other triangle uses their cells
    mesh = sphere()
    needle = [[5, 0, 0], [5, 0.01, 0], [5, 3, 0]]
    face = np.roll([[0, 1, 2]], turn) + mesh.vertex_count
    more = TriangleMesh(
        np.concatenate([mesh.positions, needle]), np.concatenate([mesh.triangles, face])
    )
    prepared = cluster(device, more, cells=20, **WAYS[way])
    (result,) = prepared.result()
    assert result.positions[:, 0].max() < 2
    assert np.array_equal(np.unique(result.triangles), np.arange(result.vertex_count))
    assert (prepared.vertex_map()[-3:] == NO_VERTEX).all()


@pytest.mark.parametrize("way", WAYS)
def test_quadric_clustering_ignores_unreferenced_vertices(device, way):
    mesh = sphere()
    inside = np.random.default_rng(0).uniform(-0.5, 0.5, (100, 3))
    more = TriangleMesh(np.concatenate([mesh.positions, inside]), mesh.triangles)
    assert outcome(cluster(device, more, cells=9, **WAYS[way])) == outcome(
        cluster(device, mesh, cells=9, **WAYS[way])
    )


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("mesh", [EMPTY, TriangleMesh(np.ones((5, 3)), EMPTY.triangles)])
def test_quadric_clustering_no_triangles_in_none_out(device, mesh, way):
    prepared = cluster(device, mesh, cells=8, remove_duplicates=True, **WAYS[way])
    (result,) = prepared.result()
    assert (result.vertex_count, result.triangle_count) == (0, 0)
    assert prepared.check().passed
    assert (prepared.vertex_map() == NO_VERTEX).all()
    assert simplify_to(device, mesh, target_count=10).mesh.triangle_count == 0


@pytest.mark.parametrize("way", WAYS)
def test_quadric_clustering_of_a_point_leaves_nothing(device, way):
    mesh = TriangleMesh(np.full((3, 3), 7.0), [[0, 1, 2]])
    assert cluster(device, mesh, cells=8, **WAYS[way]).result()[0].triangle_count == 0


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("cells", [6, (5, 6, 4)])
@pytest.mark.parametrize(
    ("scale", "offset"),
    [(1e20, 0), (1e-20, 0), (1, 1e6), (3e38, 0), (1e-41, 0), (1e-3, 100), (1e20, -3e22)],
)
def test_quadric_clustering_at_any_scale_is_finite_and_right(device, scale, offset, cells, way):
    mesh = sphere()
    mesh = TriangleMesh(mesh.positions.astype(np.float64) * scale + offset, mesh.triangles)
    prepared = cluster(device, mesh, cells=cells, **WAYS[way])
    (result,) = prepared.result()
    assert np.isfinite(result.positions).all()
    check = prepared.check()
    assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"


@pytest.mark.parametrize("way", WAYS)
def test_representative_beyond_a_box_as_wide_as_float32_stays_finite(device, way):
    # the sides of a roof without its ridge meet above the box
    side = flat_lattice(4)
    along = side.positions.astype(np.float64) / 4
    x = 0.25 + 0.75 * along[:, 0]
    right = np.stack([x, along[:, 1], (1 - x) / 0.75], axis=1)
    points = np.concatenate([right, right * (-1, 1, 1)]) * np.finfo(np.float32).max
    points[:, 0] /= 2
    faces = np.concatenate([side.triangles, side.triangles[:, ::-1] + side.vertex_count])
    high = TriangleMesh(points.astype(np.float32), faces)
    prepared = cluster(device, high, cells=(3, 2, 2), border="none", **WAYS[way])
    (result,) = prepared.result()
    assert np.isfinite(result.positions).all()
    assert result.positions[:, 2].max() == np.float32(3.4e38)


@pytest.mark.parametrize("thin", [1e-45, 1e-39, 1e-38, 1e-31, 1e-29, 1e-7])
@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("cells", [(90, 90, 90), (1, 3, 90), 20.5])
def test_quadric_clustering_of_a_box_thin_beyond_float32_stays_in_its_grid(
    device, thin, axis, cells
):
    points = np.array([[0, 0, 0], [0, 9, 0], [0, 0, 9], [thin, 9, 9]])
    mesh = TriangleMesh(np.roll(points, axis, axis=1), [[0, 1, 2], [1, 3, 2]])
    prepared = cluster(device, mesh, cells=cells)
    assert np.isfinite(prepared.grid.per_axis).all()
    assert prepared.check().passed
    (found,) = prepared.result()
    assert np.isfinite(found.positions).all()


def test_no_float_names_a_cell_outside_the_grid(device):
    # the kernel alone, with factors that no grid has: infinity times nothing is not a number
    positions = np.array([[0, 0, 0], [1, 1, 1], [-1, -1, -1], [3e38, 3e38, 3e38]], np.float32)
    ids = device.upload("cell_ids", np.full(4, 7, np.uint32))
    for factor in (np.inf, -np.inf, np.nan, -1.0, 3e38):
        device.build(FILE).launch(
            "cluster_search_cells", 1, stage="cells", local=1,
            positions=device.upload("positions", positions), cell_ids=ids, low=(0, 0, 0, 1),
            per_axis=(factor, factor, factor, 1), cells=(2, 3, 4, 0), vertex_count=4, chunk_count=1,
        )(Timeline())  # fmt: skip
        assert (device.read(ids) < 24).all()


def test_quadric_clustering_powers_of_two_scale_the_result_exactly(device):
    mesh = sphere()
    one = cluster(device, mesh, cells=6).result()[0]
    large = TriangleMesh(mesh.positions * np.float32(2.0**60), mesh.triangles)
    other = cluster(device, large, cells=6).result()[0]
    assert np.array_equal(other.positions, one.positions * np.float32(2.0**60))
    assert np.array_equal(other.triangles, one.triangles)


@pytest.mark.parametrize("way", WAYS)
def test_quadric_clustering_zero_area_triangles_count_at_their_corners_alone(device, way):
    # a needle between cells survives although it has no plane; what it adds to the mean is its corners
    positions = [[0, 0, 0], [4, 0, 0], [8, 0, 0], [0, 8, 0]]
    mesh = TriangleMesh(positions, [[0, 1, 2], [0, 2, 3]])
    prepared = cluster(device, mesh, cells=8, **WAYS[way])
    assert prepared.result()[0].triangle_count == 2
    assert prepared.check().passed
    twice = TriangleMesh(positions, [[0, 1, 2], [0, 1, 2]])
    prepared = cluster(device, twice, cells=8, **WAYS[way])
    assert prepared.counters()["placed_mean"] == 3


def corrupted(mesh, name):
    """The sphere with one thing wrong that a mesh may legally have."""
    positions, triangles = mesh.positions.astype(np.float64), mesh.triangles.copy()
    if name == "degenerate_face":
        triangles[5] = triangles[5, [0, 1, 1]]
    elif name == "duplicate_faces":
        triangles = np.concatenate([triangles, triangles[:40]])
    elif name == "unreferenced":
        positions = np.concatenate([positions, np.full((50, 3), 3.0)])
    elif name == "bowtie_vertex":
        triangles = np.concatenate([triangles, triangles + len(positions)])
        positions = np.concatenate([positions, positions + 2 * positions[0]])
    elif name == "fin_edge3":
        positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]])
        triangles = np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    elif name == "random_flips":
        triangles[::7] = triangles[::7, ::-1]
    elif name == "soup":
        positions, triangles = (
            positions[triangles].reshape(-1, 3),
            np.arange(3 * len(triangles)).reshape(-1, 3),
        )
    return TriangleMesh(positions, triangles)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(
    "name",
    ["degenerate_face", "duplicate_faces", "unreferenced", "bowtie_vertex", "fin_edge3",
     "random_flips", "soup"],
)  # fmt: skip
def test_quadric_clustering_survives_odd_meshes(device, name, way):
    prepared = cluster(
        device, corrupted(sphere(), name), cells=7, remove_duplicates=name == "soup", **WAYS[way]
    )
    check = prepared.check()
    assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"


def test_quadric_clustering_survives_collected_odd_meshes(device, data_folder):
    cases = np.load(data_folder / "nasty" / "synthetic.npz")
    seen = 0
    for name in sorted({key.rsplit("__", 1)[0] for key in cases.files}):
        try:
            mesh = TriangleMesh(cases[f"{name}__V"], cases[f"{name}__F"])
        except ValueError:
            continue
        seen += 1
        for way in WAYS.values():
            check = cluster(device, mesh, cells=9, **way).check()
            assert check.passed, f"{name} {way} {check.what}: {check.value} > {check.tolerance}"
    assert seen >= 10


def strip(count):
    """`count` triangles in a row, two more vertices."""
    k = np.arange(count + 2)
    positions = np.stack([k / 2, k % 2, np.sin(k)], axis=1)
    triangles = np.stack([k[:-2], k[1:-1], k[2:]], axis=1)
    triangles[1::2] = triangles[1::2, ::-1]
    return TriangleMesh(positions, triangles)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(
    "count", [1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 13, 61, 62, 63, 64, 65, 127, 128, 129, 255, 4096, 8191]
)
def test_quadric_clustering_handles_sizes_around_its_blocks(device, count, way):
    prepared = cluster(device, strip(count), cells=max(2, count // 3), **WAYS[way])
    check = prepared.check()
    assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"


@pytest.mark.parametrize("chunks", [1, 2, 3, 4])
def test_quadric_clustering_any_number_of_maps_gives_the_same_triangles(device, chunks):
    prepared = cluster(device, wavy_sheet(), cells=12, chunks=chunks)
    assert prepared.check().passed
    expected = cluster(device, wavy_sheet(), cells=12).result()[0]
    assert np.array_equal(prepared.result()[0].triangles, expected.triangles)


@pytest.mark.parametrize("placement", PLACEMENTS)
def test_quadric_clustering_fused_equals_separate(device, placement):
    params = {"cells": 11, "placement": placement}
    assert outcome(cluster(device, sphere(), **params)) == outcome(
        cluster(device, sphere(), strategy="separate", **params)
    )


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("duplicates", [False, True])
def test_quadric_clustering_repeats_its_bytes(device, way, duplicates):
    params = {"cells": 10, "remove_duplicates": duplicates, **WAYS[way]}
    mesh = wavy_sheet()
    expected = outcome(cluster(device, mesh, **params))
    prepared = prepare(device, mesh, Params(**params))
    for _ in range(3):
        run(device, prepared)
        assert outcome(prepared) == expected
    for options in ({"local_size": 1}, {"local_size": 48}, {"local_size": 256}, {"one_core": True}):
        other = Device.open(**options)
        assert outcome(cluster(other, mesh, **params)) == expected, options


def test_quadric_clustering_fixed_point_ignores_triangle_order(device):
    mesh = wavy_sheet()
    other, order = shuffled(mesh, seed=3)
    one = cluster(device, mesh, cells=9, accumulate="fixed_point").result()[0]
    two = cluster(device, other, cells=9, accumulate="fixed_point")
    assert two.result()[0].positions.tobytes() == one.positions.tobytes()
    corners = two.vertex_map()[mesh.triangles]
    a, b, c = corners.T
    assert np.array_equal(corners[(a != b) & (b != c) & (c != a)], one.triangles)
    corners = corners[order]
    a, b, c = corners.T
    expected = corners[(a != b) & (b != c) & (c != a)]
    assert np.array_equal(two.result()[0].triangles, expected)


@pytest.mark.parametrize("way", WAYS)
def test_quadric_clustering_removes_duplicates_in_order(device, way):
    # two sheets closer than a cell, facing each other, fold onto one another
    sheet = flat_lattice(12)
    positions = np.concatenate([sheet.positions, sheet.positions + np.array([0, 0, 0.01])])
    back = sheet.triangles[:, ::-1] + sheet.vertex_count
    mesh = TriangleMesh(positions, np.concatenate([sheet.triangles, back]))
    all_ = cluster(device, mesh, cells=5, **WAYS[way]).result()[0]
    one = cluster(device, mesh, cells=5, remove_duplicates=True, **WAYS[way]).result()[0]
    keys = np.sort(all_.triangles, axis=1)
    _, first = np.unique(keys, axis=0, return_index=True)
    assert len(first) < all_.triangle_count
    assert np.array_equal(one.triangles, all_.triangles[np.sort(first)])
    assert np.array_equal(one.positions, all_.positions)


def test_quadric_clustering_float32_loses_no_accuracy(device):
    # distance of the representatives from the sphere that the mesh was sampled from
    mesh = sphere(60, 120)
    (result,) = cluster(device, mesh, cells=40).result()
    reference = simplify(mesh, Params(40)).mesh
    assert np.array_equal(result.triangles, reference.triangles)
    off = [np.linalg.norm(m.positions.astype(np.float64), axis=1) - 1 for m in (result, reference)]
    got, expected = (float(np.sqrt((o**2).mean())) for o in off)
    assert got == pytest.approx(expected, rel=0.01)


def test_quadric_clustering_memory_limit_is_unsupported():
    small = Device.open(memory_limit=20_000)
    with pytest.raises(Unsupported, match=r"needs [\d,]+ bytes of device memory, device has"):
        prepare(small, sphere(), Params(64))


@pytest.mark.parametrize("way", WAYS)
def test_quadric_clustering_gives_memory_back(device, way):
    before = device.used_bytes
    prepared = cluster(device, sphere(), cells=16, remove_duplicates=True, **WAYS[way])
    footprint = prepared.footprint()
    used = footprint.input_bytes + footprint.output_bytes + footprint.scratch_bytes
    assert used == device.used_bytes - before
    del prepared
    assert device.used_bytes == before


@pytest.mark.parametrize(
    ("cells", "error"),
    [(0, ValueError), (-3, ValueError), (float("nan"), ValueError), (513, None), ("9", TypeError),
     ((4, 4), ValueError), ((4, 4, 0), ValueError), ((600, 600, 600), ValueError), (True, TypeError)],
)  # fmt: skip
def test_params_refuse_impossible_cells(cells, error):
    if error is None:  # 2**27 bounds the product over the box, which only the mesh decides
        Params(cells)
        return
    with pytest.raises(error, match="cells: expected"):
        Params(cells)


def test_quadric_clustering_refuses_too_many_cubic_cells(device):
    with pytest.raises(ValueError, match=r"cells: expected at most 134,217,728 in all"):
        prepare(device, sphere(), Params(600))


@pytest.mark.parametrize("name", ["placement", "strategy", "accumulate"])
def test_params_refuse_unknown_words(name):
    with pytest.raises(ValueError, match=f"{name}: expected one of"):
        Params(**{name: "other"})


def test_grid_clamps_the_far_face_and_flat_axes():
    grid = Grid.over(np.zeros(3), np.array([2.0, 1.0, 0.0]), 4)
    assert grid.counts == (4, 2, 1)
    points = grid.points(np.array([[2, 1, 0], [0, 0, 0], [0.49, 0.51, 0]], np.float32))
    assert grid.cells_of(points).tolist() == [7, 0, 4]


def test_grid_back_and_forth_is_the_same_point():
    low, high = np.array([-3.0, 1e4, 0.5]), np.array([5.0, 1e4 + 2, 0.75])
    grid = Grid.over(low, high, (7, 3, 5))
    at = np.random.default_rng(1).uniform(low, high, (100, 3)).astype(np.float32)
    # rounded where the longest edge is 1, then at the offset
    assert grid.positions(grid.points(at)) == pytest.approx(at, rel=ROUNDING32, abs=8 * ROUNDING32)


@pytest.mark.parametrize("axis", range(3))
def test_verdict_refuses_a_representative_off_its_planes(axis):
    # a cell at a cube's corner has planes across every axis
    reference = simplify(cube(12), Params(3))
    positions = reference.mesh.positions.copy()
    corner = int(np.linalg.norm(positions, axis=1).argmin())
    positions[corner, axis] += 0.02
    assert verdict(reference.mesh, reference).passed
    assert not verdict(TriangleMesh(positions, reference.mesh.triangles), reference).passed


def test_verdict_refuses_other_triangles():
    reference = simplify(sphere(), Params(6))
    triangles = reference.mesh.triangles
    for wrong in (triangles[:-1], triangles[::-1], np.roll(triangles, 1, axis=1)):
        assert not verdict(TriangleMesh(reference.mesh.positions, wrong), reference).passed


def test_fixed_point_holds_many_large_triangles_in_one_cell(device):
    # 5,000 copies of one corner of the box: sums as large as the scale has to allow for
    corner = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]]
    faces = np.concatenate([np.tile([[1, 2, 3]], (5000, 1)), [[0, 1, 2], [1, 4, 2]]])
    check = cluster(device, TriangleMesh(corner, faces), cells=2, accumulate="fixed_point").check()
    assert check.passed, f"{check.what}: {check.value}"


@pytest.mark.parametrize("way", WAYS)
def test_first_of_two_triangles_stays_though_another_chunk_meets_its_copy_first(device, way):
    random = np.random.default_rng(0)
    cells = random.choice(60**3, 3 * 8200, replace=False)
    points = np.stack(np.unravel_index(cells, (60, 60, 60)), axis=1) + 0.5
    points[:2] = (0, 0, 0), (60, 60, 60)
    faces = np.arange(3 * 8200).reshape(-1, 3)
    # the second chunk begins with copies of what the first ends with
    faces[4112:4128] = np.roll(faces[4096:4112][::-1], 1, axis=1)
    mesh = TriangleMesh(points, faces)
    kept = cluster(device, mesh, cells=(60, 60, 60), remove_duplicates=True, **WAYS[way])
    plain = cluster(device, mesh, cells=(60, 60, 60), **WAYS[way]).result()[0]
    expected = without_duplicates(plain)
    assert expected.triangle_count == 8200 - 16
    assert np.array_equal(kept.result()[0].triangles, expected.triangles)
