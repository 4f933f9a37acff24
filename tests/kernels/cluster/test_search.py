import dataclasses

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.prepare import search_cells
from lodbench.kernels.cluster.quadric_clustering import Params, QuadricClustering, simplify
from lodbench.kernels.cluster.quadric_clustering.host import prepare
from lodbench.kernels.cluster.search import find_cells
from lodbench.kernels.cluster.survivors import DeviceSurvivors, host_survivors
from lodbench.kernels.cluster.unchanged import without_duplicates
from lodbench.kernels.cluster.upload import Upload
from lodbench.kernels.system import Frame, Timeline, run
from tests.kernels.cluster.meshes import cube, flat_lattice, sphere, tetrahedron, wavy_sheet


def folded_sheets():
    """Two sheets closer than most cells, facing each other: clustering leaves pairs of triangles."""
    sheet = flat_lattice(12)
    positions = np.concatenate([sheet.positions, sheet.positions + np.array([0, 0, 0.01])])
    back = sheet.triangles[:, ::-1] + sheet.vertex_count
    return TriangleMesh(positions, np.concatenate([sheet.triangles, back]))


@settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(share=st.floats(0.001, 0.999), rows=st.integers(3, 40))
def test_search_keeps_to_the_target_or_leaves_something(device, share, rows):
    mesh = sphere(rows, 2 * rows)
    target = max(int(share * mesh.triangle_count), 1)
    result = simplify(device, mesh, target_count=target)
    left = result.mesh.triangle_count
    assert left > 0
    assert result.counters["target_gap"] == target - left
    assert left <= max(target, 24), "more only where a handful is asked for"
    if share > 0.1 and rows > 20:  # a symmetric surface's count rises in steps
        assert left >= 0.8 * target


@pytest.mark.parametrize("duplicates", [False, True])
@pytest.mark.parametrize("mesh", [sphere(20, 40), wavy_sheet(), folded_sheets()])
def test_device_and_host_count_what_the_frame_leaves(device, mesh, duplicates):
    upload = Upload(device, mesh)
    count = DeviceSurvivors(
        device, upload.program, upload.positions, upload.triangles, (upload.low, upload.high),
        duplicates,
    )  # fmt: skip
    host = host_survivors(mesh, duplicates)
    for cells in (1.0, 2.3, 7.7, 31.0):
        left = prepare(device, mesh, Params(cells, remove_duplicates=duplicates))
        assert count(cells) == host(cells) == left.counters()["triangles"]
        assert count(cells, 3) == host(cells, 3)


def test_target_counts_what_is_left_after_duplicates_went(device):
    mesh = folded_sheets()
    for target in (20, 60, 100):
        result = simplify(device, mesh, target_count=target, remove_duplicates=True)
        assert result.counters["target_gap"] == target - result.mesh.triangle_count
        assert 0 < result.mesh.triangle_count <= target
        assert result.mesh.triangle_count >= 0.6 * target, "a lattice's count rises in steps"
        assert without_duplicates(result.mesh).triangle_count == result.mesh.triangle_count


@pytest.mark.parametrize(
    ("asked", "left"), [({"target_reduction": 0.5}, 12), ({"target_count": 1}, 12)]
)
def test_a_box_never_comes_back_empty(device, asked, left):
    # one cell leaves nothing, two along an axis everything: nothing in between
    result = simplify(device, cube(1), **asked)
    assert result.mesh.triangle_count == left
    assert result.counters["target_gap"] == result.counters["target"] - left < 0


@pytest.mark.parametrize("mesh", [
    TriangleMesh(np.full((3, 3), 7.0), [[0, 1, 2]]),
    TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1e9, 0, 0]], [[0, 1, 2], [0, 2, 1]]),
])  # fmt: skip
def test_a_mesh_below_every_grid_comes_back_itself(device, mesh):
    result = simplify(device, mesh, target_count=1)
    assert np.array_equal(result.mesh.triangles, mesh.triangles)
    assert np.array_equal(result.mesh.positions, mesh.positions)
    assert result.counters["target_gap"] == 1 - mesh.triangle_count


