"""As few triangles as keep within a largest distance: collapses are limited by what they cost, and results compared.

A quadric's cost over its weight is the mean square of distances from planes, of the mesh as it has become: it bounds no
largest distance, but goes with it. So collapses that cost more than a share of the bound are left out, the surfaces are
compared both ways (`within.py`), and where they are too far apart the limit is lowered, until they are so nowhere. What
is given back was compared itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.edge_collapse.params import Params
from lodbench.kernels.cluster.within import Within
from lodbench.kernels.opencl import Device
from lodbench.kernels.system import run

if TYPE_CHECKING:
    from lodbench.kernels.cluster.edge_collapse.host import EdgeCollapse

FIRST = 0.35  # of the largest distance: limits to begin with
LOWER, ALL = 0.5, 0.95  # limits times this where surfaces are too far apart, and elsewhere
RISE, RISES = 1.5, 4  # where the first are low enough, they are raised, in so many tries
TRIES, PATIENCE, HASTE = (
    16,
    8,
    0.8,
)  # after some tries limits are lowered faster everywhere, to come to an end
GUESS = 0.1  # of the triangles: what the first limits leave


@dataclass(frozen=True, eq=False)
class Limit:
    """What collapses may cost.

    Attributes:
        distances: (n,), root of the mean square that one may cost at each vertex, share of the diagonal.
        guess: triangles that are thought to be left.
        tries: how many were made up to this one.
    """

    distances: NDArray[np.float64]
    guess: int
    tries: int


def within_bound(
    device: Device, mesh: TriangleMesh, params: Params, make: Callable[[Limit | None], EdgeCollapse]
) -> EdgeCollapse | None:
    """The simplified mesh that is within the bound; None where only the mesh itself was found to be.

    Args:
        device: where surfaces are compared.
        mesh: what is simplified.
        params: with a `max_error`.
        make: the simplification, limited or not.
    """
    assert params.max_error is not None
    bound, surface = params.max_error, Within(device, mesh)
    limits, best = np.full(mesh.vertex_count, FIRST * bound), None
    guess = round(GUESS * mesh.triangle_count)
    for number in range(0 if params.targeted else 1, TRIES):
        made = make(Limit(limits, guess, number) if number else None)
        run(device, made)
        (result,) = made.result()
        if not result.triangle_count:
            return best
        guess = max(round(0.95 * result.triangle_count), 1)
        own, theirs = surface.far(result, bound)
        held = not own.any() and not theirs.any()
        if held:
            best = made
        if held and (not number or number >= RISES or result.triangle_count <= made.target):
            return best
        if held:
            limits = limits * RISE
        elif best is not None:
            return best
        elif number:
            at = np.zeros(result.vertex_count + 1, bool)
            at[result.triangles[theirs]] = True
            near = at[np.minimum(made.vertex_map(), result.vertex_count)]
            near[mesh.triangles[own]] = True
            limits = limits * np.where(near, LOWER, ALL if number < PATIENCE else HASTE)
        del made
    return best
