"""The chosen method behind the contract."""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.auto.choice import choose
from lodbench.kernels.cluster.auto.params import Params
from lodbench.kernels.cluster.edge_collapse.params import DEFAULT_REDUCTION
from lodbench.kernels.opencl import Device
from lodbench.kernels.system import Prepared
from lodbench.kernels.targets import Target


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> Prepared:
    """What the method that is chosen prepares."""
    target = asked(params, mesh.triangle_count)
    system = choose(mesh, target).system
    own = type(next(iter(system.cases.values())))
    return system.prepare(device, mesh, own(target_count=max(target, 1)))


def asked(params: Target, triangle_count: int) -> int:
    """Triangles that may be left."""
    found = params.triangles(triangle_count)
    if found is None:
        found = Target(target_reduction=DEFAULT_REDUCTION).triangles(triangle_count)
    assert found is not None
    return found
