"""What raises a refined surface along its normals: a height over each point, on the device and in float64."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Floats, TriangleMesh
from lodbench.kernels.opencl import Device, Text
from lodbench.kernels.refine.params import RefineParams

Doubles = NDArray[np.float64]
PERIOD = 256  # of the noise along each axis, in cells
SEED = 2002


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

    def __call__(
        self, points: Doubles, normals: Doubles, wuv: Doubles, /
    ) -> tuple[Doubles, Doubles, Doubles]:
        """Heights (m, n), NaN at a jump, their gradients (m, n, 3), and 1 where those are certain, 0 at a kink.

        Args:
            points: on the surface, (m, n, 3).
            normals: there, of unit length.
            wuv: weights that they are at in each of m triangles, (n, 3).
        """
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

    def __call__(self, points: Doubles, *where: Doubles) -> tuple[Doubles, Doubles, Doubles]:
        """See `Height`: it depends on points alone."""
        r = np.linalg.norm(points, axis=-1)
        angle = self.f * r + self.phase
        steep = self.a * self.f * np.cos(angle) / np.where(r > 0, r, 1)
        return self.a * np.sin(angle), steep[..., None] * points, np.ones_like(r)


@cache
def permutation() -> NDArray[np.uint32]:
    """0 to 255 in a scattered order, twice, (512,): made here, not the historical table."""
    order = np.random.RandomState(SEED).permutation(PERIOD).astype(np.uint32)
    return np.concatenate([order, order], dtype=np.uint32)


def _gradients(h: NDArray[np.uint32]) -> Doubles:
    """The direction that the low four bits of a hash choose, (..., 3)."""
    h = h & np.uint32(15)
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

    def __call__(self, points: Doubles, *where: Doubles) -> tuple[Doubles, Doubles, Doubles]:
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


class Displacement:
    """What raises a surface over a mesh: its kernels, what they read, and its float64 form. This one raises nothing.

    Attributes:
        is_any: is anything raised at all?
        files: what is joined before the surface.
        flops: operations of a vertex.
        remark: what a check should say of its float64 form.
    """

    is_any = False
    files: tuple[str | Text, ...] = ()
    flops = 0
    remark = ""

    def __init__(self, params: RefineParams, mesh: TriangleMesh, diagonal: float) -> None:
        """`mesh` is a canonical one; `diagonal` is finite, with a finite inverse."""
        self.params, self.mesh, self.diagonal = params, mesh, diagonal
        away = float(np.abs(mesh.positions).max(initial=0))
        self._unit = max(diagonal, 2.0**-40 * away)  # squares of distances are finite

    @property
    def defines(self) -> dict[str, int]:
        """The constants of those files."""
        return {"DISPLACED": int(self.is_any)}

    def table(self) -> NDArray[np.uint32]:
        """What the kernels look up."""
        return np.zeros(1, np.uint32)

    def attributes(self) -> Floats | None:
        """What the kernels read of each triangle's corners, (m, 3, floats); None for nothing."""
        return None

    def value(self, time: float) -> tuple[float, float, float, float]:
        """The kernel's argument at `time`, s, as the struct in common/displacement.cl has it."""
        return 0.0, 0.0, 0.0, 1 / self._unit

    def height(self, time: float, rows: NDArray[np.int64], device: Device) -> Height:
        """The same in float64, over these coarse triangles."""
        return Wave()

    def check_heights(self, positions: Floats) -> None:
        """Refuse what a user's part has made of points, (n, 3)."""


class SineDisplacement(Displacement):
    """A wave around the origin."""

    is_any = True
    files = ("common/sine.cl",)
    flops = 90

    def value(self, time: float) -> tuple[float, float, float, float]:
        """See `Displacement`."""
        amplitude = self.params.amplitude * self.diagonal
        return amplitude, self.params.waves, -(time % 1.0), 1 / self._unit

    def height(self, time: float, rows: NDArray[np.int64], device: Device) -> Height:
        """See `Displacement`."""
        amplitude, waves, phase, inverse = self.value(time)
        return Wave(amplitude, 2 * np.pi * waves * inverse, 2 * np.pi * phase)


class NoiseDisplacement(Displacement):
    """Octaves of noise, or of its absolute values."""

    is_any = True
    files = ("common/noise.cl",)

    def __init__(self, params: RefineParams, mesh: TriangleMesh, diagonal: float) -> None:
        super().__init__(params, mesh, diagonal)
        self._turbulent = params.displacement == "turbulence"
        self.flops = 250 * params.octaves

    @property
    def defines(self) -> dict[str, int]:
        """See `Displacement`."""
        own = {"OCTAVES": self.params.octaves, "TURBULENT": int(self._turbulent)}
        return super().defines | own

    def table(self) -> NDArray[np.uint32]:
        """The permutation."""
        return permutation()

    def value(self, time: float) -> tuple[float, float, float, float]:
        """See `Displacement`."""
        amplitude = self.params.amplitude * self.diagonal
        return amplitude, self.params.waves, time % PERIOD, 1 / self._unit

    def height(self, time: float, rows: NDArray[np.int64], device: Device) -> Height:
        """See `Displacement`."""
        amplitude, waves, phase, inverse = self.value(time)
        return Noise(amplitude, waves * inverse, phase, self.params.octaves, self._turbulent)
