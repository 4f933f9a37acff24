"""Surfaces and KSQuads of each model: Concheiro 2013, table 6.2."""

from __future__ import annotations

from lodbench.datasets_gen import catalogue
from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.plan.table import STATUS_COLUMNS, Column, Table

MODELS = (
    "aorta_valve", "hammer_nd", "nacelle", "aircraft_wing", "hammer_occ", "ducky", "egg", "cylinder_rational",
)  # fmt: skip
GENERATED = ("rational_torus", "mixed_degrees", "quilt_4")


def groups(quick: bool) -> list[Group]:
    """The killeroo, the models that are there, and generated ones; `quick` has the killeroo and one of these."""
    there = set(catalogue.names("nurbs"))
    more = GENERATED[:1] if quick else (*(m for m in MODELS if m in there), *GENERATED)
    subject = Subject("uniform_nurbs", {"level": 2})
    return [
        Group(name, (subject,), once=True, standin_ok=name == "killeroo")
        for name in ("killeroo", *more)
    ]


TABLE = Table(
    id="rc13_6_2",
    title="Surfaces and KSQuads",
    source="Concheiro 2013, table 6.2 (killeroo, head, hinge, car), whose values were not at hand",
    groups=groups,
    columns=(
        Column("dataset", "dataset", brief=True),
        Column("surfaces", "surfaces", brief=True),
        Column("quads", "KSQuads", brief=True),
        Column("shared_edges", "borders that are one", brief=True),
        Column("open_edges", "open borders"),
        Column("collapsed_edges", "borders that are a point"),
        Column("system", "subject"),
        Column("wall_s", "one frame", "s"),
        *STATUS_COLUMNS,
    ),
    notes=(
        "Of the thesis's models the killeroo alone is to be had. Borders are one where control points, weights and "
        "knots are the same; the killeroo's other borders meet within some 1e-3 of its size, with other knots.",
    ),
)
