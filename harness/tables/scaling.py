"""Quadric clustering by the number of cores: private maps against slabs, measured, then projected to more cores."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lodbench.harness.plan.group import Context, Group, Subject
from lodbench.harness.plan.table import WALL_COLUMNS, Column, Entry, Row, Table, ratio_columns

REDUCTION = 0.9
SCANS = ("bunny_69k", "armadillo_86k", "dragon_100k")
GENERATED = ("displaced_icosphere_1310k", "displaced_icosphere_1310k_sorted")
QUICK = (SCANS[1], "displaced_icosphere_330k_sorted")
CORES = (2, 4, 8, 16, 64)
QUICK_CORES = (2, 16, 64)
WAYS = ("private", "slabs")
FIRST = "private"  # finds the grid
PROJECTED = "projected_cores"


def same_cells(context: Context) -> dict[str, Any]:
    """The grid that private maps found."""
    return {"cells": context.counter(FIRST, "cells_along_longest")}


def private(context: Context) -> dict[str, Any]:
    """One map for each share of the triangles."""
    return {**same_cells(context), "accumulate": "private"}


def slabs(context: Context) -> dict[str, Any]:
    """The same maps, one item for each slab."""
    return {**same_cells(context), "accumulate": "slabs"}


def on_cores(way: str, cores: int) -> Any:
    """The params of a projection: a function, since they depend on the grid."""

    def projected(context: Context) -> dict[str, Any]:
        return {**same_cells(context), "accumulate": way, "cores": cores}

    projected.__qualname__ = f"{way}_on_{cores}"  # by which a group's hash knows it
    return projected


def groups(quick: bool) -> list[Group]:
    """Scans (or their stand-ins) and one generated surface in two orders of triangles; `quick`: one of each."""
    subjects = [
        Subject("quadric_clustering", {"target_reduction": REDUCTION, "accumulate": FIRST}, FIRST),
        Subject("quadric_clustering", slabs, "slabs"),
        Subject("quadric_clustering", private, "private_one_core", one_core=True),
        Subject("quadric_clustering", slabs, "slabs_one_core", one_core=True),
    ]
    subjects += [
        Subject(PROJECTED, on_cores(way, cores), f"{way}_on_{cores}")
        for cores in (QUICK_CORES if quick else CORES)
        for way in WAYS
    ]
    return [
        Group(name, tuple(subjects), {"reduction": REDUCTION}, weight=2.0, standin_ok=name in SCANS)
        for name in (QUICK if quick else (*SCANS, *GENERATED))
    ]


def own(entry: Entry) -> Mapping[str, Any]:
    """What a projection says in place of its wall time, which is that of one group after the other."""
    subject, row = entry.subject, entry.row
    if subject.system != PROJECTED:
        cores = (
            1
            if row["system"].endswith("_one_core")
            else entry.run.environment["device"].get("compute_units")
        )
        return {"cores": cores, "how": "measured"}
    found: Row = {column.key: None for column in (*WALL_COLUMNS, *ratio_columns((FIRST,)))}
    found["how"] = "projected"
    chains = {
        label: other.counters.get("chain_s")
        for label, other in entry.group.subjects.items()
        if other.status == "ok"
    }
    theirs, ours = chains.get(f"{FIRST}_on_{row['cores']}"), chains.get(row["system"])
    if theirs and ours:
        found["chain_ratio_to_private"] = theirs / ours
    return found


TABLE = Table(
    id="scaling",
    title="Quadric clustering by the number of cores, 90 % removed: measured on those there are, projected beyond",
    source="none published: DeCoro & Tatarchuk 2007 leave the sums to a GPU's blending",
    groups=groups,
    own=own,
    columns=(
        Column("dataset", "dataset", brief=True),
        Column("triangles_in", "triangles in"),
        Column("system", "subject", brief=True),
        Column("how", "measured or projected", brief=True),
        Column("cores", "cores", brief=True),
        Column("triangles_out", "triangles out"),
        *WALL_COLUMNS,
        *ratio_columns((FIRST,)),
        Column("chain_s", "longest chain, projected", "s", brief=True),
        Column("work_s", "work of one core", "s", brief=True),
        Column("chain_share", "longest chain of that", "1", brief=True),
        Column("chain_ratio_to_private", "projected times faster than private", "1", brief=True),
        Column("chain_pass_1_and_3_s", "passes 1 and 3 of the chain", "s"),
        Column("chain_pass_2_s", "pass 2 of the chain", "s"),
        Column("serial_s", "launches of one item", "s"),
        Column("launches", "launches"),
        Column("memory_bytes", "memory", "B"),
    ),
    notes=(
        "A projection is no measurement. The frame is cut as so many cores would cut it, every work-group runs alone "
        "on one core of this machine, and each launch lasts as long as its longest chain where every core takes the "
        "next group as it comes free; the chain is the sum over launches. It leaves out what a launch takes, and what "
        "cores cost each other in memory bandwidth and shared cache: an optimistic one. Read quiet runs alone: a "
        "long group that is never left undisturbed counts too long, and private's are the longest.",
        "The projection on two cores stands beside what two cores measured, where there are two.",
        "All rows of a dataset give the same mesh bit for bit: slabs sum each cell in the order of the private maps, "
        "and neither their number nor that of the cores is seen in it.",
        "private has two maps and so two items in its largest stage, whatever the cores; slabs lists the triangles of "
        "each run of cells first, which is more work in all.",
        "Seconds of a group are the least of all samples. A mesh has one slab for every 4,096 triangles at most, and "
        "pass 2 one item for every 4,096 cells: a scan of 100 thousand triangles does not fill 64 cores.",
        "The cell with the most corners is one item's: no number of cores takes less than that.",
    ),
)
