"""How the time of drawing a geometry image grows with its size: Wang et al., section 5, asks for it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lodbench.harness.plan.group import Draw, Group, Subject
from lodbench.harness.plan.table import (
    FRAME_COLUMNS,
    SLOPE_COLUMNS,
    WALL_COLUMNS,
    Column,
    Entry,
    Row,
    Table,
    ratio_columns,
)

DATASET = "bunny_closed_70k"
LEVELS = (6, 7, 8, 9, 10, 11)
QUICK = LEVELS[:4]
BASELINES = ("serial_traversal", "static_vbo")
DRAW = Draw(apart=True)


def groups(quick: bool) -> list[Group]:
    """The full image, and half its triangles, at each size; `quick` stops at 524,288 triangles."""
    made = []
    for n in QUICK if quick else LEVELS:
        for share, count in (("all", None), ("half", 4**n)):
            # without a view, drawn or not: the count decides
            size: dict[str, Any] = {
                "n": n, "threshold": 0.0, "target_count": count, "view": "none",
            }  # fmt: skip
            subjects = [
                Subject("quadtree_lod", size, draw=DRAW),
                Subject("serial_traversal", size),
            ]
            if count is None:
                full = Subject("uniform_grid", {"n": n}, "static_vbo", case="full", draw=DRAW)
                subjects.append(full)
            facts = {"n": n, "share": share}
            weight = 2.0 + 12.0 * 4.0 ** (n - 11)
            made.append(Group(DATASET, tuple(subjects), facts, weight=weight, standin_ok=True))
    return made


def own(entry: Entry) -> Mapping[str, Any]:
    """Triangles drawn per second."""
    row = entry.row
    timed = row["wall_s"] and row["triangles_out"]
    return {"triangles_per_s": row["triangles_out"] / row["wall_s"]} if timed else {}


def line(row: Row) -> tuple[str, str]:
    """All sizes of a subject that draws the same share."""
    return row["system"], row["share"]


TABLE = Table(
    id="w14_scale",
    title="Time against the size of the geometry image",
    source="Wang, Liu, Feng & Li, section 5 (larger models are named as further work)",
    groups=groups,
    own=own,
    line=line,
    size="triangles_out",
    columns=(
        Column("dataset", "dataset"),
        Column("n", "n", brief=True),
        Column("share", "triangles drawn", brief=True),
        Column("system", "system", brief=True),
        Column("triangles_out", "triangles", brief=True),
        *WALL_COLUMNS,
        Column("stage_s", "device time", "s"),
        *FRAME_COLUMNS,
        Column("triangles_per_s", "triangles per second", "1/s", brief=True),
        *SLOPE_COLUMNS,
        *ratio_columns(BASELINES),
        Column("stored_bytes", "stored", "B"),
        Column("memory_bytes", "memory", "B"),
    ),
    notes=(
        "slope: of the logarithm of the median wall time by that of the triangles, over all sizes of the subject; 1 is "
        "linear. Small images cost a launch's fixed price, which lowers it.",
        "Frame fps adds raster and shading at 1280 x 1024 with the whole surface in view.",
        "static_vbo: the full image stored and passed through the vertex stage, nothing chosen.",
    ),
)
