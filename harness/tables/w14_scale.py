"""How the time of drawing a geometry image grows with its size: Wang et al., section 5, asks for it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from lodbench.harness.group import Draw, Group, Subject
from lodbench.harness.ratios import ratios
from lodbench.harness.record import GroupRecord, RunRecord
from lodbench.harness.tables import (
    FRAME_COLUMNS,
    WALL_COLUMNS,
    Column,
    Row,
    Table,
    measured,
    memory_bytes,
    ratio_columns,
)
from lodbench.harness.timing import log_slope

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


def rows(run: RunRecord, records: Sequence[GroupRecord]) -> list[Row]:
    """One row per subject and size; the last of each subject and share holds the fitted slope."""
    found = []
    for group in records:
        for subject in group.subjects.values():
            row = measured(group, subject)
            row |= ratios(group, subject, BASELINES, run.environment["seed"])
            row["memory_bytes"] = memory_bytes(group, subject)
            if row["wall_s"] and row["triangles_out"]:
                row["triangles_per_s"] = row["triangles_out"] / row["wall_s"]
            found.append(row)
    series: dict[tuple[str, str], list[Row]] = {}
    for row in found:
        if row["wall_s"] and row["status"] in ("ok", "noisy"):
            series.setdefault((row["system"], row["share"]), []).append(row)
    for line in series.values():
        fit = log_slope([row["triangles_out"] for row in line], [row["wall_s"] for row in line])
        if fit:
            line[-1]["slope"], line[-1]["slope_low"], line[-1]["slope_high"] = fit
    return found


TABLE = Table(
    id="w14_scale",
    title="Time against the size of the geometry image",
    source="Wang, Liu, Feng & Li, section 5 (larger models are named as further work)",
    groups=groups,
    rows=rows,
    columns=(
        Column("dataset", "dataset"),
        Column("n", "n"),
        Column("share", "triangles drawn"),
        Column("system", "system"),
        Column("triangles_out", "triangles"),
        *WALL_COLUMNS,
        Column("stage_s", "device time", "s"),
        *FRAME_COLUMNS,
        Column("triangles_per_s", "triangles per second", "1/s"),
        Column("slope", "slope", "1"),
        Column("slope_low", "slope, low", "1"),
        Column("slope_high", "slope, high", "1"),
        *ratio_columns(BASELINES),
        Column("stored_bytes", "stored", "B"),
        Column("memory_bytes", "memory", "B"),
    ),
    brief=(
        "n",
        "share",
        "system",
        "triangles_out",
        "wall_s",
        "frame_fps",
        "triangles_per_s",
        "slope",
        "ratio_to_serial_traversal",
        "ratio_to_static_vbo",
        "status",
    ),
    notes=(
        "slope: of the logarithm of the median wall time by that of the triangles, over all sizes of the subject; 1 is "
        "linear. Small images cost a launch's fixed price, which lowers it.",
        "Frame fps adds raster and shading at 1280 x 1024 with the whole surface in view.",
        "static_vbo: the full image stored and passed through the vertex stage, nothing chosen.",
    ),
)
