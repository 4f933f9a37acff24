"""Ways to cut KSQuads into KSDices, and other ways to draw the same surfaces: Concheiro 2013, table and figure 6.15."""

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
AREAS = (1, 8, 16)
LEVEL = 7
DRAW = Draw((1280, 1024))
UNIFORM = "uniform"


def _subjects(level: int, inside_out: bool) -> tuple[Subject, ...]:
    shared = {
        "level": LEVEL,
        "sampling": "adaptive",
        "dice_culling": True,
        "inside_out": inside_out,
    }

    def rpns(label: str, **options: Any) -> Subject:
        return Subject("rpns", shared | options, label, draw=DRAW)

    spans = {"level": level, "per": "span"}
    return (
        *(rpns(f"{area} pixels", pixel_area=float(area)) for area in AREAS),
        rpns("8 pixels, tolerant", pixel_area=8.0, edges="tolerant"),
        rpns("8 pixels, non-uniform", pixel_area=8.0, sampling="non_uniform"),
        rpns("one dice", sampling="one"),
        Subject("uniform_nurbs", spans, UNIFORM, draw=DRAW),
    )


def groups(quick: bool) -> list[Group]:
    """The killeroo, the models that are there and a torus; `quick` has the torus."""
    there = set(catalogue.names("nurbs"))
    models = GENERATED if quick else ("killeroo", *(m for m in MODELS if m in there), *GENERATED)
    return [
        Group(
            name,
            _subjects(2 if name == "killeroo" else 4, name in INSIDE_OUT),
            {"scene": name},
            standin_ok=name == "killeroo",
        )
        for name in models
    ]


def own(entry: Entry) -> Mapping[str, Any]:
    """Frames per second."""
    wall = entry.row["wall_s"]
    return {"whole_fps": 1 / wall if wall else None}


TABLE = Table(
    id="rc13_6_15",
    title="Sampling of KSDices",
    source="Concheiro 2013, table 6.15 and figure 6.15, whose values were not at hand",
    groups=groups,
    own=own,
    columns=(
        Column("dataset", "dataset", brief=True),
        Column("system", "subject", brief=True),
        Column("pixel_area", "pixels of a dice"),
        Column("quads_kept", "KSQuads left"),
        Column("dices", "KSDices", brief=True),
        Column("most_segments", "most segments"),
        Column("triangles_out", "triangles", brief=True),
        *WALL_COLUMNS,
        Column("whole_fps", "frame fps", "1/s", brief=True),
        *stage_columns(("cull", "lengths", "sizes", "dices", "emit", "raster", "fragment")),
        *ratio_columns((UNIFORM,)),
        *STATUS_COLUMNS,
    ),
    any_count=[
        *(f"{area} pixels" for area in AREAS),
        "8 pixels, tolerant",
        "8 pixels, non-uniform",
        "one dice",
        UNIFORM,
    ],
    notes=(
        "A sample is a whole frame at 1280 x 1024, the model in view: certified and dice culling; borders are "
        "watertight but for the tolerant. The table's fourteen implementations of DirectX 11 are not here.",
        "uniform: every KSQuad with 4 x 4 cells (killeroo) or 16 x 16, vertices shared, nothing culled.",
        "What is non-uniform is a reconstruction: places at even lengths on the screen.",
    ),
)
