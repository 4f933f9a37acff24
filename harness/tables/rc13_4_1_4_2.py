"""Triangles of non-adaptive, semi-adaptive and fully adaptive tessellation: Concheiro 2013, tables 4.1 and 4.2."""

from __future__ import annotations

from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.plan.table import STATUS_COLUMNS, Column, Table
from lodbench.harness.tables import rc13_3_1 as shared

COPIES = 5
MEDIUM, HIGH = 5, 6  # levels: three more than the coarse triangles'
KINDS = {"vst": "none", "semi_adaptive": "edges", "dabt": "edges and inside"}


def groups(quick: bool) -> list[Group]:
    """Scenes of five copies at the medium and the high degree; `quick` has the teapots at the first."""
    made = []
    for model in shared.MODELS[:1] if quick else shared.MODELS:
        for level in (MEDIUM,) if quick else (MEDIUM, HIGH):
            subjects = tuple(Subject(name, {"level": level}) for name in KINDS)
            facts = {"scene": f"S{COPIES} {model}", "level": level}
            made.append(Group(f"{model}_x{COPIES}", subjects, facts, once=True, standin_ok=True))
    return made


TABLE = Table(
    id="rc13_4_1_4_2",
    title="Triangles of adaptive tessellations",
    source="Concheiro 2013, tables 4.1 and 4.2, whose values were not at hand",
    groups=groups,
    own=lambda entry: {**shared.own(entry), "adapts": KINDS[entry.subject.system]},
    columns=(
        Column("scene", "scene", brief=True),
        Column("dataset", "dataset"),
        Column("patches", "surfaces", brief=True),
        Column("level", "L at the finest", brief=True),
        Column("system", "system", brief=True),
        Column("adapts", "tests"),
        Column("coarse_triangles", "coarse triangles"),
        Column("triangles_k", "triangles, thousands", brief=True),
        *(
            Column(f"level_{level}_triangles", f"coarse triangles of level {level}")
            for level in range(4)
        ),
        Column("vertices_out", "points"),
        Column("wall_s", "wall", "s"),
        *STATUS_COLUMNS,
    ),
    notes=(
        "Lmax = 3: coarse triangles are three levels below the finest. Table 4.1 has up to 32 segments along a side of "
        "a surface, table 4.2 higher factors, up to 64. Distance test, high quality.",
    ),
)
