"""NURBS surfaces on uniform grids against NumPy, splipy and SciPy."""

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
PEERS = ("numpy_nurbs", "splipy_nurbs", "scipy_ndbspline")
NORMALS, ONE_CORE = "with_normals", "one_core"


def _groups(dataset: str, level: int) -> list[Group]:
    """Ours and one peer alone, so that nothing but the two takes the caches and the cores; then ours by itself."""
    size: dict[str, Any] = {"level": level}
    points = {**size, "normals": False}
    stair = Subject("uniform_nurbs", points, "stair")
    others = {peer: (Subject(peer, size),) for peer in PEERS}
    others["itself"] = (
        Subject("uniform_nurbs", size, NORMALS),
        Subject("uniform_nurbs", points, ONE_CORE, one_core=True),
    )
    standin_ok = dataset == "killeroo"
    return [
        Group(dataset, (stair, *more), {**size, "against": name}, standin_ok=standin_ok, warm=True)
        for name, more in others.items()
    ]


def groups(quick: bool) -> list[Group]:
    """One bicubic surface, large; then models, those that are there; `quick` has the first and a few generated ones."""
    from lodbench.datasets_gen import catalogue

    there = catalogue.names("nurbs")
    found = [name for name in MODELS if name in there] or [MODELS[0]]
    models = GENERATED if quick else (*found, *GENERATED)
    sizes = ((ONE, 9 if quick else 10), *((name, 5) for name in models))
    return [one for dataset, level in sizes for one in _groups(dataset, level)]


def own(entry: Entry) -> Mapping[str, Any]:
    """Points per second."""
    row = entry.row
    vertices, wall = row["vertices_out"], row["wall_s"]
    return {"vertices_per_s": vertices / wall if vertices and wall else None}


TABLE = Table(
    id="nurbs_grids",
    title="NURBS surfaces on uniform grids",
    source="Concheiro 2013, section 6.2 and figure 6.4a; peers: NumPy, splipy, SciPy",
    groups=groups,
    own=own,
    columns=(
        Column("dataset", "dataset", brief=True),
        Column("surfaces", "surfaces"),
        Column("quads", "KSQuads"),
        Column("level", "L", brief=True),
        Column("against", "against"),
        Column("system", "subject", brief=True),
        *WALL_COLUMNS,
        Column("stage_s", "device time", "s"),
        Column("basis_s", "basis functions", "s", brief=True),
        Column("vertices_out", "points", brief=True),
        Column("vertices_per_s", "points per second", "1/s", brief=True),
        *ratio_columns((*PEERS, ONE_CORE), shown=PEERS),
        *STATUS_COLUMNS,
    ),
    notes=(
        "A surface has 2^L segments along each side. Points alone, but for with_normals. NumPy's matrices of basis "
        "functions are made before its clock starts, those of the kernels in every frame.",
        "Each peer takes turns with ours alone, in a group of two: where several share a group, each finds the caches "
        "full of the others' points and the cores asleep or still held by others' threads. "
        "Every sample, ours or a peer's, follows at once on a frame of the same subject that is not timed.",
    ),
)
