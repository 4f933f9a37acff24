"""The surfaces by name, for systems that refine any of them."""

from __future__ import annotations

from lodbench.kernels.refine.params import SurfaceOptions
from lodbench.kernels.refine.pattern.surface import Flat
from lodbench.kernels.refine.pn_triangles.surface import PnSurface
from lodbench.kernels.refine.st_triangles.surface import StSurface
from lodbench.kernels.refine.surface import Surface


def chosen_surface(options: SurfaceOptions) -> Surface:
    """The surface that the options name, with those that it has."""
    if options.surface == "pn_triangles":
        return PnSurface(options)
    return StSurface(options) if options.surface == "st_triangles" else Flat()
