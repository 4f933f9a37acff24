"""A process of its own: prints by how many bytes a call of `simplify_file` raises its peak of resident memory."""

from __future__ import annotations

import json
import re
import resource
import sys
from pathlib import Path

from lodbench.datasets_gen import read
from lodbench.datasets_gen.triangles import icosphere
from lodbench.kernels.api import open_device
from lodbench.kernels.simplify_file import limited_device, simplify_file


def peak() -> int:
    """Bytes; on Linux those of this program alone, since what `getrusage` says began with the process that forked."""
    if sys.platform == "linux":
        (line,) = re.findall(r"VmHWM:\s*(\d+) kB", Path("/proc/self/status").read_text("utf-8"))
        return 1024 * int(line)
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def main(told: str) -> int:
    """The rise, bytes; what is imported and compiled for a small file counts as there before."""
    asked = json.loads(told)
    memory, out = asked["memory"], Path(asked["out"])
    device = open_device(None) if memory is None else limited_device(memory)
    read.write_mesh(out, icosphere(2))
    simplify_file(out, out, cells=4, device=device)
    before = peak()
    simplify_file(asked["source"], out, memory=memory, device=device, **asked["asked"])
    return peak() - before


if __name__ == "__main__":
    sys.stdout.write(f"{main(sys.argv[1])}\n")
