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

CLUSTER_PLANE = 1e-4
"""A cell's representative off the plane that all its triangles lie in, in cells: float32 sums of A and b, a few units
in the last place of the distance to the grid's corner, and one division by a pivot."""

CLUSTER_RIDGE = 5e-3
"""A cube's corner against the representative of its cell, in cells: the ridge of 1e-3 against eigenvalues of a third
or less pulls it by that share of its way to the mean."""

TURN = 2 * EPSILON32
"""A sine or cosine near 1: the last rounding of a sum that is 1 at most, and that of the polynomial's argument."""

SHADE_LEVELS = 1.0
"""A shaded pixel against the formula in float64, in levels of 0..255: half a level of rounding, and what a corner moved
by half of 1/256 pixel changes in the weights."""

GL_VERTEX = 1e-6
"""A vertex stage's point (over the largest coordinate) or unit normal against a shader's: both sum three float32
products, a cubic's ten, in another order and with or without fusing, and divide by a root."""

GL_REPRESENTATIVE = 1e-2
"""The median representative of a cell against the published passes', in cells: along a flat surface the minimum is
soft, and sums of planes differ in float32; the largest is judged across the planes, by the quadric itself."""

GL_PSNR = 40.0
"""An image against a driver's away from outlines, dB: 40 is 2.5 levels of 255 on average."""

GL_COVERAGE = 1e-3
"""Share of pixels that one covers and the other does not: corners are snapped to the same 1/256 pixel, yet the products
that place them round differently, and centres on an edge may go to either side where the image is upside down."""

GL_DEPTH, GL_SHIFT = 2.0**-22, 2 / 256
"""Window depth against a driver's, 0..1: 24 bits there; and so many pixels' fall of the depth, as corners may snap to
neighbouring sub-pixels, across and down."""

QUADRIC_STEP = 8 * EPSILON32
"""Per unit of the condition number: a step, or a determinant, of a 3 x 3 quadric solved in float32 against float64."""

DIFFERENCES = 2e-3
"""A unit normal by central differences with a step of 2^-12 diagonals: points so close have lost 12 of 24 bits."""
