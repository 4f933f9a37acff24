"""What a verb gives: a mesh, and how it came about."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.arrays import Origin
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.opencl import Timeline
from lodbench.kernels.outputs import as_given


class Counters(Mapping[str, int | float]):
    """Counts by name; some that take long are made when one of them is first asked for."""

    def __init__(
        self,
        known: Mapping[str, int | float],
        later: tuple[str, ...] = (),
        make: Callable[[], Mapping[str, int | float]] = dict,
    ) -> None:
        """Those that are known, and what makes the rest.

        Args:
            known: by name.
            later: names of the others.
            make: gives all of those.
        """
        self._known, self._later, self._make = dict(known), later, make

    def __getitem__(self, name: str) -> int | float:
        if name in self._later:
            self._known |= self._make()
            self._later = ()
        return self._known[name]

    def __iter__(self) -> Iterator[str]:
        return iter((*self._known, *self._later))

    def __len__(self) -> int:
        return len(self._known) + len(self._later)

    def __repr__(self) -> str:
        return repr(dict(self))

    def also(self, known: Mapping[str, int | float]) -> Counters:
        """These and those."""
        return Counters({**self._known, **known}, self._later, self._make)


@dataclass(frozen=True, eq=False)
class Result:
    """What simplifying or refining a mesh gave.

    Attributes:
        mesh: the mesh, float32 positions from the origin of the input, and uint32 triangles, with normals and other
            attributes where the method makes or carries them.
        vertex_map: (n,) uint32, the output vertex of each input vertex, 0xFFFFFFFF where there is none; None where
            vertices do not map one to one.
        levels: all levels of a chain, coarsest last; (mesh,) where there is one.
        counters: sizes and choices of the method, by name; `dict(result.counters)` has all of them at once.
        setup, frame: where the time went, seconds by stage.
        level_maps: one for each level of a chain but the last: (n,) uint32, the vertex of the next level for each of
            its vertices, 0xFFFFFFFF where there is none.
        parts: a mesh for each part of the input that has a name, by that, where the method keeps them apart.
    """

    mesh: TriangleMesh
    vertex_map: NDArray[np.uint32] | None = None
    levels: tuple[TriangleMesh, ...] = ()
    counters: Mapping[str, int | float] = field(default_factory=dict)
    setup: Timeline = field(default_factory=Timeline)
    frame: Timeline = field(default_factory=Timeline)
    level_maps: tuple[NDArray[np.uint32], ...] = ()
    parts: Mapping[str, TriangleMesh] = field(default_factory=dict)

    def to(self, given: Any) -> Any:
        """The mesh as an object of the kind of `given`: see `outputs.as_given`.

        Raises:
            TypeError: of no such kind.
        """
        return as_given(self.mesh, given)


Told = Callable[[str, float], None]
"""(what is being done, share of the whole that is done, 0 to 1)"""


@dataclass(frozen=True)
class Left:
    """What a system leaves of a file that it simplified in batches.

    Attributes:
        vertices: (n, 3) float32, from the origin.
        origin: the file's, see `TriangleMesh`.
        numbers: the vertex of each number that stands for one in the temporary file, uint32.
        triangle_count: triangles left; three numbers each, uint32, are in the temporary file, in order.
        counters: as those of the same in core.
        attributes: of the vertices, (n, 3) float32, by their names in `TriangleMesh`.
    """

    vertices: NDArray[np.float32]
    origin: Origin | None
    numbers: NDArray[np.uint32]
    triangle_count: int
    counters: Mapping[str, int | float]
    attributes: Mapping[str, NDArray[np.float32]] = field(default_factory=dict)
