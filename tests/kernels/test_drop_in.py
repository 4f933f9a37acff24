"""What fast-simplification promises of its calls, asked of ours: from its documentation, not from its tests."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import displaced_icosphere, icosphere, terrain, torus
from lodbench.harness.measure.quality import measure, topology
from lodbench.kernels import simplify, simplify_mesh
from lodbench.kernels.cluster.edge_collapse import collapses, replay

MESHES = (
    icosphere(4).bare(),
    displaced_icosphere(16).bare(),
    torus(30, 20).bare(),
    terrain(24).bare(),
)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, len(MESHES) - 1), st.floats(0, 0.97))
def test_a_reduction_is_reached_and_the_surface_stays_what_it_was(device, number, reduction):
    mesh = MESHES[number]
    points, faces = simplify(mesh.positions, mesh.triangles, reduction, device=device)
    target = max(1, int(mesh.triangle_count * (1 - reduction) + 1e-6))
    assert target - 1 <= len(faces) <= target
    assert points.shape == (len(points), 3) and faces.shape == (len(faces), 3)
    assert points.dtype == np.float32 and faces.dtype == np.uint32
    assert np.isfinite(points).all()
    assert reduction == 0 or sorted(set(faces.ravel())) == list(range(len(points)))
    before, after = topology(mesh), topology(TriangleMesh(points, faces))
    for key in ("components", "euler", "nonmanifold_edges", "flipped_edges"):
        assert after[key] == before[key]


@settings(max_examples=15, deadline=None)
@given(st.integers(0, len(MESHES) - 1), st.integers(40, 600))
def test_a_count_is_reached_and_fewer_triangles_are_no_nearer(device, number, count):
    mesh = MESHES[number]
    found = [
        simplify(mesh.positions, mesh.triangles, target_count=n, device=device)
        for n in (count, 8 * count)
    ]
    assert [
        min(n, mesh.triangle_count) - len(faces) in (0, 1)
        for n, (_, faces) in zip((count, 8 * count), found, strict=True)
    ]
    few, many = (measure(mesh, TriangleMesh(*made), samples=2000)["rms_error"] for made in found)
    assert many <= 1.05 * few + 1e-6


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("whole", [np.int32, np.int64, np.uint32])
def test_points_keep_their_type_and_faces_of_any_whole_type_do(device, kind, whole):
    mesh = MESHES[0]
    points, faces = simplify(
        mesh.positions.astype(kind), mesh.triangles.astype(whole), 0.8, device=device
    )
    assert points.dtype == kind
    plain = simplify(
        mesh.positions.astype(kind).tolist(), mesh.triangles.tolist(), 0.8, device=device
    )
    assert np.array_equal(plain[1], faces)
    # no order in memory is asked for, and what was given is left as it is
    given = np.asfortranarray(mesh.positions.astype(kind))
    again = simplify(given, np.asfortranarray(mesh.triangles), 0.8, device=device)
    assert np.array_equal(again[0], points) and np.array_equal(again[1], faces)
    assert np.array_equal(given, mesh.positions.astype(kind))


@pytest.mark.parametrize(
    ("arguments", "options", "said"),
    [
        ((np.zeros((4, 2)), [[0, 1, 2]], 0.5), {}, "points: expected"),
        ((np.zeros((4, 3)), [[0, 1, 2, 3]], 0.5), {}, "faces: expected"),
        ((np.zeros((4, 3)), [[0.5, 1, 2]], 0.5), {}, "faces: expected"),
        ((np.zeros((3, 3)), [[0, 1, 3]], 0.5), {}, "faces: expected"),
        ((np.full((3, 3), np.nan), [[0, 1, 2]], 0.5), {}, "points: expected"),
        ((np.zeros((3, 3)), [[0, 1, 2]], 1.5), {}, "target_reduction: expected"),
        ((np.zeros((3, 3)), [[0, 1, 2]], -0.1), {}, "target_reduction: expected"),
        ((np.zeros((3, 3)), [[0, 1, 2]]), {"target_count": 0}, "target_count: expected"),
        ((np.zeros((3, 3)), [[0, 1, 2]]), {}, "expected one of them, got none"),
        ((np.zeros((3, 3)), [[0, 1, 2]], 0.5), {"target_count": 3}, "expected one of them, got"),
        ((np.zeros((3, 3)), [[0, 1, 2]], 0.5), {"agg": 7}, "option: expected"),
    ],
)  # fmt: skip
def test_bad_input_is_one_clear_line(device, arguments, options, said):
    with pytest.raises((TypeError, ValueError), match=said) as error:
        simplify(*arguments, device=device, **options)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("number", range(len(MESHES)))
def test_collapses_replayed_are_the_mesh_that_was_made(device, number):
    mesh = MESHES[number]
    made = collapses(device, mesh, target_reduction=0.9)
    direct = simplify_mesh(device, mesh, target_reduction=0.9, method="edge_collapse").mesh
    again = replay(made, direct.triangle_count)
    assert again.triangle_count == direct.triangle_count
    assert np.array_equal(again.positions, direct.positions)
    half = replay(made, mesh.triangle_count // 2)
    assert direct.triangle_count < half.triangle_count <= mesh.triangle_count // 2


@pytest.mark.parametrize("number", range(len(MESHES)))
def test_objects_come_back_as_what_they_are(device, number):
    trimesh, pyvista = pytest.importorskip("trimesh"), pytest.importorskip("pyvista")
    mesh = MESHES[number]
    objects = (
        trimesh.Trimesh(mesh.positions, mesh.triangles, process=False),
        pyvista.PolyData.from_regular_faces(mesh.positions, mesh.triangles.astype(np.int64)),
        (mesh.positions, mesh.triangles),
        mesh,
    )
    points, faces = simplify(mesh.positions, mesh.triangles, 0.8, device=device)
    for one in objects:
        made = simplify_mesh(device, one, target_reduction=0.8)
        back = made.to(one)
        assert isinstance(back, type(one))
        assert made.mesh.triangle_count == len(faces)
        assert np.allclose(made.mesh.positions, points, atol=1e-5)
        ours, theirs = simplify(back, target_reduction=0.0, device=device)
        assert np.array_equal(theirs, made.mesh.triangles) and len(ours) == len(points)


def test_seams_of_points_that_stand_twice_do_not_open(device):
    """A tube cut open along a line, as texture coordinates have it: the rims stay together."""
    rows, columns = 20, 40
    around = np.linspace(0, 2 * np.pi, columns + 1)
    along = np.linspace(0, 3, rows)
    u, v = (grid.ravel() for grid in np.meshgrid(around, along))
    points = np.stack([np.cos(u % (2 * np.pi)), np.sin(u % (2 * np.pi)), v], axis=1)
    points[columns :: columns + 1] = points[0 :: columns + 1]
    at = (np.arange(rows - 1)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    up = at + columns + 1
    faces = np.concatenate([np.stack([at, at + 1, up], 1), np.stack([at + 1, up + 1, up], 1)])
    assert topology(TriangleMesh(points, faces))["open_edges"] > 2 * columns
    made = TriangleMesh(*simplify(points, faces, 0.8, device=device))
    found = topology(made)
    assert found["euler"] == 0, "a tube, no sheet"
    rims = made.positions[made.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)]
    assert found["open_edges"] < len(rims)
    assert found["nonmanifold_edges"] == 0
