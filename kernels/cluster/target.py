"""The targets of a clustering: a number of triangles, or the grid itself."""

from __future__ import annotations

from dataclasses import dataclass, field

from lodbench.kernels.cluster.grid import Cells, check_cells
from lodbench.kernels.parameters import plain
from lodbench.kernels.targets import Target

DEFAULT_CELLS = 64


@dataclass(frozen=True)
class ClusterTarget(Target):
    """As `Target`; and what every clustering of ours is asked.

    Attributes:
        remove_duplicates: of output triangles with the same three vertices, whichever way they face, keep the first;
            a target counts what is left.
    """

    remove_duplicates: bool = field(default=False, kw_only=True)

    @property
    def uses_border(self) -> bool:
        """Must border edges be known?"""
        return self.keeps_border

    @property
    def keeps_border(self) -> bool:
        """Does every border vertex stay where it is, by itself?"""
        return False

    @property
    def grid_cells(self) -> Cells:
        """The grid asked for, where no number of triangles is."""
        raise NotImplementedError


@dataclass(frozen=True)
class GridTarget(Target):
    """What is asked for: at most one of the three; 64 cells where none is.

    Attributes:
        cells: cubic cells along the longest box edge (a real number: the last cell is cut), or (nx, ny, nz); at most
            2**27 in all.
    """

    cells: Cells | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "cells", plain(self.cells))
        if self.cells is not None:
            check_cells(self.cells)
        super().__post_init__()

    @property
    def grid_cells(self) -> Cells:
        """The grid asked for, where no number of triangles is."""
        return DEFAULT_CELLS if self.cells is None else self.cells
