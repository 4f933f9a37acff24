"""The quadtree walked from the root by a single work-item: the predecessor's way, on the same device.

Draws the same nodes, with the same fans, as `quadtree_lod`; only the order of the output's rows differs. It knows one
threshold for the whole model.

Source: Wang et al., introduction (the predecessor, Zhu, Liu & Zhang 2013, walks its tree on the CPU) and section 3.2.
"""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh
from lodbench.kernels.geometry_image.quadtree_lod import Params
from lodbench.kernels.geometry_image.serial_traversal.host import prepare
from lodbench.kernels.system import System

SYSTEM = System(
    name="serial_traversal",
    family="geometry_image",
    source="Wang, Liu, Feng & Li, section 3.2; Zhu, Liu & Zhang 2013",
    takes=(TriangleMesh, GeometryImage),
    prepare=prepare,
    cases={"thousandth": Params(n=6), "full": Params(n=6, threshold=0.0)},
)
