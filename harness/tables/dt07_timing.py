"""Simplification by quadric clustering against what people would use instead: DeCoro & Tatarchuk 2007, slide 19."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from typing import Any

from lodbench.harness.plan.group import Context, Draw, Group, Subject
from lodbench.harness.plan.table import (
    FRAME_COLUMNS,
    QUALITY_COLUMNS,
    SLOPE_COLUMNS,
    WALL_COLUMNS,
    Column,
    Entry,
    Row,
    Table,
    brief,
    interval_columns,
    ratio_columns,
    stage_columns,
)
from lodbench.harness.report.ratios import counts, interval
from lodbench.harness.report.statistics import paired_ratio, summary

REDUCTION = 0.9
SCANS = ("bunny_69k", "armadillo_86k", "dragon_100k", "buddha_100k")
SERIES = ("displaced_icosphere_100k", "displaced_icosphere_1310k", "displaced_icosphere_10m")
SORTED = "displaced_icosphere_1310k_sorted"
QUICK_SERIES = ("displaced_icosphere_20k", "displaced_icosphere_100k", "displaced_icosphere_330k")
QUICK = (*SCANS[:2], *QUICK_SERIES)
GENERATED = {*SERIES, *QUICK_SERIES}
WEIGHTS = {SERIES[1]: 15.0, SORTED: 15.0, SERIES[2]: 120.0}  # seconds, about

OURS, CALL = "quadric_clustering", "simplify_call"
BASELINES = (
    "one_core",
    "numpy_quadric_clustering",
    "fast_simplification",
    "fast_simplification_careful",
)
PEERS = {  # label: (package, system), taken where the package is installed
    "vtk_quadric_clustering": ("vtkmodules", "vtk_quadric_clustering"),
    "vtk_binned_decimation": ("vtkmodules", "vtk_binned_decimation"),
    "meshoptimizer_sloppy": ("meshoptimizer", "meshoptimizer_sloppy"),
    "meshoptimizer_simplify": ("meshoptimizer", "meshoptimizer_simplify"),
}
PASSES = ("pass_1", "pass_2", "pass_3")
PASS_COLUMNS = stage_columns(PASSES)


def same_cells(context: Context) -> dict[str, Any]:
    """The grid that ours found."""
    return {"cells": context.counter(OURS, "cells_along_longest")}


def same_counts_per_axis(context: Context) -> dict[str, Any]:
    """The same number of cells per axis, for peers that divide the box evenly."""
    return {"cells": tuple(context.counter(OURS, f"cells_{axis}") for axis in "xyz")}


def same_count(context: Context) -> dict[str, Any]:
    """Exactly as many triangles as ours left."""
    return {"target_count": int(context.counter(OURS, "triangles"))}


def separate(context: Context) -> dict[str, Any]:
    """The same grid, three passes timed apart."""
    return {**same_cells(context), "strategy": "separate"}


def careful(context: Context) -> dict[str, Any]:
    """The same number of triangles, by a slowly rising threshold; in units in which it is not too low to get there."""
    return {**same_count(context), "aggressiveness": 3, "longest_side": 2.0}


def groups(quick: bool) -> list[Group]:
    """Scans (or their stand-ins) and one generated surface at several sizes; `quick`: two, to 330 thousand."""
    subjects = [
        Subject(OURS, {"target_reduction": REDUCTION}, draw=Draw(apart=True)),
        Subject(OURS, separate, "separate"),
        Subject(OURS, same_cells, "one_core", one_core=True),
        Subject(CALL, same_cells),
        Subject("numpy_quadric_clustering", same_cells),
        Subject("fast_simplification", same_count),
        Subject("fast_simplification", careful, "fast_simplification_careful"),
    ]
    for label, (package, system) in PEERS.items():
        if importlib.util.find_spec(package) is not None:
            params = same_counts_per_axis if label.startswith("vtk") else same_count
            subjects.append(Subject(system, params, label))
    names = QUICK if quick else (*SCANS, *SERIES, SORTED)
    return [
        Group(
            name,
            tuple(subjects),
            {"reduction": REDUCTION},
            True,
            weight=WEIGHTS.get(name, 4.0),
            standin_ok=name in SCANS,
        )
        for name in names
    ]


def _pass_1_share(entry: Entry) -> float | None:
    """The first pass's share of the device time, median over samples."""
    subject = entry.subject
    found = zip(subject.stage_s("pass_1"), subject.stage_s(), strict=True)
    middle = summary([first / whole for first, whole in found if whole > 0])
    return middle.median if middle else None


