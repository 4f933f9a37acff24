import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen.surfaces import ATTRIBUTES, TriangleMesh
from lodbench.datasets_gen.triangles import displaced_icosphere, icosphere, terrain, torus
from lodbench.kernels import simplify, simplify_mesh
from lodbench.kernels.cluster import attribute_sums, attributes
from lodbench.kernels.cluster.turned import NO_VERTEX
from tests.kernels.cluster.meshes import cube, flat_lattice, single_triangle, wavy_sheet
from tests.tolerances import EPSILON32

METHODS = ("quadric_clustering", "vertex_average")
UNIT = 4 * EPSILON32  # three rounded squares


def mapped_torus(around=60, across=36):
    """A torus with texture coordinates 0..1 both ways: the rows where they begin and end are there twice."""
    mesh = torus(around, across)
    u, v = np.meshgrid(np.arange(around + 1), np.arange(across + 1), indexing="ij")
    row = ((u % around) * across + v % across).ravel()
    a = (u[:-1, :-1] * (across + 1) + v[:-1, :-1]).ravel()
    b, c, d = a + across + 1, a + across + 2, a + 1
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    uvs = np.stack([u.ravel() / around, v.ravel() / across], axis=1)
    assert mesh.normals is not None
    return TriangleMesh(mesh.positions[row], faces, mesh.normals[row], uvs)


