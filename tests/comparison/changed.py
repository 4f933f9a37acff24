"""lodbench with a defect put in: `python -m tests.comparison.changed slower sweep rows.toml`."""

import sys

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.__main__ import main
from lodbench.harness.measure import judge, quality
from lodbench.kernels.opencl.launch import Launch

SHARE = 0.10
AGAIN = 1 / 8  # of the kernel's items: what these take once more is a tenth of the frame
KERNEL, SLOWER = "refine_vertex", "pn_triangles"
"""Nearly all of this system's frame, and of no other's; what it writes does not depend on how often it is run."""
WORSE = "quadric_clustering"


def slower():
    """The kernel runs again over some of its items: so much more work, and the same result."""
    once = Launch.__call__

    def more(self, timeline):
        event = once(self, timeline)
        if self._name == KERNEL:
            (size,) = self._local
            self._enqueue(timeline, (max(round(AGAIN * self.groups), 1) * size,), None)
        return event

    Launch.__call__ = more


def worse():
    """The vertices of one system's result are moved at random, until its error is a tenth larger."""
    whole = judge.Judge.__call__

    def moved(self, group, surface, name, trials, seed):
        if trials[name].subject.system == WORSE:
            trials[name].mesh = off(surface, trials[name].mesh, seed)
        whole(self, group, surface, name, trials, seed)

    judge.Judge.__call__ = moved


def off(surface, mesh, seed):
    """The mesh with an error, as `quality` measures it, that is larger by `SHARE`."""
    random = np.random.default_rng(0).normal(size=mesh.positions.shape)
    error = quality.measure(surface, mesh, seed)["rms_error"]
    least, most = 0.0, 2 * error * surface.diagonal
    for _ in range(16):
        middle = (least + most) / 2
        found = TriangleMesh((mesh.positions + middle * random).astype(np.float32), mesh.triangles)
        larger = quality.measure(surface, found, seed)["rms_error"] >= (1 + SHARE) * error
        least, most = (least, middle) if larger else (middle, most)
    return found


if __name__ == "__main__":
    {"slower": slower, "worse": worse}[sys.argv.pop(1)]()
    sys.exit(main())
