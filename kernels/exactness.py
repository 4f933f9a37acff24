"""How near tessellated points and normals are to float64: the limits of Bezier and NURBS systems, and the verdict."""

from __future__ import annotations

import numpy as np

from lodbench.kernels.system import Check

POSITION_LIMIT = 1e-6  # of the box's diagonal
NORMAL_LIMIT = np.deg2rad(0.1)
POSITION, NORMAL = "position", "normal"  # parts of the check


def verdict(position: float, normal: float, seen: str, wrong: float = 0.0) -> Check:
    """The check of points and normals, NaN being the worst of all.

    Args:
        position: largest error of a coordinate, as a share of the box's diagonal.
        normal: largest length of the difference of unit normals, which is the angle in radians; 0 where there are none.
        seen: how much was compared, such as "3 of 8 patches".
        wrong: anything else that is to be 1 at the most.

    Returns:
        The largest share of a limit, with the parts `POSITION`, as it came, and `NORMAL`, in degrees.
    """
    worst = float(np.max([position / POSITION_LIMIT, normal / NORMAL_LIMIT, wrong]))
    what = f"largest error, of points as a share of 1e-6 of the box and of normals as a share of 0.1 degree, {seen}"
    parts = {POSITION: float(position), NORMAL: float(np.rad2deg(normal))}
    return Check(worst <= 1, what, worst, 1.0, parts)
