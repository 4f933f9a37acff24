"""The subdividing peers: each is skipped where its package is absent."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import KDTree

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, plane, torus
from lodbench.harness.baselines.subdivision import halvings
from lodbench.harness.measure.quality import topology
from lodbench.harness.plan.registry import systems
from lodbench.kernels.refine import pattern
from lodbench.kernels.system import Unsupported, run
from tests.tolerances import ROUNDING32

LINEAR = ["igl_upsample", "trimesh_subdivide", "vtk_linear_subdivision"]
LOOP = ["igl_loop", "vtk_loop_subdivision"]
PEERS = LINEAR + LOOP
MODULES = {
    "igl": "igl",
    "trimesh": "trimesh.remesh",
    "vtk": "vtkmodules.vtkFiltersModeling",
}
MESHES = {"ball": lambda: icosphere(2), "torus": lambda: torus(9, 7), "open": lambda: plane(3, 2)}
FAN = TriangleMesh(  # three triangles at one edge
    [[0, 0, 0], [0, 0, 1], [1, 0, 0], [-1, 1, 0], [-1, -1, 0]], [[0, 1, 2], [0, 1, 3], [0, 1, 4]]
)


def run_peer(device, name, mesh, segments):
    system = systems()[name]
    kind = type(next(iter(system.cases.values())))
    try:
        prepared = system.prepare(device, mesh, kind(segments))
    except Unsupported as reason:
        pytest.skip(str(reason))
    run(device, prepared)
    return prepared, prepared.result()[0]


@pytest.mark.parametrize("segments", [1, 2, 8])
@pytest.mark.parametrize("make", MESHES)
@pytest.mark.parametrize("name", PEERS)
def test_peer_gives_the_welded_mesh(device, name, make, segments):
    mesh = MESHES[make]()
    prepared, result = run_peer(device, name, mesh, segments)
    check = prepared.check()
    assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"
    assert result.triangle_count == mesh.triangle_count * segments**2
    before, after = topology(mesh), topology(result)
    for kind in ("euler", "nonmanifold_edges", "components"):
        assert after[kind] == before[kind]
    assert after["open_edges"] == before["open_edges"] * segments


@pytest.mark.parametrize("make", MESHES)
@pytest.mark.parametrize("name", LINEAR)
def test_linear_peer_has_the_vertices_of_the_welded_pattern(device, name, make):
    mesh = MESHES[make]()
    _, result = run_peer(device, name, mesh, 8)
    kernel = pattern.Pattern(device, mesh, pattern.Params(8))
    run(device, kernel)
    welded = kernel.welded()
    assert result.vertex_count == welded.vertex_count
    away, _ = KDTree(result.positions).query(welded.positions)
    assert away.max() <= ROUNDING32 * np.abs(mesh.positions).max()


@pytest.mark.parametrize("name", LOOP)
def test_loop_peer_gives_another_surface_within_the_mesh(device, name):
    mesh = icosphere(1)
    _, result = run_peer(device, name, mesh, 8)
    radius = np.linalg.norm(result.positions, axis=1)
    assert 0.8 < radius.min() and radius.max() < 1 - 1e-3
    assert np.ptp(radius) < 0.02, "smooth"


def test_loop_peers_agree(device):
    one, other = (run_peer(device, name, torus(9, 7), 4)[1] for name in LOOP)
    away, _ = KDTree(one.positions).query(other.positions)
    assert away.max() <= ROUNDING32 * np.abs(one.positions).max()


@pytest.mark.parametrize("name", PEERS)
def test_check_finds_a_moved_vertex_and_a_missing_triangle(device, name):
    prepared, result = run_peer(device, name, icosphere(1), 4)
    moved = result.positions.copy()
    moved[3] *= 1.5
    for wrong in (
        replace(result, positions=moved),
        replace(result, triangles=result.triangles[1:]),
    ):
        prepared.read = lambda _, wrong=wrong: [wrong]
        assert not prepared.check().passed


@pytest.mark.parametrize("name", PEERS)
def test_unused_vertices_of_the_input_are_left_out(device, name):
    ball = icosphere(1)
    more = TriangleMesh(np.concatenate([ball.positions, np.full((3, 3), 9)]), ball.triangles)
    prepared, result = run_peer(device, name, more, 2)
    assert prepared.check().passed
    assert np.abs(result.positions).max() <= 1 + ROUNDING32


@pytest.mark.parametrize("name", PEERS)
def test_segments_that_are_no_power_of_two_are_unsupported(device, name):
    with pytest.raises(Unsupported, match="needs a power of two for segments, got 6"):
        system = systems()[name]
        system.prepare(device, icosphere(0), type(next(iter(system.cases.values())))(6))


@pytest.mark.parametrize("name", PEERS)
def test_edge_of_three_triangles_is_split_or_unsupported(device, name):
    if name == "trimesh_subdivide":
        assert run_peer(device, name, FAN, 4)[0].check().passed
        return
    system = systems()[name]
    with pytest.raises(Unsupported, match=r"needs (at most two triangles at an edge|igl|vtk)"):
        system.prepare(device, FAN, next(iter(system.cases.values())))


@pytest.mark.parametrize("name", PEERS)
def test_absent_package_is_unsupported_with_the_line_that_installs_it(device, name, monkeypatch):
    monkeypatch.setitem(sys.modules, MODULES[name.split("_")[0]], None)
    system = systems()[name]
    with pytest.raises(Unsupported, match="pip install"):
        system.prepare(device, icosphere(0), next(iter(system.cases.values())))


def test_halvings_are_counted():
    assert [halvings(segments) for segments in (1, 2, 16, 4096)] == [0, 1, 4, 12]
