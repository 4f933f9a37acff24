"""What every subject promises, asked of each one that the registry finds."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from lodbench.datasets_gen.nurbs import ball
from lodbench.datasets_gen.patches import cup
from lodbench.datasets_gen.surfaces import BezierPatches, NurbsModel, TriangleMesh
from lodbench.harness.plan.registry import systems
from lodbench.kernels.opencl.device import Device
from lodbench.kernels.system import Footprint, Frame, Prepared, Timeline, Unsupported, run

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
    """Anew, of the first surface type that the system takes."""
    system = SYSTEMS[name]
    surface = next(surface for kind, surface in surfaces.items() if kind in system.takes)
    try:
        return system.prepare(device, surface, system.cases[case])
    except Unsupported as reason:
        pytest.skip(str(reason))


@dataclass(frozen=True)
class Subject:
    """One case, prepared, and its first frame: the same for all tests that ask, which run case by case."""

    name: str
    prepared: Prepared
    timeline: Timeline
    first: list[tuple[bytes, bytes]]


@pytest.fixture(scope="module", params=CASES, ids="-".join)
def subject(request, device):
    name, case = request.param
    prepared = prepare(name, case, device)
    timeline = run(device, prepared)
    return Subject(name, prepared, timeline, as_bytes(prepared.result()))


@pytest.fixture(scope="module")
def devices(device):
    """The default device, and others whose work-groups or cores are not the default's."""
    options = ({"local_size": 1}, {"local_size": 48}, {"one_core": True})
    return {"as it is": device} | {str(given): Device.open(**given) for given in options}


def as_bytes(meshes):
    return [(m.positions.tobytes(), m.triangles.tobytes()) for m in meshes]


def test_frame_passes_its_own_check(subject):
    check = subject.prepared.check()
    assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"
    assert subject.timeline.wall_s > 0
    if SYSTEMS[subject.name].runs_on == "device":
        assert subject.timeline.stage_s, "a device subject reports device seconds by stage"


def test_result_is_finite_and_in_range(subject):
    prepared = subject.prepared
    for mesh in prepared.result():
        assert np.isfinite(mesh.positions).all()
        assert mesh.triangles.size == 0 or mesh.triangles.max() < mesh.vertex_count
    assert all(value >= 0 for value in prepared.counters().values())
    assert isinstance(prepared.footprint(), Footprint)
    assert set(prepared.traffic()) <= set(subject.timeline.stage_s) | {"call"}


def test_two_frames_give_the_same_bytes(device, subject):
    run(device, subject.prepared, Frame())
    assert as_bytes(subject.prepared.result()) == subject.first


@pytest.mark.parametrize("name", [n for n, s in SYSTEMS.items() if s.runs_on == "device"])
def test_work_group_size_and_core_count_do_not_change_a_bit(devices, name):
    case = next(iter(SYSTEMS[name].cases))
    expected = None
    for options, other in devices.items():
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
