"""Spherical parameterisation and geometry image of a closed genus-0 mesh: the set-up of the systems beside it.

Wang et al., section 2: the mesh is mapped to a sphere, the sphere to an octahedron, the octahedron unfolded into a
square, and the square sampled. The paper's own map (rays from the centre) turns triangles over on all but nearly
star-shaped models, so the default is a coarse-to-fine embedding after Praun & Hoppe 2003.
"""

from lodbench.kernels.geometry_image.parameterisation.checks import NotSpherical, topology
from lodbench.kernels.geometry_image.parameterisation.image import (
    Made,
    as_pictures,
    full_mesh,
    geometry_image,
    make,
)
from lodbench.kernels.geometry_image.parameterisation.params import MODES, Level, Mode, Seed, Turn
from lodbench.kernels.geometry_image.parameterisation.spherical import (
    NotOneToOne,
    SphericalMap,
    spherical_map,
)

__all__ = [
    "Level", "MODES", "Made", "Mode", "NotOneToOne", "NotSpherical", "Seed", "SphericalMap", "Turn", "as_pictures",
    "full_mesh", "geometry_image",
    "make", "spherical_map", "topology",
]  # fmt: skip
