"""What a handheld draw of patches needs: Concheiro 2013, tables 5.1 to 5.3."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.plan.table import STATUS_COLUMNS, Column, Entry, Table

COPIES = (1, 5, 20)
LEVELS = (1, 2, 3, 4, 5)
PER_DRAW = (7, 15)  # with room for 128 vectors in uniforms, and for 256


def groups(quick: bool) -> list[Group]:
    """Each scene of teapots at each level, in draws of either size; `quick` leaves out twenty pots."""
    made = []
    for copies in COPIES[:2] if quick else COPIES:
        subjects = tuple(
            Subject(
                "vsthd", {"level": level, "surfaces_per_draw": each}, f"level_{level}_by_{each}"
            )
            for level in LEVELS
            for each in PER_DRAW
        )
        facts = {"scene": f"S{copies}pots"}
        made.append(Group(f"teapot_x{copies}", subjects, facts, once=True, standin_ok=True))
    return made


def own(entry: Entry) -> Mapping[str, Any]:
    """Triangles in thousands."""
    triangles = entry.subject.counters.get("triangles")
    return {"triangles_k": triangles / 1000 if triangles else None}


TABLE = Table(
    id="rc13_5_1_to_5_3",
    title="What a handheld draw needs",
    source="Concheiro 2013, tables 5.1 to 5.3, whose values were not at hand",
    groups=groups,
    own=own,
    columns=(
        Column("scene", "scene", brief=True),
        Column("patches", "surfaces", brief=True),
        Column("level", "L", brief=True),
        Column("triangles_k", "triangles, thousands", brief=True),
        Column("surfaces_per_draw", "N_d", brief=True),
        Column("map_bytes", "vertex buffer", "B", brief=True),
        Column("draws", "draws (NDP)", brief=True),
        Column("uniform_vectors", "vectors in uniforms", brief=True),
        Column("dataset", "dataset"),
        Column("system", "subject"),
        Column("wall_s", "one frame", "s"),
        *STATUS_COLUMNS,
    ),
    notes=(
        "The vertex buffer holds u, v and the patch's number of each vertex of a draw, as there is no instancing: "
        "12 N_d (2^L + 1)^2 bytes. Uniforms hold 16 vectors of each patch and four of a matrix. All three are derived "
        "from the thesis's description, not read off it.",
    ),
)
