"""What `rpns` costs in the picture: its frame against the same view of the model cut very fine, with nothing culled.

Source: Concheiro 2013, tables 6.7 to 6.10 (PSNR of culling), whose values were not at hand; the measure is ours.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.finest import finest
from lodbench.datasets_gen.nurbs_surface import NurbsModel
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.image import psnr
from lodbench.kernels.nurbs import rpns
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.render import mesh_view
from lodbench.kernels.stages.camera import TABLE_SIZE
from lodbench.kernels.stages.raster import EMPTY_ID, Raster, Side
from lodbench.kernels.subject import DeviceSubject
from lodbench.kernels.system import Check, Frame, Stored, System, Traffic, View, run

__all__ = ["Params", "RpnsPicture", "SYSTEM"]

FINE = rpns.Params(culling="none", sampling="adaptive", pixel_area=0.25)
MOST_PSNR = 99.0  # dB: equal pictures


@dataclass(frozen=True)
class Params(rpns.Params):
    """Those of `rpns`, and the picture's size.

    Attributes:
        width: of the image, pixels.
        height: of the image, pixels.
    """

    width: Side = TABLE_SIZE[0]
    height: Side = TABLE_SIZE[1]


@dataclass(frozen=True, eq=False)
class Picture:
    """A frame: (height, width, 3) uint8, and where the model is seen, (height, width)."""

    pixels: NDArray[np.uint8]
    seen: NDArray[np.bool_]


@lru_cache(maxsize=4)  # subjects of a group have the model and its view in common
def drawn(device: Device, model: NurbsModel, params: rpns.Params, view: View) -> Picture:
    """The picture of a model under `rpns`."""
    prepared = rpns.Rpns(device, model, params)
    raster = Raster(device, prepared.output, view.width, view.height, view=view)
    run(device, prepared, Frame(view), raster)
    return Picture(raster.image(), raster.keys()[1] != EMPTY_ID)


@lru_cache(maxsize=4)
def whole_view(model: NurbsModel, width: int, height: int) -> View:
    """As the tables see a model."""
    return mesh_view(finest(model), size=(width, height))


class RpnsPicture(DeviceSubject):
    """A frame that is drawn and read; it leaves no surface to draw."""

    def __init__(self, device: Device, model: NurbsModel, params: Params) -> None:
        super().__init__(device)
        names = [field.name for field in fields(rpns.Params)]
        self._params = rpns.Params(**{name: getattr(params, name) for name in names})
        self._model, self._view = model, whole_view(model, params.width, params.height)
        self._rpns = rpns.Rpns(device, model, self._params)
        with self.setup.host("build"), self.holding("scratch"):
            self._raster = Raster(
                device, self._rpns.output, params.width, params.height, view=self._view
            )

    def enqueue(self, frame: Frame, timeline: Timeline) -> None:
        """Draw the model whole, whatever the frame's view."""
        self.frame = Frame(self._view)
        self._rpns.enqueue(self.frame, timeline)
        self._raster(self._rpns.output, self.frame, timeline)

    def overflowed(self) -> bool:
        """That of `rpns`."""
        return self._rpns.overflowed()

    def grow(self) -> None:
        """That of `rpns`."""
        self._rpns.grow()

    def traffic(self) -> Mapping[str, Traffic]:
        """That of `rpns`, without the drawing."""
        return self._rpns.traffic()

    def live(self) -> tuple[int, int]:
        """Those that were drawn."""
        return self._rpns.live()

    def result(self) -> Sequence[TriangleMesh]:
        """What was drawn."""
        return self._rpns.result()

    def check(self) -> Check:
        """That of `rpns`."""
        return self._rpns.check()

    def more_counters(self) -> Mapping[str, int | float]:
        """Those of `rpns`; PSNR, dB, at most 99: of the whole picture and of where the model is in either; how many
        pixels would be others without culling.
        """
        device, model, view = self.device, self._model, self._view
        pixels, seen = self._raster.image(), self._raster.keys()[1] != EMPTY_ID
        same = {"inside_out": self._params.inside_out}
        finer = replace(FINE, level=min(self._params.level + 1, 10), **same)
        fine = drawn(device, model, finer, view)
        whole = drawn(
            device, model, replace(self._params, culling="none", dice_culling=False), view
        )
        model_there = fine.seen | seen
        found: dict[str, Any] = dict(self._rpns.more_counters())
        found["psnr"] = min(psnr(pixels, fine.pixels), MOST_PSNR)
        if model_there.any():
            found["model_psnr"] = min(psnr(pixels, fine.pixels, model_there), MOST_PSNR)
        found["pixels_changed"] = int((pixels != whole.pixels).any(axis=2).sum())
        found["pixels_seen"] = int(whole.seen.sum())
        return found

    def stored(self) -> Stored:
        """That of `rpns`."""
        return self._rpns.stored()


SYSTEM = System[Params](
    name="rpns_picture",
    family="baselines",
    source="Concheiro 2013, tables 6.7 to 6.10",
    takes=(NurbsModel,),
    prepare=RpnsPicture,
    cases={
        "table_size": Params(6, sampling="adaptive"),
        "small": Params(3, sampling="adaptive", width=160, height=128),
    },
    notes="rpns and its picture: PSNR against the same model cut very fine",
)
