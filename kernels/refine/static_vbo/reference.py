"""What the stored surface should be: the pattern's, at time 0."""

from lodbench.kernels.refine.pattern.reference import refined

__all__ = ["refined"]
