"""Is the output a surface like the input, and the map the one that it was made by?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.system import Check

if TYPE_CHECKING:
    from lodbench.kernels.cluster.edge_collapse.host import EdgeCollapse


def verdict(made: EdgeCollapse) -> Check:
    """Triangles are those of the input by the map, no two corners the same; and where the input has no edge of more
    than two triangles and no vertex of more than two open edges, neither has the output, nor more open edges, and
    vertices - edges + triangles are as many.
    """
    (mesh,) = made.result()
    given, sources = made.mesh, made.sources()
    mapped = made.vertex_map()[given.triangles[sources]].reshape(-1, 3)
    wrong = int((mapped != mesh.triangles).any(axis=1).sum())
    if wrong:
        return Check(False, "triangles unlike the input's by the map", wrong, 0)
    before, after = _counts(given.triangles), _counts(mesh.triangles)
    if after["whole"] < mesh.triangle_count:
        wrong = mesh.triangle_count - after["whole"]
        return Check(False, "triangles with a vertex twice", wrong, 0)
    if before["crowded"] or before["pinched"]:
        return Check(True, "triangles unlike the input's by the map", 0, 0)
    wrong = after["crowded"] + after["pinched"] + max(after["open"] - before["open"], 0)
    wrong += abs(after["euler"] - before["euler"])
    return Check(wrong == 0, "open or crowded edges and holes more than before", wrong, 0)


def _counts(triangles: NDArray[np.uint32]) -> dict[str, int]:
    """Triangles of three vertices, their edges of one triangle and of more than two, vertices where more than two of
    the former meet, and vertices - edges + triangles.
    """
    a, b, c = triangles.T
    t = triangles[(a != b) & (b != c) & (c != a)].astype(np.uint64)
    ends = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    keys = ends.min(axis=1, initial=2**32) << np.uint64(32) | ends.max(axis=1, initial=0)
    edges, uses = np.unique(keys, return_counts=True)
    rim = edges[uses == 1]
    met = np.unique(
        np.concatenate([rim >> np.uint64(32), rim & np.uint64(2**32 - 1)]), return_counts=True
    )[1]
    return {
        "whole": len(t), "open": int((uses == 1).sum()), "crowded": int((uses > 2).sum()),
        "pinched": int((met > 2).sum()), "euler": len(np.unique(t)) - len(uses) + len(t),
    }  # fmt: skip
