"""What a reproduced table is: what it measures, its columns, and what it alone knows of a row."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from lodbench.harness.plan.group import Group
from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.kernels.parameters import closest

Row = dict[str, Any]
TABLES = "lodbench.harness.tables"


@dataclass(frozen=True)
class Column:
    """A column: its key in every row, its label for people, its unit ("" for a count, "1" for a share).

    `brief`: a terminal shows it; a table none of whose columns is brief shows all but quartiles and intervals.
    """

    key: str
    label: str
    unit: str = ""
    brief: bool = False


def brief(columns: Iterable[Column], *keys: str) -> tuple[Column, ...]:
    """The columns, of which those with these keys are shown by a terminal."""
    return tuple(replace(column, brief=column.key in keys) for column in columns)


@dataclass(frozen=True)
class Entry:
    """One subject of one group, and the row that every table has of it: see `harness.report.rows`."""

    run: RunRecord
    group: GroupRecord
    subject: SubjectRecord
    row: Row


@dataclass(frozen=True)
class Table:
    """A reproduced table.

    Attributes:
        id: the file's name.
        source: paper and figure or section; with the published hardware when there are published values.
        groups: quick -> what to measure.
        columns: every key that a row of any table has may be one; `harness.report.rows` says which there are.
        own: what this table alone says of a row, such as published values; it may overwrite.
        also: rows of which nothing was measured, after those of their group.
        line: rows for which it gives the same are points of one line of time over size, whose slope they get.
        size: the key of a line's size.
        any_count: labels of subjects that stand in a ratio whatever they leave, because that is the comparison.
        notes: what a reader must know, such as inconsistencies of the source.
    """

    id: str
    title: str
    source: str
    groups: Callable[[bool], Sequence[Group]]
    columns: Sequence[Column]
    own: Callable[[Entry], Mapping[str, Any]] = lambda entry: {}
    also: Callable[[GroupRecord], Sequence[Row]] = lambda group: ()
    line: Callable[[Row], Hashable | None] = lambda row: None
    size: str = "triangles_in"
    any_count: Sequence[str] = ()
    notes: Sequence[str] = ()

    @property
    def brief(self) -> list[str]:
        """Keys of the columns that a terminal shows; none: all but quartiles and intervals."""
        return [column.key for column in self.columns if column.brief]

    def named(self, prefix: str) -> list[str]:
        """Subjects that columns `<prefix>_<subject>` refer to, each once."""
        found = (
            c.key.removeprefix(f"{prefix}_") for c in self.columns if c.key.startswith(f"{prefix}_")
        )
        return [name for name in found if not name.endswith(("_low", "_high"))]


@cache
def tables() -> dict[str, Table]:
    """Every table of `harness/tables/`, by id."""
    package = importlib.import_module(TABLES)
    found = {}
    for module in pkgutil.iter_modules(package.__path__):
        table = getattr(importlib.import_module(f"{TABLES}.{module.name}"), "TABLE", None)
        if isinstance(table, Table):
            found[table.id] = table
    return found


def table(name: str) -> Table:
    """The table of this id.

    Raises:
        ValueError: no such table.
    """
    if name not in tables():
        raise ValueError(closest("table", name, tables()))
    return tables()[name]


def untimed(row: Row) -> Row:
    """The status where no time counts: what disturbed the samples is no matter."""
    return {"status": "ok", "reason": ""} if row["status"] == "noisy" else {}


STATUS_COLUMNS = (Column("status", "status", brief=True), Column("reason", "reason"))
WALL_COLUMNS = (
    Column("wall_s", "median wall", "s", brief=True),
    Column("wall_s_min", "least wall", "s"),
    Column("wall_s_lower", "lower quartile", "s"),
    Column("wall_s_upper", "upper quartile", "s"),
    Column("wall_error", "median within ±", "1"),
    Column("samples", "n"),
)
FRAME_COLUMNS = (
    Column("frame_fps", "frame fps", "1/s", brief=True),
    Column("frame_s", "median frame", "s"),
    Column("frame_s_lower", "frame, lower quartile", "s"),
    Column("frame_s_upper", "frame, upper quartile", "s"),
    Column("frames", "frames"),
)
PATH_COLUMNS = (
    Column("steps", "views", brief=True),
    Column("least_fps", "fps, slowest view", "1/s", brief=True),
    Column("most_fps", "fps, fastest view", "1/s", brief=True),
    Column("most_triangles", "most triangles", brief=True),
    Column("least_triangles", "fewest triangles", brief=True),
    Column("most_moved", "largest move between views", "1", brief=True),
)
BORDER_COLUMN = Column("border_error", "border's largest move", "1")

QUALITY_COLUMNS = (
    Column("rms_error", "RMS error", "1", brief=True),
    Column("rms_error_back", "RMS error back", "1"),
    Column("max_error", "largest error", "1"),
    Column("open_edges", "open edges"),
    Column("nonmanifold_edges", "non-manifold edges", brief=True),
    Column("flipped_triangles", "flipped triangles"),
)
SLOPE_COLUMNS = (
    Column("slope", "slope", "1"),
    Column("slope_low", "slope, low", "1"),
    Column("slope_high", "slope, high", "1"),
)


def interval_columns(key: str, label: str, more: str) -> tuple[Column, ...]:
    """A ratio and the ends of its interval."""
    return (
        Column(key, label, "1", brief=True),
        Column(f"{key}_low", f"... {more}low", "1"),
        Column(f"{key}_high", f"... {more}high", "1"),
    )


def ratio_columns(
    subjects: Iterable[str], shown: Iterable[str] | None = None
) -> tuple[Column, ...]:
    """The three columns of the ratio to each of these subjects; `shown`: those that are brief, None all."""
    found = tuple(
        column
        for name in subjects
        for column in interval_columns(
            f"ratio_to_{name}", f"times faster than {name}", f"than {name}, "
        )
    )
    return found if shown is None else brief(found, *(f"ratio_to_{name}" for name in shown))


def frame_ratio_columns(subjects: Iterable[str]) -> tuple[Column, ...]:
    """The same of whole frames."""
    return tuple(
        column
        for name in subjects
        for column in interval_columns(
            f"frame_ratio_to_{name}", f"frame fps over that of {name}", ""
        )
    )


def stage_columns(stages: Iterable[str]) -> tuple[Column, ...]:
    """The median seconds of each of these stages."""
    return tuple(Column(f"{name}_s", name.replace("_", " "), "s") for name in stages)
