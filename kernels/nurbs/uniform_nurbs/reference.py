"""Uniform tessellation in float64: each surface on the grid of its samples."""

from __future__ import annotations

from lodbench.datasets_gen.nurbs_surface import Doubles, NurbsModel
from lodbench.kernels.nurbs.params import NurbsParams
from lodbench.kernels.nurbs.reference import normals_at, points_at
from lodbench.kernels.nurbs.tessellated import sampled


def tessellated(model: NurbsModel, params: NurbsParams) -> list[tuple[Doubles, Doubles]]:
    """Points and unit normals of each surface, (rows, columns, 3) each."""
    samples = sampled(model, params)
    return [
        (points_at(surface, u, v), normals_at(surface, u, v)[0])
        for surface, (u, v) in zip(model.surfaces, samples, strict=True)
    ]
