"""One pattern of several, and the parts in which the coarse triangles go through it."""

from __future__ import annotations

from dataclasses import dataclass, field

from lodbench.kernels.opencl import Buffer, Launch
from lodbench.kernels.refine.lattice import lattice_vertex_count
from lodbench.kernels.subject import Step
from lodbench.kernels.system import DeviceSurface


@dataclass
class Batch:
    """The coarse triangles from `first` on that one pass over the output holds."""

    first: int
    count: int
    launches: list[Launch] = field(default_factory=list)
    steps: list[Step] = field(default_factory=list)


@dataclass
class Level:
    """One pattern on the device, and the launches that draw the mesh with it."""

    segments: int
    weights: Buffer  # planes of u and v, float [2, stride]
    triangles: Buffer
    surface: DeviceSurface
    batches: list[Batch] = field(default_factory=list)

    @property
    def vertices(self) -> int:
        return lattice_vertex_count(self.segments)

    @property
    def steps(self) -> list[Step]:
        return [step for batch in self.batches for step in batch.steps]
