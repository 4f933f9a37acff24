"""Named tolerances, each with the reason for its size."""

import numpy as np

EPSILON32 = float(np.finfo(np.float32).eps)
"""One unit in the last place at 1.0, float32."""

ROUNDING32 = 16 * EPSILON32
"""A short float32 expression against float64: a dozen roundings, relative to the largest operand."""

UNIT_LENGTH = 8 * EPSILON32
"""A normalised float32 vector's length against 1: three squares, a root and a division."""

SPHERE_DEGREE = 1e-6
"""How many times a map covers the sphere, against 1: a sum of spherical areas in float64; a fault is off by 1."""

FLOAT64_STAR = 1e-9
"""One sweep of the star optimisation, device against host, unit sphere: fused multiply-adds differ by 1e-16, which a
colour passes on to the next through steps of relative size 1e-6."""
