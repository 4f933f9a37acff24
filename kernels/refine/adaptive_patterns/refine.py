"""The verb refine of adaptive patterns."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lodbench.datasets_gen.arrays import BROKEN
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.opencl import Device
from lodbench.kernels.parameters import check
from lodbench.kernels.refine.adaptive_patterns.host import AdaptivePatterns
from lodbench.kernels.refine.adaptive_patterns.params import Params
from lodbench.kernels.refine.refining import refined
from lodbench.kernels.result import Result
from lodbench.kernels.system import Frame, View


def refine(
    device: Device,
    mesh: TriangleMesh,
    *,
    segments: int,
    weld: bool = True,
    time: float = 0.0,
    view: View | None = None,
    depths: ArrayLike | str | None = None,
    **options: Any,
) -> Result:
    """Every triangle split as its corners' depth tags ask, into segments^2 at the most.

    Args:
        device: where it runs.
        mesh: the coarse mesh.
        segments: a power of two, at most 128.
        weld: share the points on edges and corners between triangles; the coarse vertices in use then come first.
        time: of the displacement, s.
        view: what tags by distance and screen go by; None: nothing is far.
        depths: (n,) tags with by="given", or the name of a .npy file that holds them.
        **options: those of the Params.

    Raises:
        TypeError, ValueError: an argument is wrong.
        Unsupported: the device cannot hold the result.
    """
    params = Params.named(segments=segments, **options)
    check("weld", weld, bool)
    check("time", time, float)
    check("view", view, View | None)
    if isinstance(depths, str):
        depths = _read(depths)
    prepared = AdaptivePatterns(device, mesh, params, depths)
    return refined(device, prepared, mesh, Frame(view, time), weld)


def _read(path: str) -> ArrayLike:
    try:
        return np.load(path, allow_pickle=False)
    except BROKEN as error:
        raise ValueError(f"depths: expected a .npy file, got {path}: {error}") from None
