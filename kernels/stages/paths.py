"""Camera paths: the views of an eye that moves about a model, for frames one after the other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lodbench.kernels.parameters import Parameters, Range
from lodbench.kernels.stages.camera import TABLE_SIZE, fit_box, look_at, orbit
from lodbench.kernels.system import View

FAR = 16.0  # times the distance from which the model fills the image


@dataclass(frozen=True)
class CameraPath(Parameters):
    """A path and its frames.

    Attributes:
        kind: "turntable", once around at one distance; "orbit", once around while the eye draws back to 16 times that
            distance and returns; "fly_through", from 16 distances away straight through the model's middle, and as
            far again behind it.
        frames: how many views, at equal steps.
    """

    kind: Literal["turntable", "orbit", "fly_through"] = "orbit"
    frames: Annotated[int, Range(2, 10_000)] = 60

    def views(
        self, low: ArrayLike, high: ArrayLike, size: tuple[int, int] = TABLE_SIZE
    ) -> list[View]:
        """The views of a model in the box from `low` to `high`, (3,) each, in model units."""
        whole = fit_box(low, high, size=size)
        centre = (np.asarray(low, np.float64) + np.asarray(high, np.float64)) / 2
        near = float(np.linalg.norm(whole.eye - centre))
        steps = np.arange(self.frames) / self.frames
        if self.kind == "fly_through":
            along = np.linspace(FAR, -FAR, self.frames) * near
            return [_ahead(centre, (whole.eye - centre) / near, at, near, size) for at in along]
        away = np.ones(self.frames)
        if self.kind == "orbit":
            away = FAR ** np.sin(np.pi * steps) ** 2
        return [
            orbit(centre, near * distance, 360 * step, size=size)
            for step, distance in zip(steps, away, strict=True)
        ]


def _ahead(
    centre: NDArray[np.float64],
    direction: NDArray[np.float64],
    at: float,
    near: float,
    size: tuple[int, int],
) -> View:
    """The view forwards from `at` model units before the centre, along `direction` towards the eye."""
    eye = centre + direction * at
    far = abs(at) + 4 * near
    return look_at(eye, eye - direction * near, size=size, near=far * 1e-4, far=far)
