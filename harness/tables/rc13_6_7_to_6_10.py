"""What culling and the size of KSDices cost in the picture: Concheiro 2013, tables 6.7 to 6.10."""

from __future__ import annotations

from typing import Any

from lodbench.datasets_gen import catalogue
from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.plan.table import STATUS_COLUMNS, Column, Table
from lodbench.harness.tables.rc13_6_3_to_6_6 import INSIDE_OUT

MODELS = ("aorta_valve", "nacelle", "ducky")
GENERATED = ("rational_torus",)
CULLING = ("none", "strong", "light", "certified")
AREAS = (1, 8, 16)
FINEST = 8
OF_MANY_SPANS = {"killeroo": 6}


def _subjects(name: str) -> tuple[Subject, ...]:
    def subject(label: str, **options: Any) -> Subject:
        finest = OF_MANY_SPANS.get(name, FINEST)
        size = {"level": finest, "sampling": "adaptive", "inside_out": name in INSIDE_OUT}
        return Subject("rpns_picture", size | options, label)

    return (
        *(subject(culling, culling=culling, pixel_area=1.0) for culling in CULLING),
        subject("dices", culling="none", dice_culling=True, pixel_area=1.0),
        subject("light and dices", culling="light", dice_culling=True, pixel_area=1.0),
        *(subject(f"{area} pixels", pixel_area=float(area)) for area in AREAS[1:]),
        subject("8 pixels, non-uniform", pixel_area=8.0, sampling="non_uniform"),
        subject("8 pixels, tolerant", pixel_area=8.0, edges="tolerant"),
        subject("one dice", sampling="one"),
    )


def groups(quick: bool) -> list[Group]:
    """The killeroo and other models with each technique, and at each area; `quick` has the torus alone."""
    there = set(catalogue.names("nurbs"))
    models = GENERATED if quick else ("killeroo", *(m for m in MODELS if m in there), *GENERATED)
    return [
        Group(
            name,
            _subjects(name),
            {"scene": name},
            once=True,
            standin_ok=name == "killeroo",
        )
        for name in models
    ]


TABLE = Table(
    id="rc13_6_7_to_6_10",
    title="PSNR of culling and of KSDices",
    source="Concheiro 2013, tables 6.7 to 6.10, whose values were not at hand",
    groups=groups,
    columns=(
        Column("dataset", "dataset", brief=True),
        Column("system", "subject", brief=True),
        Column("pixel_area", "pixels of a dice"),
        Column("quads", "KSQuads"),
        Column("quads_kept", "KSQuads left", brief=True),
        Column("triangles_out", "triangles", brief=True),
        Column("psnr", "PSNR, dB", brief=True),
        Column("model_psnr", "PSNR where the model is, dB", brief=True),
        Column("pixels_changed", "pixels that culling changes", brief=True),
        Column("pixels_seen", "pixels of the model"),
        Column("quads_lost", "KSQuads culled in error"),
        Column("wall_s", "one frame", "s"),
        Column("visible_lost", "of the visible samples", "1", brief=True),
        *STATUS_COLUMNS,
    ),
    notes=(
        "1280 x 1024, the model in view, against the same with 4 KSDices to a pixel and nothing culled. Techniques are "
        "compared with dices of 1 pixel, sizes with certified culling. 99 dB: no difference.",
        "A KSQuad is culled in error where one of its 9 x 9 sample points is in view and faces the eye; open surfaces "
        "show their backs where nothing is culled, so that culling changes their pictures without an error.",
    ),
)
