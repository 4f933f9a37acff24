"""NURBS surfaces against exact values: one figure to a row, beside its limit. Systems of Concheiro 2013, chapter 6."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lodbench.datasets_gen import catalogue
from lodbench.harness.measure.exact import QUANTITIES
from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.plan.table import STATUS_COLUMNS, Column, Entry, Table, untimed
from lodbench.harness.tables.rc13_6_3_to_6_6 import INSIDE_OUT

MODELS = (
    "killeroo", "aorta_valve", "nacelle", "aircraft_wing", "ducky", "egg", "hammer_nd", "hammer_occ",
    "cylinder_rational",
)  # fmt: skip
GENERATED = (
    "rational_cylinder",
    "rational_ball",
    "rational_torus",
    "mixed_degrees",
    "quilt_4",
    "random_spans",
)
ONLY_QUICK = ("rational_torus", "mixed_degrees")
CONICS = {"cylinder": "rational_cylinder", "sphere": "rational_ball", "torus": "rational_torus"}
BASIS = ("stair", "basis", "unity", "end")
DEGREES, ONLY_QUICK_DEGREES = range(1, 8), (3, 5)
LEVEL = 2  # segments of a span, as a power of two
BASIS_LEVEL = 3
TOLERANCE = 1e-3
AREAS = (1, 8, 16)
SHARING = ("killeroo", "quilt_4")  # borders, where holes are looked for


def _group(dataset: str, name: str, *subjects: Subject) -> Group:
    return Group(
        dataset, subjects, {"quantity": name}, standin_ok=dataset == MODELS[0], once=True,
        exact=(name,),
    )  # fmt: skip


def _uniform(label: str = "", **size: Any) -> Subject:
    return Subject("uniform_nurbs", {"per": "span", **size}, label)


def _culled(model: str) -> Group:
    params = {"level": 0, "inside_out": model in INSIDE_OUT}
    return _group(
        model, "lost",
        *(
            Subject("rpns", params | {"culling": culling}, f"{culling} culling")
            for culling in ("certified", "light", "strong")
        ),
    )  # fmt: skip


def _cut(model: str, name: str, areas: Sequence[int]) -> Group:
    size = {"level": 6, "sampling": "adaptive", "culling": "none"}
    return _group(
        model, name,
        *(Subject("rpns", size | {"pixel_area": area}, f"{area} pixels") for area in areas),
        Subject("rpns", size | {"pixel_area": areas[-1], "edges": "tolerant"}, "tolerant edges"),
    )  # fmt: skip


def groups(quick: bool) -> list[Group]:
    """Basis functions, conics, then each quantity on every model; `quick` has a few of each."""
    there = set(catalogue.names("nurbs"))
    models = (MODELS[0], *(m for m in MODELS[1:] if m in there), *GENERATED)
    models = ONLY_QUICK if quick else models
    degrees = ONLY_QUICK_DEGREES if quick else DEGREES
    return [
        *(
            _group(f"sheets_degree_{degree}", name, _uniform("stair", level=BASIS_LEVEL))
            for degree in degrees
            for name in BASIS
        ),
        *(_group(model, name, _uniform(level=4)) for name, model in CONICS.items()),
        *(_group(model, "surface", _uniform(level=LEVEL)) for model in models),
        *(_group(model, "tolerance", _uniform(tolerance=TOLERANCE)) for model in models),
        *(_culled(model) for model in models),
        *(
            _cut(model, name, AREAS)
            for model in (SHARING[1:] if quick else SHARING)
            for name in ("seams", "holes")
        ),
    ]


def own(entry: Entry) -> Mapping[str, Any]:
    """The figure, its limit, whether it keeps to that, and how much it is of."""
    name = entry.group.facts.get("quantity", "")
    found = entry.subject.exact.get(name, {})
    value, limit = found.get("value"), found.get("limit")
    text = QUANTITIES[name].text if name in QUANTITIES else name
    kept = None if limit is None else value is not None and value <= limit
    return {
        "what": text, "value": value, "limit": limit, "kept": kept,
        "looked_at": found.get("looked_at"), **untimed(entry.row),
    }  # fmt: skip


TABLE = Table(
    id="nurbs_exactness",
    title="NURBS against exact values",
    source="none; systems of Concheiro 2013, chapter 6. Limits are ours",
    groups=groups,
    own=own,
    columns=(
        Column("what", "what", brief=True),
        Column("dataset", "dataset", brief=True),
        Column("system", "subject", brief=True),
        Column("value", "value", "1", brief=True),
        Column("limit", "limit", "1", brief=True),
        Column("kept", "kept", brief=True),
        Column("looked_at", "looked at", brief=True),
        Column("wall_s", "first frame", "s"),
        *STATUS_COLUMNS,
    ),
    notes=(
        "A row over its limit has failed. Where there is no limit, a figure is only told: strong and light culling are "
        "no proofs, and tolerant edges leave cracks.",
        "Basis functions: all that are not 0 at samples of sheets whose inner knots are uneven, one of them repeated "
        "as often as the degree; in float64 as the host has them, in float32 as the device does. 9.5e-7 is 8 units in "
        "the last place of 1.",
        "Points against SciPy's: the largest error of a coordinate, 4 segments on each span. Tolerance: 1e-3 of the "
        "box was asked for; distances are measured from the device's triangles to the surface in float64, at places "
        "other than those that chose the segments.",
        "Culling: from 5 views, near and far, 9 x 9 samples of each KSQuad; visible is what is in view and faces the "
        "eye. random_spans: 10,000 KSQuads of random degrees, knots, weights and places.",
        "Open edges and holes: 5 views, KSDices of 1, 8 and 16 pixels, watertight, nothing culled. Edges of triangles "
        "that no other has, to the bit, apart from borders of one surface alone, cut for 640 x 512 pixels; pixels of "
        "1280 x 1024 that show a loud background, around every pixel on a border that surfaces share and that the same "
        "model, cut five times finer than a pixel, covers.",
    ),
)
