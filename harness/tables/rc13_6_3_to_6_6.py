"""KSQuads that each culling technique leaves, and what is lost with the others: Concheiro 2013, tables 6.3 to 6.6."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lodbench.datasets_gen import catalogue
from lodbench.harness.plan.group import Draw, Group, Subject
from lodbench.harness.plan.table import (
    STATUS_COLUMNS,
    WALL_COLUMNS,
    Column,
    Entry,
    Table,
    ratio_columns,
)

MODELS = ("aorta_valve", "nacelle", "ducky")
GENERATED = ("rational_torus",)
INSIDE_OUT = ("ducky", "egg")  # whose S_u x S_v points inwards
CULLING = ("none", "strong", "light", "certified")
LEVELS = (2, 3)
DRAW = Draw((1280, 1024))


def groups(quick: bool) -> list[Group]:
    """The killeroo at each level, then other models at the first; `quick` has one level of the killeroo and a torus."""
    there = set(catalogue.names("nurbs"))
    more = GENERATED if quick else (*(m for m in MODELS if m in there), *GENERATED)
    scenes = [("killeroo", level) for level in (LEVELS[:1] if quick else LEVELS)]
    scenes += [(name, LEVELS[0]) for name in more]
    return [
        Group(
            name,
            tuple(
                Subject(
                    "rpns",
                    {"level": level, "culling": culling, "inside_out": name in INSIDE_OUT},
                    culling,
                    draw=DRAW,
                )
                for culling in CULLING
            ),
            {"level": level},
            standin_ok=name == "killeroo",
        )
        for name, level in scenes
    ]


def own(entry: Entry) -> Mapping[str, Any]:
    """Shares of all KSQuads, and frames per second."""
    row = entry.row
    counters, wall = entry.subject.counters, row["wall_s"]
    quads, culled = counters.get("quads"), counters.get("quads_culled", 0)
    if not quads:
        return {}
    return {
        "share_left": counters.get("quads_kept", 0) / quads,
        "share_lost": counters.get("quads_lost", 0) / culled if culled else 0.0,
        "whole_fps": 1 / wall if wall else None,
    }


TABLE = Table(
    id="rc13_6_3_to_6_6",
    title="KSQuads left by culling",
    source="Concheiro 2013, tables 6.3 to 6.6; published on another machine, values were not at hand. "
    "The techniques' gains of 2.37 (strong) and 2.86 (light) are of deformable models, GRAPP 2016",
    groups=groups,
    own=own,
    columns=(
        Column("dataset", "dataset", brief=True),
        Column("level", "L", brief=True),
        Column("system", "culling", brief=True),
        Column("quads", "KSQuads", brief=True),
        Column("quads_kept", "KSQuads left", brief=True),
        Column("share_left", "left", "1", brief=True),
        Column("quads_lost", "culled in error", brief=True),
        Column("share_lost", "of the culled", "1"),
        Column("visible_lost", "of the visible samples", "1", brief=True),
        Column("triangles_out", "triangles"),
        *WALL_COLUMNS,
        Column("whole_fps", "frame fps", "1/s", brief=True),
        Column("cull_s", "culling", "s", brief=True),
        Column("dices_s", "vertices", "s"),
        Column("raster_s", "raster", "s"),
        *ratio_columns(("none",)),
        *STATUS_COLUMNS,
    ),
    any_count=CULLING,
    notes=(
        "Every KSQuad has 2^L segments along each side; a sample is a whole frame at 1280 x 1024, the model in view. "
        "A KSQuad is culled in error where one of its 9 x 9 sample points is in view and faces the eye.",
        "Which quads of a net light culling looks at is a reconstruction. Certified culling is ours: what it culls is "
        "shown to face away. With KSDices by pixels: see rc13_6_11_to_6_14.",
    ),
)
