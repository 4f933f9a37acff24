"""Which simplifier for which mesh: error against time at a tenth, 3 % and 1 % of the triangles, topology beside it."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from typing import Any

from lodbench.harness.plan import registry
from lodbench.harness.plan.group import Context, Group, Subject
from lodbench.harness.plan.table import (
    BORDER_COLUMN,
    QUALITY_COLUMNS,
    STATUS_COLUMNS,
    WALL_COLUMNS,
    Column,
    Entry,
    Table,
    ratio_columns,
)

SMOOTH = ("armadillo_86k", "dragon_100k", "buddha_100k", "koala_100k")
MACHINED = ("fandisk", "mechpart_g3", "rocker_arm")
OPEN = ("mountain_od",)
HOLED = ("bunny_69k", "beetle_open", "camelhead_open")
PARTS = ("cessna_11comp",)
GENERATED = ("displaced_icosphere_1310k_sorted", "displaced_icosphere_1310k")
KINDS = {
    **dict.fromkeys(SMOOTH, "smooth scan"), **dict.fromkeys(MACHINED, "machined part"),
    **dict.fromkeys(OPEN, "open terrain"), **dict.fromkeys(HOLED, "scan with holes"),
    **dict.fromkeys(PARTS, "many components"),
    **dict.fromkeys(GENERATED, "generated"),
}  # fmt: skip
QUICK = (SMOOTH[0], MACHINED[0])
CALLED = (*SMOOTH[2:], *HOLED, GENERATED[1])  # calls alone, and whom they are compared with
REDUCTIONS = (0.9, 0.97, 0.99)

COLLAPSE, CAREFULLY = "fast_simplification", "fast_simplification_careful"
CALL, ONE_CORE = "simplify_call", "edge_collapse_one_core"
COMPARED = (COLLAPSE, CAREFULLY, "meshoptimizer_simplify")
CAREFUL = {"aggressiveness": 3, "longest_side": 2.0}  # in units in which its threshold gets there
OURS = ("quadric_clustering", "octree", "edge_collapse")
PEERS = {  # label: (package, whether a number of triangles can be asked for)
    "meshoptimizer_simplify": ("meshoptimizer", True),
    "meshoptimizer_sloppy": ("meshoptimizer", True),
    "vtk_quadric_decimation": ("vtkmodules", True),
    "vtk_quadric_clustering": ("vtkmodules", False),
    "vtk_binned_decimation": ("vtkmodules", False),
    "pyfqmr": ("pyfqmr", True),
    "meshlib": ("meshlib", True),
}
SLOW = ("vtk_quadric_decimation", "pyfqmr", "meshlib")  # seconds at a million triangles
CALLS = ("quadric_clustering", "edge_collapse", "hybrid", "auto")  # as peers are called


def same_counts_per_axis(context: Context) -> dict[str, Any]:
    """The grid that quadric_clustering found, for peers that divide the box evenly."""
    return {"cells": tuple(context.counter(OURS[0], f"cells_{axis}") for axis in "xyz")}


def _group(dataset: str, reduction: float) -> Group:
    size = {"target_reduction": reduction}
    known = registry.systems()
    subjects = [Subject(name, size) for name in OURS if name in known]
    subjects += [
        Subject(CALL, {**size, "method": name}, f"{name}_call") for name in CALLS if name in known
    ]
    subjects += [
        Subject(CALL, {**size, "manifold": True}, "clustering_manifold_call"),
        Subject("edge_collapse", {**size, "form": "rounds"}, "edge_collapse_rounds"),
    ]
    if reduction == REDUCTIONS[0]:
        subjects.append(Subject("edge_collapse", size, ONE_CORE, one_core=True))
    subjects += [
        Subject(COLLAPSE, size),
        Subject(COLLAPSE, {**size, **CAREFUL}, CAREFULLY),
    ]
    for label, (package, counted) in PEERS.items():
        there = importlib.util.find_spec(package) is not None
        if there and not (dataset in GENERATED and label in SLOW):
            subjects.append(Subject(label, size if counted else same_counts_per_axis))
    if dataset in CALLED:
        subjects = [s for s in subjects if s.name.endswith("_call") or s.name in COMPARED]
    return Group(
        dataset, tuple(subjects), {"reduction": reduction, "kind": KINDS[dataset]}, quality=True,
        weight=25.0 if dataset in GENERATED else 3.0 if dataset in CALLED else 6.0, standin_ok=dataset not in GENERATED,
    )  # fmt: skip


def groups(quick: bool) -> list[Group]:
    """Scans, some with holes, parts, a terrain, a model of components, a generated surface; `quick` has two meshes."""
    return [
        _group(dataset, reduction)
        for dataset in (QUICK if quick else KINDS)
        for reduction in REDUCTIONS
    ]


def own(entry: Entry) -> Mapping[str, Any]:
    """The error as a share of fast-simplification's, and of its careful setting's."""
    found: dict[str, Any] = {}
    error = (entry.subject.quality or {}).get("rms_error")
    for key, label in (("rms_error_share", COLLAPSE), ("rms_error_share_of_careful", CAREFULLY)):
        other = entry.group.subjects.get(label)
        theirs = (other.quality or {}).get("rms_error") if other else None
        if error is not None and theirs:
            found[key] = error / theirs
    return found


TABLE = Table(
    id="pareto",
    title="Which simplifier for which mesh: error against time",
    source="ours: every method and every peer on smooth scans, machined parts, a terrain and a model of components",
    groups=groups,
    own=own,
    columns=(
        Column("dataset", "dataset", brief=True),
        Column("kind", "kind"),
        Column("reduction", "reduction", brief=True),
        Column("system", "system", brief=True),
        Column("triangles_in", "triangles in"),
        Column("triangles_out", "triangles out", brief=True),
        Column("vertices_out", "points out"),
        *WALL_COLUMNS,
        *QUALITY_COLUMNS,
        BORDER_COLUMN,
        Column("rms_error_share", "RMS error as a share of fast_simplification's", "1", brief=True),
        Column(
            "rms_error_share_of_careful",
            "the same of fast_simplification_careful's",
            "1",
            brief=True,
        ),
        *ratio_columns((COLLAPSE, CAREFULLY, ONE_CORE)),
        *STATUS_COLUMNS,
    ),
    notes=(
        "Wall time of a frame with the mesh on the device; of a whole call, from arrays to arrays, in rows that end in "
        "_call and of every peer. fast_simplification uses the package's own aggressiveness of 7, "
        "fast_simplification_careful 3 on the model scaled to a longest side of 2; where its last threshold is too low "
        "for the target it leaves more triangles, as the table shows.",
        "clustering_manifold_call is simplify_mesh(..., manifold=True), quadric_clustering with its sheets parted: a "
        "whole call from arrays to arrays, search for the grid included; triangles that backed each other are gone.",
        "Between counts that differ by more than 5 % there is no ratio of times; errors stand beside their counts. "
        "pyfqmr is the algorithm of fast_simplification in another binding.",
        "edge_collapse_rounds is edge_collapse in the form for GPUs: rounds of collapses all over the mesh at once.",
        "vtk_quadric_decimation, pyfqmr and MeshLib take too long for the generated surface to be in every run. "
        "MeshLib is free for non-commercial use only; nothing here installs it, and it has rows where it is there. "
        "manifold3d has none: whatever its tolerance, it stopped at 2.5 to 25 times the target on these scans.",
        "While constants were chosen, armadillo_86k, fandisk, rocker_arm, mechpart_g3, mountain_od and generated "
        "spheres were looked at, dragon_100k for its time alone; the other meshes were not.",
    ),
)
