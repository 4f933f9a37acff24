"""What the libigl peers share: arrays as it wants them, and what it gives back."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.simplifier import meshes, peer
from lodbench.harness.baselines.subdivision import Peer, wide

INSTALL = "pip install libigl"


def subdivision(function: str, linear: bool) -> Peer:
    """A peer that calls `igl.<function>(V, F, times)`, V float64 and F int64."""

    def start(mesh: TriangleMesh, times: int) -> Callable[[], Any]:
        call = getattr(peer("igl", INSTALL), function)
        V, F = wide(mesh)
        return lambda: call(V, F, times)

    return Peer(start, lambda output: meshes(*output), linear)
