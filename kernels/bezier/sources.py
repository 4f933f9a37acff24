"""Whose normals a patch has along its borders, for kernels whose vertices are not known beforehand."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.bezier.borders import Borders


def normal_sources(found: Borders) -> NDArray[np.uint32]:
    """Whose normals the edges and corners of patches have, (m, 8) as `bezier/cell.cl` reads them."""
    own = np.arange(found.owner.size).reshape(-1, 4)
    owner = np.where(found.smooth, found.owner, own)
    against = found.turned != found.turned.reshape(-1)[owner]
    return np.concatenate([2 * owner + against, found.corner_owner], axis=1).astype(np.uint32)
