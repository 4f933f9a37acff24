"""A geometry image at one detail everywhere: what choosing nodes by their error is measured against.

With as many cells as the image has it is the static vertex buffer of the full image, with half, a quarter ... its mip
levels. Other even numbers sample the image in between, so that triangle counts can be made equal.

Source: Gu, Gortler & Hoppe 2002, section 1 (level of detail by mip-mapping the image); Wang et al. have no such row.
"""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh
from lodbench.kernels.geometry_image.uniform_grid.host import prepare
from lodbench.kernels.geometry_image.uniform_grid.params import Params
from lodbench.kernels.system import System

__all__ = ["SYSTEM", "Params"]

SYSTEM = System(
    name="uniform_grid",
    family="geometry_image",
    source="Gu, Gortler & Hoppe 2002, section 1",
    takes=(TriangleMesh, GeometryImage),
    prepare=prepare,
    cases={"full": Params(n=6), "quarter": Params(n=6, target_count=2048)},
)
