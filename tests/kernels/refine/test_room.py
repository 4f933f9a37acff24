"""What refining is said to take, against what it takes."""

import tracemalloc
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere
from lodbench.kernels import Unsupported, refine_mesh
from lodbench.kernels.opencl.device import Device
from lodbench.kernels.refine import pattern, room
from lodbench.kernels.refine.room import check_room, device_bytes, host_bytes


def with_attributes(mesh: TriangleMesh) -> TriangleMesh:
    n = mesh.vertex_count
    return replace(mesh, uvs=np.zeros((n, 2)), colours=np.zeros((n, 3)))


@pytest.mark.parametrize("weld", [True, False])
@pytest.mark.parametrize(
    ("mesh", "segments"),
    [(icosphere(1), 48), (with_attributes(icosphere(2)), 24), (icosphere(5), 2), (icosphere(5), 1)],
    ids=["deep", "attributes", "coarse", "as_it_came"],
)
def test_estimate_is_what_numpy_takes(device, mesh, segments, weld):
    refine_mesh(device, mesh, segments=segments, weld=weld)  # caches and imports are no part of it
    tracemalloc.start()
    result = refine_mesh(device, mesh, segments=segments, weld=weld)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert result.mesh.triangle_count == mesh.triangle_count * segments**2
    assert 0.97 * peak <= host_bytes(mesh, segments, weld) <= 1.35 * peak


@pytest.mark.parametrize("segments", [1, 7, 32])
def test_estimate_is_what_the_buffers_take(device, segments):
    mesh = icosphere(2)
    before = device.used_bytes
    prepared = pattern.Pattern(device, mesh, pattern.Params(segments))
    taken = device.used_bytes - before
    assert prepared.counters()["segments"] == segments
    assert taken == pytest.approx(device_bytes(mesh, segments), rel=0.01, abs=256)


def test_result_larger_than_memory_is_refused_before_any_work(device, monkeypatch):
    mesh = icosphere(2)
    with pytest.raises(ValueError, match=r"segments: expected at most 2\*\*32 vertices"):
        check_room(device, icosphere(5), 4000)
    needed = host_bytes(mesh, 16, True) + device_bytes(mesh, 16)
    for available, enough in ((needed, True), (needed - 1, not device.is_cpu)):
        memory = SimpleNamespace(available=available)
        monkeypatch.setattr(room.psutil, "virtual_memory", lambda memory=memory: memory)
        if enough:
            check_room(device, mesh, 16)
            continue
        with pytest.raises(Unsupported, match=r"segments: needs [\d,]+ bytes .* machine has"):
            refine_mesh(device, mesh, segments=16)
    check_room(device, mesh, 16, weld=False)


def test_several_passes_need_room_for_the_pieces_beside_the_result(monkeypatch):
    mesh = icosphere(2)
    needed = host_bytes(mesh, 16, True) + device_bytes(mesh, 16)
    memory = SimpleNamespace(available=needed)
    monkeypatch.setattr(room.psutil, "virtual_memory", lambda: memory)
    one, several = (Device.open(memory_limit=device_bytes(mesh, 16) - less) for less in (0, 1))
    check_room(one, mesh, 16)
    with pytest.raises(Unsupported, match=r"segments: needs [\d,]+ bytes"):
        check_room(several, mesh, 16)
