"""What the stored surface should be: the pattern's, at time 0."""

from lodbench.kernels.refine.pattern.reference import flat

__all__ = ["flat"]
