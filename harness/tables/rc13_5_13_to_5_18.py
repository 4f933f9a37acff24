"""Handheld tessellation by level, patches to a draw and kind of memory: Concheiro 2013, figures 5.13 to 5.18."""

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

MEMORIES = ("uniform", "texture", "global")
LEVELS = (1, 2, 3, 4, 5)
PER_DRAW = (1, 7, 15, 128)
COPIES = (5, 20)


def groups(quick: bool) -> list[Group]:
    """Every level and size of a draw of five pots, and twenty pots at level 3; `quick` has five pots at level 3."""
    scenes = [(5, level) for level in LEVELS] + [(20, 3)]
    return [
        Group(
            f"teapot_x{copies}",
            (
                *(
                    Subject(
                        "vsthd",
                        {"level": level, "memory": memory, "surfaces_per_draw": each},
                        memory,
                    )
                    for memory in MEMORIES
                ),
                Subject("vst", {"level": level}),
            ),
            {"scene": f"S{copies}pots", "level": level, "surfaces_per_draw": each},
            standin_ok=True,
        )
        for copies, level in ([(5, 3)] if quick else scenes)
        for each in PER_DRAW
    ]


def own(entry: Entry) -> Mapping[str, Any]:
    """Microseconds of a draw."""
    row = entry.row
    draws, wall = entry.subject.counters.get("draws"), row["wall_s"]
    return {"draw_s": wall / draws if draws and wall else None}


TABLE = Table(
    id="rc13_5_13_to_5_18",
    title="Handheld tessellation by memory and patches to a draw",
    source="Concheiro 2013, figures 5.13 to 5.18; published on a Tegra 3, a Mali 400 and an Adreno, whose values were "
    "not at hand",
    groups=groups,
    own=own,
    columns=(
        Column("scene", "scene", brief=True),
        Column("level", "L", brief=True),
        Column("surfaces_per_draw", "N_d", brief=True),
        Column("system", "memory", brief=True),
        Column("draws", "draws", brief=True),
        Column("triangles_out", "triangles"),
        Column("map_bytes", "vertex buffer", "B"),
        *WALL_COLUMNS,
        Column("stage_s", "device time", "s"),
        Column("stage_fps", "stage fps", "1/s", brief=True),
        Column("draw_s", "of a draw", "s", brief=True),
        *ratio_columns(("texture", "global", "vst"), shown=("texture", "vst")),
        *STATUS_COLUMNS,
    ),
    notes=(
        "The same patches to the bit, wherever their control points lie. On a CPU all three memories are the same "
        "caches: a texture adds the call of a sampler for each of 16 texels of a patch.",
        "vst draws all patches at once, whatever N_d says. What a draw costs here is a launch.",
    ),
)
