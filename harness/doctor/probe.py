"""Steps of the doctor that may crash or hang, each in a process of its own: `python -m <this module> STEP`.

The last line of standard output is what was found, as JSON; a driver's own output may stand before it.
"""

from __future__ import annotations

import json
import os
import sys
import time
from typing import Any


def devices() -> dict[str, Any]:
    """Pyopencl's version, and every platform and device that the loader finds."""
    import pyopencl  # where it is missing or broken, the error is what the doctor tells

    from lodbench.kernels.opencl.driver import list_devices

    found = [(index, platform, name) for index, platform, name, _ in list_devices()]
    return {"pyopencl": pyopencl.VERSION_TEXT, "devices": found}


def kernel() -> dict[str, Any]:
    """Build a kernel that no cache can hold yet, run it, and compare what it gives with numpy."""
    import numpy as np

    from lodbench.kernels.opencl import Device, Timeline

    device = Device.open()
    values = np.arange(1000, dtype=np.float32)
    result = device.upload("values", values)
    start = time.perf_counter()
    program = device.build("common/probe.cl", defines={"DOCTOR": time.time_ns() % (1 << 30)})
    launch = program.launch("probe", 1000, stage="probe", values=result, count=1000)
    launch(Timeline())
    device.wait()
    seconds = time.perf_counter() - start
    right = np.allclose(device.read(result), values / 256 + 2 * (1 - 1 / 256), rtol=1e-5)
    return {
        "device": device.facts.name,
        "driver": device.facts.driver,
        "compiles_for": device.facts.compiles_for,
        "seconds": seconds,
        "right": bool(right),
    }


def own() -> dict[str, Any]:
    """Run the project's own kernels out of the cache that they are kept in."""
    from lodbench.datasets_gen import catalogue
    from lodbench.kernels import refine, render, simplify

    mesh = catalogue.load("torus_20k").surface
    start = time.perf_counter()
    simplify(mesh, target_reduction=0.5)
    simplify(mesh, cells=4)
    refine(mesh, segments=4)
    render(mesh, size=(64, 64))
    return {"seconds": time.perf_counter() - start}


if __name__ == "__main__":
    found = {"devices": devices, "kernel": kernel, "own": own}[sys.argv[1]]()
    sys.stdout.write("\n" + json.dumps(found) + "\n")
    sys.stdout.flush()
    os._exit(0)  # some drivers abort on their way out, when all has been said
