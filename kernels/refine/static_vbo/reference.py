"""What the stored surface should be: that of the system whose surface it is, at time 0."""

from lodbench.kernels.refine.pattern.reference import flat
from lodbench.kernels.refine.pn_triangles.reference import curved, curved_with_linear_normals
from lodbench.kernels.refine.st_triangles.reference import tagged

__all__ = ["curved", "curved_with_linear_normals", "flat", "tagged"]
