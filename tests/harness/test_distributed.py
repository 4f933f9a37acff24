import os
import signal
import sys
import time

import numpy as np
import pytest

from lodbench.datasets_gen import read
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import displaced_icosphere, terrain
from lodbench.harness.distributed import simplify
from lodbench.kernels import simplify_mesh


def pieces_of(mesh, count):
    """Triangles in `count` runs, each with the points that it uses."""
    found = []
    for triangles in np.array_split(mesh.triangles, count):
        used, rows = np.unique(triangles, return_inverse=True)
        found.append((mesh.positions[used], rows.reshape(-1, 3)))
    return found


def same(mesh, expected):
    return (
        mesh.positions.tobytes() == expected.positions.tobytes()
        and mesh.triangles.tobytes() == expected.triangles.tobytes()
    )


@pytest.fixture
def client():
    """A cluster in this process."""
    distributed = pytest.importorskip("distributed")
    with distributed.Client(
        processes=False, n_workers=1, threads_per_worker=2, dashboard_address=None
    ) as found:
        yield found


class Deadly:
    """A piece whose worker dies as it is read for the fourth time: in the middle of the last pass."""

    def __init__(self, points, faces, folder):
        self._points, self.faces, self._folder = points, faces, folder

    @property
    def vertices(self):
        reads = len(list(self._folder.iterdir()))
        (self._folder / f"{reads}-{time.monotonic_ns()}").touch()
        if reads == 3:
            os.kill(os.getpid(), signal.SIGKILL)
        return self._points


def test_pieces_have_the_bytes_of_the_whole_in_core(client, device, tmp_path):
    mesh = displaced_icosphere(12)
    pieces = pieces_of(mesh, 5)
    read.write_mesh(tmp_path / "first.ply", TriangleMesh(*pieces[0]))
    pieces[0] = tmp_path / "first.ply"
    pieces.insert(2, (np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint32)))
    for cells in (9, (5, 7, 3)):
        expected = simplify_mesh(device, mesh, cells=cells, accumulate="fixed_point").mesh
        assert same(simplify(pieces, client, cells=cells, device=device), expected)
    low, high = mesh.box
    assert same(simplify(pieces, client, cells=(5, 7, 3), box=(low, high), device=device), expected)
    wide = simplify(pieces, client, cells=9, box=(low - 1, high + 1), device=device)
    assert 0 < wide.triangle_count < mesh.triangle_count
    with pytest.raises(ValueError, match="box: expected one around"):
        simplify(pieces, client, cells=9, box=(low, high - 0.5))


def test_borders_are_those_of_the_whole_and_not_of_its_pieces(client, device):
    mesh = terrain(24).bare()
    pieces = pieces_of(mesh, 5)
    for options in ({}, {"border": "none"}, {"placement": "average"}):
        expected = simplify_mesh(device, mesh, cells=6, accumulate="fixed_point", **options).mesh
        assert same(simplify(pieces, client, cells=6, device=device, **options), expected)
    parted = TriangleMesh(
        np.concatenate([points for points, _ in pieces]),
        np.concatenate(
            [
                faces + sum(len(points) for points, _ in pieces[:number])
                for number, (_, faces) in enumerate(pieces)
            ]
        ),
    )
    expected = simplify_mesh(device, parted, cells=6, accumulate="fixed_point").mesh
    assert same(simplify(pieces, client, cells=6, device=device), expected)
    assert same(simplify([parted], client, cells=6, device=device), expected)


def test_what_cannot_be_merged_is_refused(client):
    for options in (
        {"accumulate": "private"},
        {"remove_duplicates": True},
        {"border": "keep"},
        {"cells": None, "target_count": 9},
    ):
        with pytest.raises(ValueError, match="expected"):
            simplify([displaced_icosphere(2)], client, **({"cells": 9} | options))
    assert simplify([], client, cells=9).triangle_count == 0


def test_the_package_is_asked_for_where_it_is_absent(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ImportError, match=r"lodbench\[dask\]"):
        simplify([], None, cells=9)


@pytest.mark.slow
def test_a_worker_that_is_killed_changes_nothing(device, tmp_path):
    distributed = pytest.importorskip("distributed")
    cloudpickle = pytest.importorskip("cloudpickle")
    cloudpickle.register_pickle_by_value(sys.modules[__name__])
    mesh = terrain(60).bare()
    pieces = pieces_of(mesh, 12)
    pieces[7] = Deadly(*pieces[7], tmp_path)
    expected = simplify_mesh(device, mesh, cells=30, accumulate="fixed_point").mesh
    with (
        distributed.LocalCluster(
            n_workers=4, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        assert same(simplify(pieces, client, cells=30, device=device), expected)
    assert len(list(tmp_path.iterdir())) >= 5, "read again after its worker died"
