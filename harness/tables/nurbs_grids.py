"""NURBS surfaces on uniform grids against NumPy, splipy and SciPy, and the ways to evaluate basis functions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.plan.table import (
    STATUS_COLUMNS,
    WALL_COLUMNS,
    Column,
    Entry,
    Table,
    ratio_columns,
)

MODELS = ("killeroo", "aorta_valve", "hammer_nd", "nacelle", "ducky", "aircraft_wing")
GENERATED = ("rational_ball", "mixed_degrees")
ONE = "bicubic_12"
BASES = ("triangle", "cox_de_boor")
PEERS = ("numpy_nurbs", "splipy_nurbs", "scipy_ndbspline")
NORMALS, ONE_CORE = "with_normals", "one_core"


def _group(dataset: str, level: int, peers: tuple[str, ...], **facts: Any) -> Group:
    size: dict[str, Any] = {"level": level}
    points = {**size, "normals": False}
    subjects = (
        Subject("uniform_nurbs", points, "stair"),
        *(Subject("uniform_nurbs", {**points, "basis": basis}, basis) for basis in BASES),
        Subject("uniform_nurbs", size, NORMALS),
        Subject("uniform_nurbs", points, ONE_CORE, one_core=True),
        *(Subject(name, size) for name in peers),
    )
    facts = {"level": level, **facts}
    return Group(dataset, subjects, facts, standin_ok=dataset == "killeroo")


def groups(quick: bool) -> list[Group]:
    """One bicubic surface, large; then models, those that are there; `quick` has the first and a few generated ones."""
    from lodbench.datasets_gen import catalogue

    made = [_group(ONE, 9 if quick else 10, PEERS)]
    there = catalogue.names("nurbs")
    found = [name for name in MODELS if name in there] or [MODELS[0]]
    for name in GENERATED if quick else (*found, *GENERATED):
        made.append(_group(name, 5, PEERS[:2] if name == "killeroo" else PEERS))
    return made


def own(entry: Entry) -> Mapping[str, Any]:
    """Points per second."""
    row = entry.row
    vertices, wall = row["vertices_out"], row["wall_s"]
    return {"vertices_per_s": vertices / wall if vertices and wall else None}


TABLE = Table(
    id="nurbs_grids",
    title="NURBS surfaces on uniform grids",
    source="Concheiro 2013, sections 6.2, 6.5 and figure 6.4a; peers: NumPy, splipy, SciPy",
    groups=groups,
    own=own,
    columns=(
        Column("dataset", "dataset", brief=True),
        Column("surfaces", "surfaces"),
        Column("quads", "KSQuads"),
        Column("level", "L", brief=True),
        Column("system", "subject", brief=True),
        *WALL_COLUMNS,
        Column("stage_s", "device time", "s"),
        Column("basis_s", "basis functions", "s", brief=True),
        Column("vertices_out", "points", brief=True),
        Column("vertices_per_s", "points per second", "1/s", brief=True),
        *ratio_columns((*PEERS, "cox_de_boor", ONE_CORE), shown=PEERS),
        *STATUS_COLUMNS,
    ),
    notes=(
        "A surface has 2^L segments along each side. Points alone, but for with_normals. NumPy's matrices of basis "
        "functions are made before its clock starts, those of the kernels in every frame.",
        "Basis functions are evaluated once for each row and column of a grid, not for each point, and so take a small "
        "share of any frame.",
    ),
)
