"""What raises a refined surface along its normals: a height over each point, on the device and in float64."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.refine.params import RefineParams

Doubles = NDArray[np.float64]
PERIOD = 256  # of the noise along each axis, in cells
SEED = 2002
FLOPS = {"sine": 90, "perlin": 250, "turbulence": 250}  # of a vertex; the noise's are an octave's


class Height(Protocol):
    """A height in float64.

    Attributes:
        a: amplitude, model units; 0 for none.
        slope: the most that the height rises per model unit, about.
        bend: how many times as fast its slope changes, 1 / model units.
    """

    @property
    def a(self) -> float: ...
    @property
    def slope(self) -> float: ...
    @property
    def bend(self) -> float: ...

    def __call__(self, points: Doubles) -> tuple[Doubles, Doubles, Doubles]:
        """Heights (...), their gradients (..., 3), and 1 where those are certain, 0 at a kink."""
        ...


@dataclass(frozen=True)
class Wave:
    """a sin(f |P| + phase): model units, radians per model unit, radians.

    Source: Boubekeur & Schlick 2005, section 4.
    """

    a: float = 0.0
    f: float = 0.0
    phase: float = 0.0

    @property
    def slope(self) -> float:
        """See `Height`."""
        return abs(self.a) * self.f

    @property
    def bend(self) -> float:
        """See `Height`."""
        return self.f

    def __call__(self, points: Doubles) -> tuple[Doubles, Doubles, Doubles]:
        """See `Height`."""
        r = np.linalg.norm(points, axis=-1)
        angle = self.f * r + self.phase
        steep = self.a * self.f * np.cos(angle) / np.where(r > 0, r, 1)
        return self.a * np.sin(angle), steep[..., None] * points, np.ones_like(r)


@cache
def permutation() -> NDArray[np.uint32]:
    """0 to 255 in a scattered order, twice, (512,): made here, not the historical table."""
    order = np.random.RandomState(SEED).permutation(PERIOD).astype(np.uint32)
    return np.concatenate([order, order])


def _gradients(h: NDArray[np.uint32]) -> Doubles:
    """The direction that the low four bits of a hash choose, (..., 3)."""
    h = h & 15
    one, two = np.where(h & 1, -1.0, 1.0), np.where(h & 2, -1.0, 1.0)
    again = (h == 12) | (h == 14)
    x = np.where(h < 8, one, 0) + np.where(again, two, 0)
    y = np.where(h < 8, 0, one) + np.where(h < 4, two, 0)
    return np.stack([x, y, np.where((h < 4) | again, 0, two)], axis=-1)


def noise(points: Doubles) -> tuple[Doubles, Doubles]:
    """Perlin's improved noise at (..., 3) points, in lattice cells, and its gradient (..., 3).

    Source: Perlin 2002, Improving Noise.
    """
    table = permutation()
    cell = np.floor(points)
    offset = points - cell
    corner = cell.astype(np.int64) & (PERIOD - 1)
    fade = offset**3 * (offset * (offset * 6 - 15) + 10)
    slope = 30 * offset**2 * (offset - 1) ** 2
    value, gradient = np.zeros(points.shape[:-1]), np.zeros(points.shape)
    for step in np.ndindex(2, 2, 2):
        i, j, k = (
            ((corner + step) % PERIOD)[..., 0],
            corner[..., 1] + step[1],
            corner[..., 2] + step[2],
        )
        direction = _gradients(table[(table[(table[i] + j) % PERIOD] + k) % PERIOD])
        weights = np.where(step, fade, 1 - fade)
        changes = np.where(step, slope, -slope)
        height = (direction * (offset - step)).sum(-1)
        value += weights.prod(-1) * height
        gradient += weights.prod(-1)[..., None] * direction
        for axis in range(3):
            others = np.delete(weights, axis, axis=-1).prod(-1)
            gradient[..., axis] += changes[..., axis] * others * height
    return value, gradient


@dataclass(frozen=True)
class Noise:
    """Octaves of noise, each twice as fine and half as high: a in model units, f in cells per model unit.

    Source: Perlin 2002; Boubekeur & Schlick 2005, section 4. Moving along z with time is a reconstruction.
    """

    a: float
    f: float
    shift: float  # cells along z
    octaves: int
    turbulent: bool

    @property
    def slope(self) -> float:
        """See `Height`."""
        return 2 * abs(self.a) * self.f * self.octaves

    @property
    def bend(self) -> float:
        """See `Height`."""
        return self.f * 2.0**self.octaves

    def __call__(self, points: Doubles) -> tuple[Doubles, Doubles, Doubles]:
        """See `Height`; turbulence has a kink wherever an octave is zero."""
        q = points * self.f + (0, 0, self.shift)
        heights, gradients = np.zeros(points.shape[:-1]), np.zeros(points.shape)
        certain = np.ones(points.shape[:-1])
        for octave in range(self.octaves):
            value, gradient = noise(q * 2.0**octave)
            if self.turbulent:
                certain *= np.abs(value) > 1e-3
                value, gradient = np.abs(value), gradient * np.sign(value)[..., None]
            heights += value * 0.5**octave
            gradients += gradient
        return self.a * heights, self.a * self.f * gradients, certain


@dataclass
class Displacement:
    """The displacement that params ask for, over a mesh: its kernels, their arguments, and its float64 form."""

    params: RefineParams
    mesh: TriangleMesh
    diagonal: float  # finite, with a finite inverse
    _unit: float = field(init=False)

    def __post_init__(self) -> None:
        away = float(np.abs(self.mesh.positions).max(initial=0))
        self._unit = max(self.diagonal, 2.0**-40 * away)  # squares of distances are finite

    @property
    def is_any(self) -> bool:
        """Is anything raised at all?"""
        return self.params.amplitude != 0

    @property
    def _is_noise(self) -> bool:
        return self.params.displacement != "sine"

    @property
    def files(self) -> tuple[str, ...]:
        """What is joined before the surface."""
        kind = "noise" if self._is_noise else "sine"
        return (f"common/{kind}.cl",) if self.is_any else ()

    @property
    def defines(self) -> dict[str, int]:
        """The constants of those files."""
        defines = {"DISPLACED": int(self.is_any)}
        if self.is_any and self._is_noise:
            turbulent = self.params.displacement == "turbulence"
            defines |= {"OCTAVES": self.params.octaves, "TURBULENT": int(turbulent)}
        return defines

    @property
    def flops(self) -> int:
        """Operations of a vertex."""
        params = self.params
        each = params.octaves if self._is_noise else 1
        return FLOPS[params.displacement] * each if self.is_any else 0

    def table(self) -> NDArray[np.uint32]:
        """What the kernels look up: the noise its permutation, the sine nothing."""
        return permutation() if self.is_any and self._is_noise else np.zeros(1, np.uint32)

    def value(self, time: float) -> tuple[float, float, float, float]:
        """The kernel's argument at `time`, s: amplitude in model units, waves per diagonal, phase, 1 / diagonal."""
        params = self.params
        phase = time % PERIOD if self._is_noise else -(time % 1.0)
        return params.amplitude * self.diagonal, params.waves, phase, 1 / self._unit

    def height(self, time: float) -> Height:
        """The same in float64."""
        amplitude, waves, phase, inverse = self.value(time)
        if not self._is_noise:
            return Wave(amplitude, 2 * np.pi * waves * inverse, 2 * np.pi * phase)
        turbulent = self.params.displacement == "turbulence"
        return Noise(amplitude, waves * inverse, phase, self.params.octaves, turbulent)
