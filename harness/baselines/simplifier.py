"""What the simplifying peers share: how many triangles are asked for, and whether that was kept."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.host import HostPrepared
from lodbench.kernels.cluster.grid import MAX_CELLS, Cells
from lodbench.kernels.cluster.search import Count, find_cells
from lodbench.kernels.cluster.target import GridTarget
from lodbench.kernels.opencl import Device, Timeline, Unsupported
from lodbench.kernels.system import Check
from lodbench.kernels.targets import Target, missed

DEFAULT = Target(target_reduction=0.9)


def peer(module: str, install: str) -> Any:
    """The peer's module, imported now.

    Raises:
        Unsupported: it is not installed, or does not load here.
    """
    try:
        return importlib.import_module(module)
    except (ImportError, OSError) as error:  # OSError: a wheel whose system library is missing
        raise Unsupported(
            f"needs {module}, this environment has none ({error}): {install}"
        ) from None


def asked(mesh: TriangleMesh, target: Target) -> int:
    """Triangles asked of a peer that takes a number of them: a tenth where no target is given."""
    if target.target_reduction is None and target.target_count is None:
        target = DEFAULT
    return target.triangles(mesh.triangle_count) or 0


def found_grid(
    mesh: TriangleMesh, params: GridTarget, count: Count, most_cells: int = MAX_CELLS
) -> tuple[Cells | None, dict[str, int | float]]:
    """The grid of a peer that has one, and its counters: as given, or searched for where a number is asked for.

    None where the mesh itself is what was asked for, or no grid comes nearer.

    Args:
        mesh: the input.
        params: what is asked for.
        count: how many triangles a grid leaves.
        most_cells: cells of the finest grid to try, in all.
    """
    target = params.triangles(mesh.triangle_count)
    if target is None:
        return params.grid_cells, {}
    low, high = mesh.box
    found = find_cells(count, high - low, mesh.triangle_count, target, most_cells)
    counters = {**missed(target, found.triangles), "counting_passes": found.counts}
    if found.cells is not None:
        counters["cells_along_longest"] = found.cells
    return found.cells, counters


def unchanged(
    device: Device, mesh: TriangleMesh, setup: Timeline, counters: Mapping[str, int | float]
) -> HostPrepared:
    """The mesh itself where no grid is to be run: the call copies it."""
    return HostPrepared(
        device,
        lambda _: (mesh.positions.copy(), mesh.triangles.copy()),
        read=lambda output: meshes(*output),
        verdict=at_most(mesh.triangle_count, slack=0.0),
        setup=setup,
        input_bytes=mesh.positions.nbytes + mesh.triangles.nbytes,
        count=lambda _: counters,
    )


def meshes(points: ArrayLike, faces: ArrayLike) -> list[TriangleMesh]:
    """A peer's arrays as one mesh.

    Raises:
        ValueError: not finite, or an index out of range.
    """
    return [TriangleMesh(np.asarray(points, np.float32), np.asarray(faces).reshape(-1, 3))]


def used_only(positions: NDArray[np.float32], triangles: NDArray[np.integer]) -> list[TriangleMesh]:
    """A mesh of the vertices that a triangle uses, in their order."""
    used = np.zeros(len(positions), bool)
    used[triangles.ravel()] = True
    rank = np.cumsum(used) - 1
    return meshes(positions[used], rank[triangles])


def at_most(target: int, slack: float) -> Callable[[Sequence[TriangleMesh]], Check]:
    """Judge: no more triangles than the target; finite positions and indices in range are checked by reading.

    `slack` is the share of the target by which the peer may miss it by its own account.
    """

    def verdict(result: Sequence[TriangleMesh]) -> Check:
        count = sum(mesh.triangle_count for mesh in result)
        excess = max(count - target, 0) / max(target, 1)
        return Check(excess <= slack, "triangles above the target, share of it", excess, slack)

    return verdict
