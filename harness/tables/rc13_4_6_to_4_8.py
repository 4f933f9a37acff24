"""Fully, semi- and non-adaptive tessellation by error and frame rate: Concheiro 2013, figures 4.6 to 4.8."""

from __future__ import annotations

from lodbench.harness.plan.group import Draw, Group, Subject
from lodbench.harness.plan.table import (
    STATUS_COLUMNS,
    Column,
    Table,
    frame_ratio_columns,
    ratio_columns,
)
from lodbench.harness.tables import rc13_3_1 as shared

COPIES = 5
DRAW = Draw((1280, 1024), apart=True)
ERROR, FRAMES = "error", "frames"
THRESHOLDS = (3e-3, 1e-3, 3e-4, 1e-4)
PRICES = (1e-8, 1e-9, 1e-10)  # of the bound
MEDIUM, HIGH = 5, 6
BASELINES = ("vst", "dabt")


def _errors(model: str, level: int) -> Group:
    asked = [
        Subject(name, {"level": level, "threshold": threshold}, f"{name}_{threshold:g}")
        for name in shared.ADAPTIVE
        for threshold in THRESHOLDS
    ]
    asked += [
        Subject(shared.BOUND, {"level": level, "price": price}, f"{shared.BOUND}_{price:g}")
        for price in PRICES
    ]
    return Group(
        model, (*shared.uniform(), *asked, shared.reference()),
        {"work": ERROR, "scene": model, "level": level}, once=True, standin_ok=True,
        reference="reference", nearest=True, weight=2.0,
    )  # fmt: skip


def _frames(model: str, level: int) -> Group:
    size = {"level": level}
    subjects = tuple(Subject(name, size, draw=DRAW) for name in ("vst", "semi_adaptive", "dabt"))
    facts = {"work": FRAMES, "scene": f"S{COPIES} {model}", "level": level}
    return Group(f"{model}_x{COPIES}", subjects, facts, weight=2.0, standin_ok=True)


def groups(quick: bool) -> list[Group]:
    """Errors of two models, frames of scenes at two degrees; `quick` has one of each."""
    errors = [_errors("teacup", MEDIUM)]
    if not quick:
        errors += [_errors("elephant_gumbo", MEDIUM)]
    levels = (MEDIUM,) if quick else (MEDIUM, HIGH)
    models = shared.MODELS[:1] if quick else shared.MODELS
    return [*errors, *(_frames(model, level) for level in levels for model in models)]


TABLE = Table(
    id="rc13_4_6_to_4_8",
    title="Fully, semi- and non-adaptive tessellation",
    source="Concheiro 2013, figures 4.6 to 4.8, whose values were not at hand; its successor at GRAPP 2014 is up to "
    "2.25 times (ATI 5870) and 2.05 times (ATI 6970) faster than a tessellator",
    groups=groups,
    own=shared.own,
    any_count=(*BASELINES, "semi_adaptive"),
    columns=(
        Column("work", "work"),
        Column("scene", "scene", brief=True),
        Column("dataset", "dataset"),
        Column("level", "L at the finest"),
        Column("system", "subject", brief=True),
        Column("threshold", "threshold", "1"),
        Column("triangles_k", "triangles, thousands", brief=True),
        *shared.FRAME_AND_WORK_COLUMNS,
        *ratio_columns(BASELINES, shown=("dabt",)),
        *frame_ratio_columns(BASELINES),
        Column("published_frame_fps", "published fps", "1/s"),
        *STATUS_COLUMNS,
    ),
    notes=(
        "Figure 4.6 is of the teacup. Frames of figures 4.7 (32 segments) and 4.8 (64) have the whole scene of five "
        "copies in view at 1280 x 1024; distance test, high quality.",
        shared.ERROR_NOTE,
        "uncoupled_bezier: each cell of level 2 by itself, cut into the grid of power-of-two segments, a number for "
        "each direction, and along the diagonal with which the mean error of all is least for their triangles: cracks "
        "and all. No tessellation of such grids without them does with fewer.",
        "Divergence: see rc13_3_18_3_19.",
    ),
)