@pytest.mark.parametrize(
    "asked", [{"target_reduction": 0.0}, {"target_count": 132}, {"target_count": 10**9}]
)
def test_all_triangles_asked_for_is_the_identity(device, asked):
    mesh = sphere(12, 6)
    positions = np.concatenate([mesh.positions, [[3, 3, 3]]])
    colours = np.abs(positions) / 3
    more = TriangleMesh(positions + 1e6, mesh.triangles, colours=colours)
    assert more.origin is not None
    assert more.triangle_count == 132
    result = simplify(device, more, **asked)
    assert result.mesh.positions.tobytes() == more.positions.tobytes()
    assert result.mesh.triangles.tobytes() == more.triangles.tobytes()
    assert result.mesh.points.tobytes() == more.points.tobytes()
    assert result.mesh.colours is not None and more.colours is not None
    assert result.mesh.colours.tobytes() == more.colours.tobytes()
    assert result.vertex_map is not None
    assert np.array_equal(result.vertex_map, np.arange(more.vertex_count))
    assert (result.counters["target"], result.counters["target_gap"]) == (132, 0)


def test_identity_still_removes_duplicates(device):
    mesh = sphere(12, 6)
    twice = TriangleMesh(mesh.positions, np.concatenate([mesh.triangles, mesh.triangles[:9, ::-1]]))
    result = simplify(device, twice, target_reduction=0.0, remove_duplicates=True)
    assert np.array_equal(result.mesh.triangles, mesh.triangles)
    assert result.counters["target_gap"] == 9


def test_identity_is_a_frame_that_is_measured_like_any_other(device):
    before = device.used_bytes
    prepared = prepare(device, sphere(), Params(target_reduction=0.0))
    timeline = run(device, prepared)
    assert timeline.stage_s["copy"] > 0
    assert prepared.check().passed
    footprint = prepared.footprint()
    assert footprint.input_bytes + footprint.output_bytes == device.used_bytes - before
    prepared.enqueue(Frame(), Timeline())
    (surface,) = prepared.output
    device.fill(Timeline(), "spoil", surface.triangles, 0)
    assert not prepared.check().passed


def test_search_is_timed_apart_and_uploads_once(device):
    mesh = sphere(40, 80)
    before = device.used_bytes
    asked = Params(target_count=1000, placement="average")
    prepared = prepare(device, mesh, asked)
    assert isinstance(prepared, QuadricClustering)
    counters = prepared.counters()
    assert 950 <= counters["triangles"] <= 1000
    cells = counters["cells_along_longest"]
    assert prepared.params == dataclasses.replace(asked, target_count=None, cells=cells)
    assert {"upload", "search"} <= set(prepared.setup.stage_s)
    run(device, prepared)
    assert prepared.check().passed
    assert prepared.result()[0].triangle_count == counters["triangles"]
    del prepared
    assert device.used_bytes == before


def test_search_settles_on_any_count_it_is_given():
    # a count that a square law makes, and one in steps of a hundred
    extents = np.array([4.0, 2.0, 1.0])
    smooth = find_cells(lambda cells, _: int(3 * cells**2), extents, 10**6, 5000)
    assert smooth.met and smooth.cells is not None
    steps = find_cells(lambda cells, _: 100 * int(cells**2 / 40), extents, 10**6, 250)
    assert (steps.triangles, steps.gap, steps.met) == (200, 50, False)
    above = find_cells(lambda cells, _: 700 if cells > 9 else 0, extents, 10**6, 250)
    assert (above.triangles, above.gap, above.met) == (700, -450, False)
    assert above.cells is not None and above.cells > 9


def test_search_asks_for_no_grid_finer_than_may_be():
    asked = []

    def count(cells, stride):
        asked.append(cells)
        return 10

    found = find_cells(count, np.array([4.0, 2.0, 1.0]), 10**6, 500, most_cells=10**4)
    assert found.triangles == 10
    assert (
        max(np.prod(np.ceil(cells * np.array([1, 0.5, 0.25]) - 1e-9)) for cells in asked) <= 10**4
    )


def test_search_refuses_a_negative_target(device):
    with pytest.raises(ValueError, match="target_count: expected at least 0"):
        search_cells(Upload(device, tetrahedron()), -1)


def test_duplicates_go_with_the_tags_of_their_edges():
    tags = np.arange(18).reshape(3, 3, 2)
    mesh = TriangleMesh(np.eye(3), [[0, 1, 2], [2, 1, 0], [0, 0, 1]], edge_tags=tags)
    found = without_duplicates(mesh)
    assert found.triangles.tolist() == [[0, 1, 2], [0, 0, 1]]
    assert np.array_equal(found.edge_tags, tags[[0, 2]])
