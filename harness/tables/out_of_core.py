"""Simplification of a file in batches against the same in core: memory, rate, and whether the bytes are the same."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.plan.table import WALL_COLUMNS, Column, Entry, Table, ratio_columns

HUGE = "LODBENCH_HUGE"
"""Set to anything in the environment: a hundred million triangles too, for which nothing is made in core."""

SYSTEM = "simplify_file"
IN_CORE, STREAMED = "in_core", "out_of_core"
SCAN, OPEN, GENERATED = "dragon_100k", "mountain_od", "displaced_icosphere_1310k"
FULL = (
    (SCAN, 20, 120.0, "128M"),
    (SCAN, 60, 170.0, "256M"),
    (SCAN, 200, 250.0, "512M"),
    (OPEN, 200, 200.0, "512M"),
    (GENERATED, 16, 250.0, "512M"),
)
QUICK = ((SCAN, 13, 100.0, "128M"),)
LARGEST = (SCAN, 1000, 400.0, "1G")


def _group(dataset: str, copies: int, cells: float, memory: str, compared: bool = True) -> Group:
    asked = {"cells": cells, "copies": copies}
    subjects = [
        Subject(
            SYSTEM, {**asked, "memory": memory, "measured": True, "compared": compared}, STREAMED
        )
    ]
    if compared:
        subjects.insert(0, Subject(SYSTEM, {**asked, "measured": True}, IN_CORE))
    if compared and (dataset, copies) in ((SCAN, 200), (SCAN, 13)):
        searched = {**asked, "cells": None, "target_reduction": 0.95, "memory": memory}
        subjects.append(Subject(SYSTEM, searched, f"{STREAMED}_target"))
    return Group(
        dataset,
        tuple(subjects),
        {"copies": copies},
        weight=copies / 5,
        standin_ok=dataset != GENERATED,
    )


def groups(quick: bool) -> list[Group]:
    """Copies of scans side by side, 2 to 20 million triangles, then of a surface in the order of subdivision."""
    found = [_group(*sizes) for sizes in (QUICK if quick else FULL)]
    if os.environ.get(HUGE) and not quick:
        found.append(_group(*LARGEST, compared=False))
    return found


def own(entry: Entry) -> Mapping[str, Any]:
    """Rate and memory, as the subject counted them."""
    counters, wall = entry.subject.counters, entry.row["wall_s"]
    read, same = counters.get("triangles_read"), counters.get("same_bytes")
    return {
        "triangles_read": read,
        "triangles_per_s": read / wall if read and wall else None,
        "same": None if same is None else "yes" if same else "no",
        **{key: counters.get(key) for key in ("file_bytes", "memory_limit_bytes", "peak_bytes")},
    }


TABLE = Table(
    id="out_of_core",
    title="Simplification of files in batches, against the same in core",
    source="Lindstrom 2000, Out-of-Core Simplification of Large Polygonal Models; no figures of it are repeated",
    groups=groups,
    own=own,
    columns=(
        Column("dataset", "dataset", brief=True),
        Column("copies", "copies", brief=True),
        Column("triangles_read", "triangles in the file", brief=True),
        Column("file_bytes", "file", "B", brief=True),
        Column("system", "subject", brief=True),
        Column("cells", "cells"),
        Column("triangles_out", "triangles out", brief=True),
        Column("memory_limit_bytes", "memory allowed", "B", brief=True),
        Column("peak_bytes", "peak above start", "B", brief=True),
        *WALL_COLUMNS,
        Column("triangles_per_s", "triangles in per second", "1/s", brief=True),
        *ratio_columns((IN_CORE,)),
        Column("same", "same bytes", brief=True),
    ),
    notes=(
        "Wall time from a file to a file, the file in the system's cache: parsing is part of it, in core and out of "
        "core. In core the whole file is read and checked as a mesh, then uploaded; most of that time is not the "
        "kernels'.",
        "The peak is that of a process of its own that makes the same call once, above what it had after a small "
        "file: pages of the mapped file that were resident at once are in it.",
        "Same bytes: of the two output files.",
        f"{OPEN} is open, so that the file is walked over twice more for its border edges.",
        "Vertices of the scans lie near their triangles' neighbours in the file; those of the generated surface, whose "
        "order is that of recursive subdivision, are gathered one by one.",
        f"out_of_core_target searches for the grid that leaves a twentieth: each of its counts is one more walk over "
        f"the file. With {HUGE} set in the environment there are 100 million triangles too, streamed alone.",
    ),
)