def sided_cube(n=8):
    """The cube with the normals of its sides, each side mapped to a square of its own and of one colour."""
    mesh = cube(n)
    side = np.repeat(np.arange(6), (n + 1) ** 2)
    normals = np.zeros((len(side), 3))
    normals[np.arange(len(side)), (side // 2 + 2) % 3] = np.where(side % 2, 1, -1)
    flat = np.stack([mesh.positions[side // 2 == k] for k in range(3)])
    uvs = np.concatenate([np.delete(flat[k], (k + 2) % 3, axis=1) for k in range(3)]) / 4
    uvs += np.stack([side % 3, side // 3], axis=1) / 3
    return TriangleMesh(
        mesh.positions, mesh.triangles, normals, uvs, (side / 5)[:, None] * [1, 1, 1]
    )


def same_surface(mesh, other):
    """The same triangles at the same places, to the bit, and the same points before those that were split off."""
    assert mesh.triangle_count == other.triangle_count
    left, right = (m.positions[m.triangles] for m in (mesh, other))
    assert left.tobytes() == right.tobytes()
    assert mesh.positions[: other.vertex_count].tobytes() == other.positions.tobytes()
    assert set(np.unique(mesh.triangles)) == set(range(mesh.vertex_count))


def both(device, mesh, **options):
    """With attributes and without."""
    result = simplify_mesh(device, mesh, **options)
    plain = simplify_mesh(device, mesh, attributes=False, **options)
    assert all(getattr(plain.mesh, name) is None for name in ATTRIBUTES)
    same_surface(result.mesh, plain.mesh)
    assert result.counters["vertices"] == result.mesh.vertex_count
    added = result.mesh.vertex_count - plain.mesh.vertex_count
    assert result.counters["split_vertices"] == added
    assert result.levels == (result.mesh,)
    own = result.vertex_map != NO_VERTEX
    assert np.array_equal(own, plain.vertex_map != NO_VERTEX)
    at = result.mesh.positions[result.vertex_map[own]]
    assert at.tobytes() == plain.mesh.positions[plain.vertex_map[own]].tobytes()
    return result, plain


@pytest.mark.parametrize("method", METHODS)
def test_values_are_means_weighted_by_area(device, method):
    mesh = torus(80, 40)
    colours = np.abs(mesh.positions % 1)
    mesh = TriangleMesh(mesh.positions, mesh.triangles, mesh.normals, None, colours, colours * 3)
    result, _ = both(device, mesh, cells=16, method=method)
    assert result.counters["split_vertices"] == 0
    corners = mesh.positions[mesh.triangles].astype(float)
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    weight = np.bincount(mesh.triangles.ravel(), np.repeat(area, 3))
    own = result.vertex_map != NO_VERTEX
    for name in ("normals", "colours", "tags"):
        sums = np.zeros((result.mesh.vertex_count, 4))
        rows = np.c_[getattr(mesh, name), np.ones(len(weight))] * weight[:, None]
        np.add.at(sums, result.vertex_map[own], rows[own])
        means = sums[:, :3] / sums[:, 3:]
        if name == "normals":
            means /= np.linalg.norm(means, axis=1, keepdims=True)
        assert np.abs(getattr(result.mesh, name) - means).max() < 1e-6, name


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("cells", [3, 5.5, 9, 40])
def test_sides_of_a_cube_keep_their_normals_uvs_and_colours(device, method, cells):
    mesh = sided_cube()
    result, _ = both(device, mesh, cells=cells, method=method)
    out = result.mesh
    assert result.counters["split_vertices"] > 0
    colours = out.colours[out.triangles]
    assert np.ptp(colours, axis=1).max() == 0, "no corner has the colour of another side"
    side = np.rint(5 * colours[:, 0, 0]).astype(int)
    normals = np.zeros((len(side), 3))
    normals[np.arange(len(side)), (side // 2 + 2) % 3] = np.where(side % 2, 1, -1)
    assert np.abs(out.normals[out.triangles] - normals[:, None]).max() < UNIT
    square = out.uvs[out.triangles] - (np.stack([side % 3, side // 3], axis=1) / 3)[:, None]
    assert square.min() > -UNIT and square.max() < 0.25 + UNIT


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("reduction", [0.3, 0.6, 0.9, 0.97])
def test_seams_of_a_mapped_torus_stay_sharp(device, method, reduction):
    mesh = mapped_torus()
    result, _ = both(device, mesh, target_reduction=reduction, method=method)
    out = result.mesh
    assert 0 < result.counters["split_vertices"] < 0.3 * out.vertex_count
    assert np.ptp(out.uvs[out.triangles], axis=1).max() < 0.4, "a smeared corner spans 0.5 or more"
    # what the coordinates say is where the vertex lies, up to the size of a cell
    u = np.arctan2(out.positions[:, 1], out.positions[:, 0]) / (2 * np.pi)
    off = (out.uvs[:, 0] - u + 0.5) % 1 - 0.5
    assert np.abs(off).max() < 0.6 / result.counters["cells_along_longest"]


@pytest.mark.parametrize("gap", [1.1, 0.02])
@pytest.mark.parametrize("reduction", [0.5, 0.9, 0.97])
def test_islands_of_a_picture_are_not_mixed(device, gap, reduction):
    # each triangle seen along the axis it faces most, six islands side by side or all but on top of each other
    ball = displaced_icosphere(24)
    corners = ball.positions[ball.triangles].astype(float)
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    axis = np.abs(facing).argmax(1)
    island = 2 * axis + (facing[np.arange(len(axis)), axis] > 0)
    keys, number = np.unique(ball.triangles.astype(int) * 6 + island[:, None], return_inverse=True)
    seen = np.array([[1, 2], [0, 2], [0, 1]])

    def picture(places, islands):
        flat = np.take_along_axis(places, seen[islands // 2], axis=-1)
        return flat + np.stack([islands % 3, islands // 3], axis=-1) * gap

    positions = ball.positions[keys // 6]
    mesh = TriangleMesh(positions, number.reshape(-1, 3), uvs=picture(positions, keys % 6))
    result, plain = both(device, mesh, target_reduction=reduction, method="quadric_clustering")
    a, b, c = plain.vertex_map[mesh.triangles].T
    own = island[(a != b) & (b != c) & (c != a)]
    out, edge = (
        result.mesh,
        np.ptp(positions, axis=0).max() / result.counters["cells_along_longest"],
    )
    expected = picture(out.positions[out.triangles], np.repeat(own[:, None], 3, axis=1))
    off = np.abs(out.uvs[out.triangles] - expected).max(axis=2) / edge
    # no farther than the representative of a cell from its vertices; islands that nearly meet may mix a few
    assert (off > 1.5).mean() <= (0 if gap > 1 else 0.005)


def test_sheets_of_a_thin_wall_keep_their_own_normals(device):
    front = flat_lattice(8)
    back = front.positions + np.float32((0, 0, 0.01))
    mesh = TriangleMesh(
        np.concatenate([front.positions, back]),
        np.concatenate([front.triangles[:, ::-1], front.triangles + len(back)]),
        np.repeat([[0, 0, -1.0], [0, 0, 1]], len(back), axis=0),
    )
    result, plain = both(device, mesh, cells=4)
    assert result.mesh.vertex_count == 2 * plain.mesh.vertex_count
    assert np.array_equal(np.unique(result.mesh.normals, axis=0), [[0, 0, -1], [0, 0, 1]])


def test_triangles_that_share_no_vertex_are_split_only_where_they_differ(device):
    ball = icosphere(4)
    soup = ball.triangles.ravel()
    loose = TriangleMesh(
        ball.positions[soup], np.arange(len(soup)).reshape(-1, 3), ball.normals[soup]
    )
    result, _ = both(device, loose, cells=10)
    assert result.counters["split_vertices"] == 0
    random = np.random.default_rng(0).random((len(soup) // 3, 3)).repeat(3, axis=0)
    painted = TriangleMesh(loose.positions, loose.triangles, colours=np.rint(random))
    out = both(device, painted, cells=10)[0].mesh
    assert set(np.unique(out.colours)) == {0.0, 1.0}, "each triangle has its own colour"
    assert np.ptp(out.colours[out.triangles], axis=1).max() == 0


def test_more_sides_than_are_told_apart_stand_for_themselves(device):
    # a fan of loose triangles about one point, each of its own place in the picture
    around = np.linspace(0, 2 * np.pi, 101)[:-1]
    rim = np.stack([np.cos(around), np.sin(around), 0 * around], axis=1)
    points = np.stack([0 * rim, rim, np.roll(rim, -1, axis=0)], axis=1).reshape(-1, 3)
    uvs = np.repeat(np.random.default_rng(1).random((100, 2)), 3, axis=0)
    mesh = TriangleMesh(points, np.arange(300).reshape(-1, 3), uvs=uvs)
    out = both(device, mesh, cells=64)[0].mesh
    assert out.triangle_count > 90
    assert np.ptp(out.uvs[out.triangles], axis=1).max() < UNIT


@st.composite
def attributed(draw):
    """A handful of triangles, duplicate and without area among them, with every attribute."""
    count, faces = draw(st.integers(3, 30)), draw(st.integers(1, 40))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    places = random.integers(0, draw(st.integers(1, 9)) + 1, (count, 3))
    return TriangleMesh(
        places * draw(st.sampled_from([1e-30, 1.0, 1e30])),
        random.integers(0, count, (faces, 3)),
        random.normal(size=(count, 3)).round(draw(st.integers(0, 3))),
        random.random((count, 2)).round(draw(st.integers(0, 3))) * draw(st.sampled_from([1, 1e20])),
        random.random((count, 3)).round(draw(st.integers(0, 3))),
        random.random((count, 3)),
    )


@settings(max_examples=60, deadline=None)
@given(attributed(), st.integers(1, 9), st.sampled_from(METHODS), st.booleans())
def test_any_mesh_keeps_its_surface_and_its_values_range(device, mesh, cells, method, distinct):
    result, _ = both(device, mesh, cells=cells, method=method, remove_duplicates=distinct)
    if not result.mesh.triangle_count:
        return
    for name in ("uvs", "colours", "tags"):
        given_, found = getattr(mesh, name), getattr(result.mesh, name)
        assert (found >= given_.min(0)).all() and (found <= given_.max(0)).all(), name
    assert np.abs(np.linalg.norm(result.mesh.normals, axis=1) - 1).max() < UNIT


@settings(max_examples=30, deadline=None)
@given(attributed(), st.integers(1, 9))
def test_equal_values_stay_as_they_are_and_split_nothing(device, mesh, cells):
    colour = np.broadcast_to(np.float32((0.1, 0.7, 1)), (mesh.vertex_count, 3))
    same = TriangleMesh(mesh.positions, mesh.triangles, None, colour[:, :2], colour)
    result, _ = both(device, same, cells=cells)
    assert result.counters["split_vertices"] == 0
    assert (result.mesh.colours == colour[:1]).all() and (result.mesh.uvs == colour[:1, :2]).all()


def test_two_calls_give_the_same_bytes(device):
    one, two = (simplify_mesh(device, mapped_torus(), cells=12).mesh for _ in range(2))
    for name in ("positions", "triangles", "normals", "uvs"):
        assert getattr(one, name).tobytes() == getattr(two, name).tobytes()


def test_meshes_without_attributes_and_arrays_are_never_split(device):
    sheet = wavy_sheet()
    result = simplify_mesh(device, sheet, cells=9)
    assert "split_vertices" not in result.counters and "attributes" not in result.setup.stage_s
    points, faces = simplify(sided_cube(), cells=5)
    expected, expected_faces = simplify(cube(8), cells=5)
    assert points.tobytes() == expected.tobytes() and np.array_equal(faces, expected_faces)


@pytest.mark.parametrize("method", METHODS)
def test_nothing_left_has_attributes_of_no_rows(device, method):
    empty = TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int), np.zeros((0, 3)))
    one = single_triangle().with_normals()
    for mesh, cells in ((empty, 3), (one, 1)):
        out = simplify_mesh(device, mesh, cells=cells, method=method).mesh
        assert out.triangle_count == 0 and out.normals.shape == (0, 3)
    kept = simplify_mesh(device, one, cells=2, method=method).mesh
    assert kept.normals.tolist() == [[0, 0, 1]] * 3


def test_the_mesh_as_it_came_keeps_what_it_has(device):
    mesh = mapped_torus(12, 9)
    out = simplify_mesh(device, mesh, target_reduction=0.0).mesh
    assert out.uvs is not None and np.array_equal(out.uvs, mesh.uvs)
    out = simplify_mesh(device, mesh, target_reduction=0.0, attributes=False).mesh
    assert out.uvs is None and np.array_equal(out.positions, mesh.positions)


def test_switches_are_checked_by_name(device):
    for name in ("attributes", "remove_flipped"):
        with pytest.raises(TypeError, match=f"{name}: expected True or False, got 3"):
            simplify_mesh(device, single_triangle(), cells=3, **{name: 3})


def test_normals_that_cancel_out_point_up():
    assert attribute_sums.unit(np.array([[0.0, 3], [0, 0], [0, 0]])).T.tolist() == [
        [0, 0, 1],
        [1, 0, 0],
    ]


@pytest.mark.parametrize("cells", [5, 14])
def test_cells_that_hold_one_side_need_no_look_at_their_pieces(device, monkeypatch, cells):
    """The same splits, and the same means to the rounding of their sums, as where every cell is looked into."""
    colours = np.random.default_rng(3).random((20, 3))
    for mesh in (terrain(60).with_normals(), wavy_sheet().with_normals(), torus(60, 30)):
        rows = np.linspace(0, 19.99, mesh.vertex_count).astype(int)
        mesh = dataclasses.replace(mesh, uvs=None, colours=colours[rows])
        found = simplify_mesh(device, mesh, cells=cells)
        with monkeypatch.context() as patch:
            patch.setattr(
                attributes, "mixed_vertices", lambda *given: np.ones(len(given[3].total), bool)
            )
            whole = simplify_mesh(device, mesh, cells=cells)
        assert found.counters["split_vertices"] == whole.counters["split_vertices"]
        assert np.array_equal(found.vertex_map, whole.vertex_map)
        assert np.array_equal(found.mesh.triangles, whole.mesh.triangles)
        for name in ("normals", "colours"):
            ours, theirs = getattr(found.mesh, name), getattr(whole.mesh, name)
            assert np.abs(ours - theirs).max() < UNIT
