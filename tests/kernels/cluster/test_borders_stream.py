"""Border edges of files, in batches of any size, against those found in core."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen import read
from lodbench.datasets_gen.batches import MeshFile
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, terrain
from lodbench.kernels.cluster import borders_stream
from lodbench.kernels.cluster.borders import border_edges, border_vertices
from lodbench.kernels.cluster.borders_stream import StreamBorders
from lodbench.kernels.cluster.upload import Upload
from tests.datasets_gen.test_batches import scattered


def streamed(device, path, rows):
    file = MeshFile(path)
    file.box()
    return StreamBorders(device, file, rows, lambda share: None)


def where(borders):
    """The corners of border edges: from, to and the third, (k, 3, 3)."""
    batches = [batch.positions[batch.triangles] for batch in borders.edges()]
    return np.concatenate([np.zeros((0, 3, 3), np.float32), *batches])


def check(device, path, rows):
    mesh, found = read.read_mesh(path), streamed(device, path, rows)
    upload = Upload(device, mesh)
    expected = border_edges(device, upload.program, upload.triangles, mesh.positions)
    assert found.count == len(expected)
    assert where(found).tobytes() == mesh.positions[expected].tobytes()
    if path.suffix == ".ply":
        assert np.array_equal(found.vertices(), border_vertices(expected))


@settings(
    max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    st.lists(st.tuples(*[st.integers(0, 7)] * 3), min_size=1, max_size=20),
    st.lists(st.integers(0, 5), min_size=8, max_size=8),
    st.integers(1, 25),
    st.booleans(),
    st.booleans(),
    st.sampled_from([".ply", ".stl"]),
)
def test_those_of_any_soup_are_those_in_core(
    device, tmp_path, monkeypatch, triangles, places, rows, few_slots, few_at_once, suffix
):
    if few_slots:
        monkeypatch.setattr(borders_stream, "_TABLE_SHARE", 1 << 40)
        monkeypatch.setattr(borders_stream, "_LEAST_SLOTS", 4)
    monkeypatch.setattr(borders_stream, "_AT_ONCE", 0.5 if few_at_once else 100)
    # several vertices at a place, as where a seam of texture parts them
    lattice = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -0.0, 1], [1, 1, 0], [5, 5, 1]])
    mesh = TriangleMesh(lattice[places].astype(np.float32), np.array(triangles))
    read.write_mesh(tmp_path / f"a{suffix}", mesh)
    check(device, tmp_path / f"a{suffix}", rows)


@pytest.mark.parametrize("make", [lambda: terrain(60), lambda: scattered(terrain(60))])
@pytest.mark.parametrize("at_once", [0.1, 2])
@pytest.mark.parametrize("suffix", [".ply", ".stl"])
def test_those_of_a_sheet_are_those_in_core(device, tmp_path, monkeypatch, make, at_once, suffix):
    monkeypatch.setattr(borders_stream, "_AT_ONCE", at_once)
    read.write_mesh(tmp_path / f"a{suffix}", make())
    check(device, tmp_path / f"a{suffix}", 777)


def test_triangles_that_share_nothing_take_several_walks(device, tmp_path):
    mesh = terrain(16)
    soup = TriangleMesh(
        mesh.positions[mesh.triangles].reshape(-1, 3),
        np.arange(3 * mesh.triangle_count).reshape(-1, 3),
    )
    read.write_mesh(tmp_path / "a.ply", soup)
    check(device, tmp_path / "a.ply", 100)


def test_a_closed_mesh_is_walked_over_once(device, tmp_path, monkeypatch):
    read.write_mesh(tmp_path / "a.ply", icosphere(4))
    monkeypatch.setattr(StreamBorders, "_collect", None)
    assert streamed(device, tmp_path / "a.ply", 500).count == 0
