"""All surfaces on their grids, in one launch after that of the basis functions."""

from __future__ import annotations

from collections.abc import Mapping

from lodbench.datasets_gen.nurbs_surface import NurbsModel
from lodbench.kernels.nurbs.borders import borders_of
from lodbench.kernels.nurbs.tessellated import Tessellated, sampled
from lodbench.kernels.nurbs.tolerance import within
from lodbench.kernels.nurbs.uniform_nurbs.params import Params
from lodbench.kernels.opencl import Device


class UniformNurbs(Tessellated):
    """A model under uniform tessellation: see `lodbench.kernels.nurbs.uniform_nurbs`."""

    def __init__(self, device: Device, model: NurbsModel, params: Params) -> None:
        self._largest = None
        if params.tolerance is None:
            samples = sampled(model, params)
        else:
            samples, self._largest = within(model, borders_of(model), params.tolerance)
        super().__init__(device, model, params, samples)
        self.finish()

    def more_counters(self) -> Mapping[str, int | float]:
        """With a tolerance, also the largest distance that was measured, as a share of the box."""
        found = dict(super().more_counters())
        return found if self._largest is None else found | {"largest_distance": self._largest}
