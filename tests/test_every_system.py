"""What every subject promises, asked of each one that the registry finds."""

from dataclasses import replace

import numpy as np
import pytest

from lodbench.datasets_gen.nurbs import ball
from lodbench.datasets_gen.patches import cup
from lodbench.datasets_gen.surfaces import BezierPatches, NurbsModel, TriangleMesh
from lodbench.harness.plan.registry import systems
from lodbench.kernels.opencl.device import Device
from lodbench.kernels.system import Footprint, Frame, Unsupported, run

SYSTEMS = systems()
CASES = [(name, case) for name, system in SYSTEMS.items() for case in system.cases]


def sphere(rows=12, columns=18):
    """A closed UV sphere: 2 * columns * (rows - 1) triangles."""
    polar = np.linspace(0, np.pi, rows + 1)[1:-1]
    around = np.arange(columns) * 2 * np.pi / columns
    ring = np.stack(
        [
            np.outer(np.sin(polar), np.cos(around)),
            np.outer(np.sin(polar), np.sin(around)),
            np.outer(np.cos(polar), np.ones(columns)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    points = np.concatenate([ring, [[0, 0, 1], [0, 0, -1]]])
    top, bottom = len(ring), len(ring) + 1
    faces = []
    for c in range(columns):
        d = (c + 1) % columns
        faces.append((top, c, d))
        faces.append((bottom, (rows - 2) * columns + d, (rows - 2) * columns + c))
        for r in range(rows - 2):
            a, b = r * columns + c, r * columns + d
            faces += [(a, a + columns, b), (b, a + columns, b + columns)]
    return TriangleMesh(points, np.array(faces))


NONE = np.zeros((0, 3))
FULL = {TriangleMesh: sphere(), BezierPatches: cup(), NurbsModel: ball()}
EMPTY = {
    TriangleMesh: TriangleMesh(NONE, NONE.astype(int)),
    BezierPatches: BezierPatches(np.zeros((0, 4, 4, 3))),
    NurbsModel: NurbsModel(()),
}


def prepare(name, case, device, surfaces=FULL):
    """Of the first surface type that the system takes."""
    system = SYSTEMS[name]
    surface = next(surface for kind, surface in surfaces.items() if kind in system.takes)
    try:
        return system.prepare(device, surface, system.cases[case])
    except Unsupported as reason:
        pytest.skip(str(reason))


def as_bytes(meshes):
    return [(m.positions.tobytes(), m.triangles.tobytes()) for m in meshes]


@pytest.mark.parametrize(("name", "case"), CASES)
def test_frame_passes_its_own_check(device, name, case):
    prepared = prepare(name, case, device)
    timeline = run(device, prepared)
    check = prepared.check()
    assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"
    assert timeline.wall_s > 0
    if SYSTEMS[name].runs_on == "device":
        assert timeline.stage_s, "a device subject reports device seconds by stage"


@pytest.mark.parametrize(("name", "case"), CASES)
def test_result_is_finite_and_in_range(device, name, case):
    prepared = prepare(name, case, device)
    run(device, prepared)
    for mesh in prepared.result():
        assert np.isfinite(mesh.positions).all()
        assert mesh.triangles.size == 0 or mesh.triangles.max() < mesh.vertex_count
    assert all(value >= 0 for value in prepared.counters().values())
    assert isinstance(prepared.footprint(), Footprint)
    assert set(prepared.traffic()) <= set(run(device, prepared).stage_s) | {"call"}


@pytest.mark.parametrize(("name", "case"), CASES)
def test_two_frames_give_the_same_bytes(device, name, case):
    prepared = prepare(name, case, device)
    run(device, prepared, Frame())
    first = as_bytes(prepared.result())
    run(device, prepared, Frame())
    assert as_bytes(prepared.result()) == first


@pytest.mark.parametrize("name", [n for n, s in SYSTEMS.items() if s.runs_on == "device"])
def test_work_group_size_and_core_count_do_not_change_a_bit(device, name):
    case = next(iter(SYSTEMS[name].cases))
    expected = None
    for options in ({}, {"local_size": 1}, {"local_size": 48}, {"one_core": True}):
        other = Device.open(**options) if options else device
        prepared = prepare(name, case, other)
        run(other, prepared)
        got = as_bytes(prepared.result())
        expected = expected or got
        assert got == expected, options


@pytest.mark.parametrize("name", SYSTEMS)
def test_result_stands_where_the_input_does(device, name):
    offset = np.float32(1000)  # no origin: the points are float32 as they come
    patches, (surface,) = cup(), ball().surfaces
    far = {
        TriangleMesh: TriangleMesh(sphere().positions + offset, sphere().triangles),
        BezierPatches: BezierPatches(patches.points + offset),
        NurbsModel: NurbsModel((replace(surface, points=surface.points + offset),)),
    }
    prepared = prepare(name, next(iter(SYSTEMS[name].cases)), device, far)
    run(device, prepared)
    for result in prepared.result():
        assert result.origin is None
        assert np.abs(result.positions - offset).max() <= 2 * sphere().diagonal


@pytest.mark.parametrize(("name", "case"), CASES)
def test_no_triangles_in_no_triangles_out(device, name, case):
    prepared = prepare(name, case, device, EMPTY)
    run(device, prepared)
    assert all(mesh.triangle_count == 0 for mesh in prepared.result())
