"""The optional peers: each is skipped where its package is absent."""

import sys

import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines import vtk_mesh
from lodbench.harness.measure.quality import measure, topology
from lodbench.harness.plan.registry import systems
from lodbench.kernels.system import Unsupported, run
from tests.harness.baselines.test_fast_simplification import height_field

COUNTED = [
    "meshlib",
    "meshoptimizer_simplify",
    "meshoptimizer_sloppy",
    "pyfqmr",
    "manifold3d",
    "vtk_quadric_decimation",
]
GRIDDED = ["vtk_quadric_clustering", "vtk_binned_decimation"]
MODULES = {
    "meshoptimizer_simplify": "meshoptimizer",
    "meshoptimizer_sloppy": "meshoptimizer",
    "vtk_quadric_clustering": "vtkmodules.vtkFiltersCore",
    "vtk_binned_decimation": "vtkmodules.vtkFiltersCore",
    "vtk_quadric_decimation": "vtkmodules.vtkFiltersCore",
}


def blob(rows=40, columns=60):
    """A closed bumpy sphere of 2 * columns * (rows - 1) triangles."""
    polar = np.linspace(0, np.pi, rows + 1)[1:-1]
    around = np.arange(columns) * 2 * np.pi / columns
    radius = 1 + 0.1 * np.outer(np.sin(3 * polar) ** 2, np.cos(4 * around))
    ring = np.stack(
        [
            radius * np.outer(np.sin(polar), np.cos(around)),
            radius * np.outer(np.sin(polar), np.sin(around)),
            radius * np.outer(np.cos(polar), np.ones(columns)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    c = np.arange(columns)
    d = (c + 1) % columns
    top, bottom, last = len(ring), len(ring) + 1, (rows - 2) * columns
    faces = [
        np.stack([np.full(columns, top), c, d], 1),
        np.stack([np.full(columns, bottom), last + d, last + c], 1),
    ]
    for r in range(rows - 2):
        a, b = r * columns + c, r * columns + d
        faces += [np.stack([a, a + columns, b], 1), np.stack([b, a + columns, b + columns], 1)]
    return TriangleMesh(np.concatenate([ring, [[0, 0, 1], [0, 0, -1]]]), np.concatenate(faces))


def run_peer(device, name, mesh, **params):
    system = systems()[name]
    try:
        kind = type(next(iter(system.cases.values())))
        prepared = system.prepare(device, mesh, kind(**params))
    except Unsupported as reason:
        pytest.skip(str(reason))
    run(device, prepared)
    return prepared, prepared.result()[0]


@pytest.mark.parametrize("name", COUNTED)
def test_peer_keeps_the_count_asked_for(device, name):
    mesh = blob()
    prepared, result = run_peer(device, name, mesh, target_count=1000)
    assert 0 < result.triangle_count <= 1000
    assert prepared.check().passed
    assert measure(mesh, result, samples=2000)["rms_error"] < 0.02


@pytest.mark.parametrize(
    "name", ["meshoptimizer_simplify", "pyfqmr", "manifold3d", "vtk_quadric_decimation"]
)
def test_edge_collapse_peer_keeps_a_closed_surface_closed(device, name):
    _, result = run_peer(device, name, blob(), target_count=1000)
    found = topology(result)
    assert found["open_edges"] == 0
    assert found["euler"] == 2


@pytest.mark.parametrize("name", GRIDDED)
@pytest.mark.parametrize("bits", [32, 64])
def test_peer_has_one_vertex_per_occupied_cell(device, name, bits):
    mesh = blob()
    prepared, result = run_peer(device, name, mesh, cells=12, index_bits=bits)
    verdict = prepared.check()
    assert verdict.passed, verdict
    assert 100 < result.vertex_count < 1000
    assert measure(mesh, result, samples=2000)["rms_error"] < 0.05


@pytest.mark.parametrize("name", GRIDDED)
def test_grid_peer_check_fails_with_more_vertices_than_cells(device, name):
    mesh = blob()
    prepared, _ = run_peer(device, name, mesh, cells=4)
    prepared.read = lambda _: [mesh]
    assert not prepared.check().passed


@pytest.mark.parametrize("points", ["bin_points", "bin_centers", "bin_averages"])
def test_binned_decimation_places_points_as_asked(device, points):
    mesh = blob()
    _, result = run_peer(device, "vtk_binned_decimation", mesh, cells=12, points=points)
    from_input = {tuple(p) for p in mesh.positions.tolist()}
    kept = sum(tuple(p) in from_input for p in result.positions.tolist())
    if points == "bin_points":
        assert kept == result.vertex_count
    else:
        assert kept < result.vertex_count / 2


def test_binned_decimation_uses_as_many_threads_as_the_device_has(device):
    prepared, _ = run_peer(device, "vtk_binned_decimation", blob(), cells=12)
    tools = pytest.importorskip("vtkmodules.vtkCommonCore").vtkSMPTools
    assert tools.GetBackend() == "STDThread"
    assert tools.GetEstimatedNumberOfThreads() == prepared.device.facts.compute_units


def test_binned_decimation_refuses_an_unknown_placement():
    kind = type(systems()["vtk_binned_decimation"].cases["bin_points"])
    with pytest.raises(ValueError, match="points: expected one of bin_points"):
        kind(points="bin_medians")


def test_divisions_are_cubic_cells_along_the_longest_axis():
    flat = TriangleMesh([[0, 0, 0], [4, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    assert vtk_mesh.divisions(flat, 8) == (8, 2, 1)
    assert vtk_mesh.divisions(flat, (3, 4, 5)) == (3, 4, 5)
    point = TriangleMesh(np.ones((3, 3)), [[0, 1, 2]])
    assert vtk_mesh.divisions(point, 8) == (1, 1, 1)


def test_manifold3d_says_when_a_mesh_is_not_closed(device):
    pytest.importorskip("manifold3d")
    with pytest.raises(Unsupported, match="needs a closed oriented manifold"):
        system = systems()["manifold3d"]
        system.prepare(device, height_field(), next(iter(system.cases.values())))


def test_manifold3d_takes_a_tolerance(device):
    mesh = blob()
    _, fine = run_peer(device, "manifold3d", mesh, tolerance=1e-4)
    _, coarse = run_peer(device, "manifold3d", mesh, tolerance=1e-2)
    assert coarse.triangle_count < fine.triangle_count <= mesh.triangle_count


@pytest.mark.parametrize("name", COUNTED + GRIDDED)
def test_absent_peer_is_unsupported_with_the_line_that_installs_it(device, name, monkeypatch):
    monkeypatch.setitem(sys.modules, MODULES.get(name, name), None)
    system = systems()[name]
    with pytest.raises(Unsupported, match="pip install"):
        system.prepare(device, blob(), next(iter(system.cases.values())))
