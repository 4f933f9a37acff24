"""The same bytes on every OpenCL driver for processors that is installed, against the default one."""

import hashlib

import pytest

from lodbench.datasets_gen.patches import cup
from lodbench.datasets_gen.triangles import displaced_icosphere, terrain
from lodbench.harness.plan.registry import system
from lodbench.kernels import render, simplify_mesh
from lodbench.kernels.opencl import Device, driver
from lodbench.kernels.system import run

OTHERS = [
    index
    for index, *_, handle in driver.list_devices()
    if handle.type & driver.opencl().device_type.CPU and handle != driver.choose_device("")
]


def digest(*arrays):
    return hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest()


def work(device):
    """Digests of a clustering in floats and in integers, an edge collapse, Bezier patches, and a picture."""
    mesh = displaced_icosphere(30)
    made = {
        "clustering": simplify_mesh(device, mesh, cells=12).mesh,
        "of an open mesh": simplify_mesh(device, terrain(30).bare(), cells=9).mesh,
        "in integers": simplify_mesh(device, mesh, cells=12, accumulate="fixed_point").mesh,
        "edge collapse": simplify_mesh(device, mesh, target_count=300, method="edge_collapse").mesh,
    }
    found = {name: digest(one.positions, one.triangles) for name, one in made.items()}
    owner = system("vst")
    prepared = owner.prepare(device, cup(), next(iter(owner.cases.values())))
    run(device, prepared)
    (patches,) = prepared.result()
    found["patches"] = digest(patches.positions, patches.triangles, patches.normals)
    for colour in ("smooth", "flat", "wireframe"):
        found[colour] = digest(render(patches, size=(160, 128), colour=colour, device=device))
    return found


@pytest.fixture(scope="module")
def expected():
    return work(Device(driver.choose_device("")))


@pytest.mark.skipif(not OTHERS, reason="no other driver for the processor is installed")
@pytest.mark.parametrize("index", OTHERS)
def test_every_driver_gives_the_same_bytes(index, expected):
    assert work(Device.open(index)) == expected
