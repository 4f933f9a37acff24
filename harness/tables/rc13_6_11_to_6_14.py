"""Frame rates with each culling technique, of KSQuads and of KSDices: Concheiro 2013, tables 6.11 to 6.14."""

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
    stage_columns,
)
from lodbench.harness.tables.rc13_6_3_to_6_6 import INSIDE_OUT

MODELS = ("aorta_valve", "nacelle", "ducky")
GENERATED = ("rational_torus",)
AREAS = (1.0, 8.0)
TECHNIQUES = ("none", "strong", "light", "certified")
NONE = TECHNIQUES[0]
DRAW = Draw((1280, 1024))
LEVEL = 7


def _subjects(area: float, inside_out: bool) -> tuple[Subject, ...]:
    found = []
    for dices in (False, True):
        for culling in TECHNIQUES:
            label = f"{culling} and dices" if dices else culling
            size = {"level": LEVEL, "sampling": "adaptive", "pixel_area": area}
            own = {
                "culling": culling,
                "dice_culling": dices,
                "edges": "tolerant",
                "inside_out": inside_out,
            }
            found.append(Subject("rpns", size | own, label, draw=DRAW))
    return tuple(found)


def groups(quick: bool) -> list[Group]:
    """The killeroo with dices of 1 and of 8 pixels, other models with 1; `quick` has the torus alone."""
    there = set(catalogue.names("nurbs"))
    scenes = [(name, AREAS[0]) for name in GENERATED]
    if not quick:
        scenes = [
            *(("killeroo", area) for area in AREAS),
            *((name, AREAS[0]) for name in MODELS if name in there),
            *scenes,
        ]
    return [
        Group(
            name,
            _subjects(area, name in INSIDE_OUT),
            {"pixel_area": area},
            standin_ok=name == "killeroo",
        )
        for name, area in scenes
    ]


def own(entry: Entry) -> Mapping[str, Any]:
    """Shares of all KSQuads, and frames per second."""
    counters, wall = entry.subject.counters, entry.row["wall_s"]
    if not counters.get("quads"):
        return {}
    return {
        "share_left": counters.get("quads_kept", 0) / counters["quads"],
        "whole_fps": 1 / wall if wall else None,
    }


TABLE = Table(
    id="rc13_6_11_to_6_14",
    title="Frame rates with culling of KSQuads and KSDices",
    source="Concheiro 2013, tables 6.11 to 6.14, whose values were not at hand. Gains of 2.37 (strong) and 2.86 "
    "(light) are of deformable models, GRAPP 2016",
    groups=groups,
    own=own,
    columns=(
        Column("dataset", "dataset", brief=True),
        Column("pixel_area", "pixels of a dice", brief=True),
        Column("system", "culling", brief=True),
        Column("share_left", "KSQuads left", "1", brief=True),
        Column("visible_lost", "of the visible, lost", "1", brief=True),
        Column("dices", "KSDices"),
        Column("triangles_out", "triangles", brief=True),
        *WALL_COLUMNS,
        Column("whole_fps", "frame fps", "1/s", brief=True),
        *stage_columns(("cull", "lengths", "sizes", "dices", "emit", "raster", "fragment")),
        *ratio_columns((NONE,)),
        *STATUS_COLUMNS,
    ),
    any_count=[f"{c}{d}" for c in TECHNIQUES for d in ("", " and dices")],
    notes=(
        "A sample is a whole frame at 1280 x 1024, the model in view: KSQuads are culled, sampled and drawn anew. "
        "Tolerant edges, as in the thesis.",
        "dices: those that face away are left out before they are drawn. The raster drops no back faces by itself.",
    ),
)
