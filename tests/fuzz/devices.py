"""Devices that lack memory, kernels that do not build, and every kernel under a simulator that watches.

Each returns `tries` and `losses`, of which there should be none.
"""

import json
import shutil
import tempfile
from pathlib import Path

from lodbench.datasets_gen.patches import cup
from lodbench.datasets_gen.surfaces import BezierPatches, TriangleMesh
from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.plan.registry import systems
from lodbench.kernels.opencl import Device, DeviceError
from lodbench.kernels.opencl.driver import Unsupported
from lodbench.kernels.system import run
from tests import test_oclgrind as simulated
from tests.fuzz.targets import check_mesh

BROKEN = (
    "float f(float x) { return y; }",
    "}",
    "#error no",
    "float f(",
    "__kernel void f(int *a) { a->b = 3; }",
    '#include "gone.h"',
)


def broken_kernels():
    """Programs that do not build: an error that names the file and the line, and the device goes on."""
    device, losses = Device.open(), []
    with tempfile.TemporaryDirectory() as folder:
        for number, text in enumerate(BROKEN):
            path = Path(folder, f"broken_{number}.cl")
            path.write_text(text)
            try:
                device.build(path)
                losses.append(f"{text!r} was built")
            except DeviceError as error:
                if path.name not in str(error):
                    losses.append(f"{text!r}: no word of its file: {str(error)[:200]}")
            except Exception as error:
                losses.append(f"{text!r}: {type(error).__name__}: {str(error)[:200]}")
    return {"tries": len(BROKEN), "losses": losses}


def little_memory(limits=(0, 100, 10_000, 100_000, 1_000_000)):
    """Systems on a device without memory for them: refused by what is lacking, or run in parts."""
    losses, tries = [], 0
    whole = Device.open()
    given = {TriangleMesh: icosphere(4), BezierPatches: cup()}
    for name, system in systems().items():
        surface = next((one for kind, one in given.items() if kind in system.takes), None)
        if system.runs_on != "device" or surface is None:
            continue
        for limit in limits:
            tries += 1
            device = Device(whole.handle, memory_limit=limit)
            try:
                prepared = system.prepare(device, surface, next(iter(system.cases.values())))
                run(device, prepared)
                for mesh in prepared.result():
                    check_mesh(mesh)
            except (Unsupported, MemoryError):
                pass
            except Exception as error:
                losses.append(
                    f"{name} with {limit} bytes: {type(error).__name__}: {str(error)[:200]}"
                )
    return {"tries": tries, "losses": losses}


def oclgrind():
    """Every system and shared stage on small inputs under the simulator, as `tests/test_oclgrind.py` has it."""
    if shutil.which("oclgrind") is None:
        return {"tries": 0, "losses": [], "skipped": "oclgrind is not on PATH"}
    losses, launched = [], set()
    for subject in simulated.SUBJECTS:
        returncode, said, errors = simulated.run_under_oclgrind(subject, 4 * simulated.TIMEOUT_S)
        if returncode:
            losses.append(f"{subject}: ended with {returncode}: {errors[-300:]}")
            continue
        told = json.loads(said.splitlines()[-1])
        launched |= set(told["launched"])
        losses += [f"{subject}: {one}" for one in simulated.reports(errors) + told["failed"]]
    written = simulated.written_kernels()
    losses += [
        f"never launched: {name}"
        for name in sorted(written - launched - set(simulated.NOT_LAUNCHED))
    ]
    counts = {"kernels": len(written & launched), "kernels_written": len(written)}
    return {"tries": len(simulated.SUBJECTS), "losses": losses, **counts}
