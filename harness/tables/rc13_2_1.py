"""Triangles of each scene and level: Concheiro 2013, table 2.1."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.plan.table import STATUS_COLUMNS, Column, Entry, Table

MODELS = ("teapot", "teacup", "elephant_gumbo")
COPIES = (1, 5, 20)
LEVELS = (4, 5, 6)
MOST = 3_000_000  # triangles of a scene; more are the same again


def groups(quick: bool) -> list[Group]:
    """Every scene, its levels one after the other; `quick` has single models."""
    made = []
    for model in MODELS:
        patches = 128 if model.startswith("elephant") else 32  # at most, to choose by
        for copies in COPIES[:1] if quick else COPIES:
            levels = [level for level in LEVELS if copies * patches * 2 * 4**level <= MOST]
            subjects = tuple(Subject("vst", {"level": level}, f"level_{level}") for level in levels)
            if subjects:
                facts = {"scene": f"S{copies} {model}", "copies": copies}
                made.append(
                    Group(f"{model}_x{copies}", subjects, facts, once=True, standin_ok=True)
                )
    return made


def own(entry: Entry) -> Mapping[str, Any]:
    """Triangles in thousands, as the table counts them."""
    triangles = entry.subject.counters.get("triangles")
    return {"triangles_k": triangles / 1000 if triangles else None}


TABLE = Table(
    id="rc13_2_1",
    title="Triangles of the scenes",
    source="Concheiro 2013, table 2.1, whose values were not at hand",
    groups=groups,
    own=own,
    columns=(
        Column("scene", "scene", brief=True),
        Column("dataset", "dataset"),
        Column("patches", "surfaces", brief=True),
        Column("level", "L", brief=True),
        Column("system", "subject"),
        Column("triangles_k", "triangles, thousands", brief=True),
        Column("vertices_out", "points"),
        Column("stored_bytes", "stored", "B", brief=True),
        Column("wall_s", "one frame", "s"),
        *STATUS_COLUMNS,
    ),
    notes=(
        "S5 teapot are five copies of the model side by side: k * surfaces * 2 * 4^L triangles. What a scene is "
        "follows from the captions of the thesis's figures.",
        "The elephant is Catmull's Gumbo, of as many patches as the thesis's captions suggest.",
    ),
)
