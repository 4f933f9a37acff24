"""The forms that kernels have for graphics cards, tried on the processor: `Device.open(kind="gpu")`."""

import pytest

from lodbench.datasets_gen.patches import cup
from lodbench.datasets_gen.surfaces import BezierPatches, TriangleMesh
from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.plan.registry import systems
from lodbench.kernels.opencl import Device
from lodbench.kernels.system import run
from tests.fuzz.targets import check_mesh

GIVEN = {TriangleMesh: icosphere(2), BezierPatches: cup()}
NAMES = [
    name
    for name, system in systems().items()
    if system.runs_on == "device" and system.family != "baselines"
]


@pytest.fixture(scope="module")
def card():
    return Device.open(kind="gpu")


def result(device, name, surface):
    system = systems()[name]
    prepared = system.prepare(device, surface, next(iter(system.cases.values())))
    run(device, prepared)
    found = prepared.check()
    assert found.passed, f"{found.what}: {found.value} over {found.tolerance}"
    return prepared.result()


@pytest.mark.parametrize("name", NAMES)
def test_form_for_cards_gives_what_the_one_for_processors_gives(name, card, device):
    surface = next((s for k, s in GIVEN.items() if k in systems()[name].takes), None)
    if surface is None:
        pytest.skip("takes neither triangles nor patches")
    if name == "octree" and device.facts.platform.startswith("Intel"):
        pytest.skip(
            "Intel's compiler crashes where it puts sixteen items of this form into one loop"
        )
    mine, theirs = result(card, name, surface), result(device, name, surface)
    assert [mesh.triangle_count for mesh in mine] == [mesh.triangle_count for mesh in theirs]
    for mesh in mine:
        check_mesh(mesh)


def test_kind_comes_from_the_environment(monkeypatch):
    monkeypatch.setenv("LODBENCH_KIND", "gpu")
    opened = Device.open()
    assert (opened.is_cpu, opened.facts.kind) == (False, "gpu")
    monkeypatch.setenv("LODBENCH_KIND", "tpu")
    with pytest.raises(ValueError, match="LODBENCH_KIND: expected cpu or gpu, got 'tpu'"):
        Device.open()