def _per_frame(entry: Entry) -> Row:
    """How many times as long as a frame the whole call takes."""
    call, frame = entry.subject, entry.group.subjects.get(OURS)
    if frame is None or not (counts(call) and counts(frame)):
        return {}
    seed = entry.group.config.get("seed", entry.run.environment["seed"])
    return interval("frames_per_call", paired_ratio(call.wall_s, frame.wall_s, seed))


def own(entry: Entry) -> Mapping[str, Any]:
    """The passes where they were timed apart, triangles per second, and what slide 19 says."""
    row, label = entry.row, entry.subject.label
    more: Row = {}
    if set(PASSES) <= set(entry.subject.stages):
        more |= {"pass_1_share": _pass_1_share(entry), "published_pass_1_share": 0.75}
    else:
        more |= {column.key: None for column in PASS_COLUMNS}
    if row["wall_s"]:
        more["triangles_per_s"] = row["triangles_in"] / row["wall_s"]
    if label == CALL:
        more |= _per_frame(entry)
    if label == OURS:
        more["published_ratio_to_cpu"] = 20
        if row["dataset"] in GENERATED:
            more["published_slope"] = 1
    return more


def line(row: Row) -> str | None:
    """The generated series, system by system."""
    return row["system"] if row["dataset"] in GENERATED else None


TABLE = Table(
    id="dt07_timing",
    title="Simplification by quadric clustering against its rivals, 90 % removed",
    source="DeCoro & Tatarchuk 2007, slide 19; published on an ATI GPU against a Pentium 4 3 GHz, as a chart",
    groups=groups,
    own=own,
    line=line,
    columns=(
        Column("dataset", "dataset", brief=True),
        Column("triangles_in", "triangles in"),
        Column("system", "system", brief=True),
        Column("cells", "cells"),
        Column("triangles_out", "triangles out", brief=True),
        Column("vertices_out", "points out"),
        *WALL_COLUMNS,
        Column("stage_s", "device time", "s"),
        *PASS_COLUMNS,
        Column("pass_1_share", "share of pass 1", "1"),
        Column("limit_share", "share of the device's limit", "1"),
        Column("triangles_per_s", "triangles in per second", "1/s"),
        *brief(FRAME_COLUMNS),
        *QUALITY_COLUMNS,
        *brief(
            interval_columns("frames_per_call", "frames that the call takes", ""), "frames_per_call"
        ),
        *ratio_columns((*BASELINES, *PEERS), shown=BASELINES[1:3]),
        *SLOPE_COLUMNS,
        Column("first_launch_s", "first launch", "s"),
        Column("memory_bytes", "memory", "B"),
        Column("stored_bytes", "stored", "B"),
        Column("published_ratio_to_cpu", "published times faster than a CPU", "1"),
        Column("published_pass_1_share", "published share of pass 1", "1"),
        Column("published_slope", "published slope", "1"),
    ),
    notes=(
        "Slide 19 shows a chart without numbers: the individual times were not found. Stated are an average of 20 "
        "times a CPU on large models, linear scaling, and about 75 % of the time in pass 1.",
        "Wall time of a frame with the mesh on the device; simplify_call is the whole Python call on an open device, "
        "from host arrays to host arrays, and is what a caller of fast_simplification would compare. The frames that "
        "it takes are counted turn by turn.",
        "The grid is searched once per dataset so that about 90 % of the triangles go; peers that take a count are "
        "asked for exactly as many triangles as quadric_clustering left, peers that take a grid get the same grid. "
        "Between counts that differ by more than 5 % there is no ratio.",
        "Edge collapse keeps the topology and clustering does not: read the error and edge columns beside the times. "
        "fast_simplification uses the package's own aggressiveness of 7, fast_simplification_careful 3 "
        "on the model scaled to a longest side of 2, since its threshold is absolute.",
        "Frame fps is that of simplifying and drawing the result at 1280 x 1024, in turns of their own after samples.",
        "one_core, separate and quadric_clustering give the same mesh bit for bit.",
        "Memory is a device subject's buffers; for a host subject its input and the rise of the process's peak during "
        "the first frame (Linux only), a lower bound: what a package kept from earlier calls is not counted again.",
        "The share of the device's limit is the least time for the bytes that must move and the operations that must "
        "be done, by the fill, copy and multiply-add rates measured in the same run, over the device time.",
        "The slope is that of log time over log size of one generated surface, with its 95 % interval.",
    ),
)
