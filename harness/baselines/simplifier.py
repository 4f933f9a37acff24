"""What the simplifying peers share: how many triangles are asked for, and whether that was kept."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.device import Unsupported
from lodbench.kernels.system import Check


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


@dataclass(frozen=True, kw_only=True)
class Target:
    """How far to go: `target_count` triangles at most, or else without `target_reduction` (0 to 1) of the input's."""

    target_count: int | None = None
    target_reduction: float = 0.9

    def __post_init__(self) -> None:
        if self.target_count is not None and self.target_count < 0:
            raise ValueError(f"target_count: expected 0 or more, got {self.target_count}")
        if not 0 <= self.target_reduction <= 1:
            raise ValueError(f"target_reduction: expected 0 to 1, got {self.target_reduction}")

    def triangles(self, mesh: TriangleMesh) -> int:
        """Triangles asked for; never more than there are."""
        if self.target_count is not None:
            return min(self.target_count, mesh.triangle_count)
        return round((1 - self.target_reduction) * mesh.triangle_count)


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

    def judge(result: Sequence[TriangleMesh]) -> Check:
        count = sum(mesh.triangle_count for mesh in result)
        excess = max(count - target, 0) / max(target, 1)
        return Check(excess <= slack, "triangles above the target, share of it", excess, slack)

    return judge
