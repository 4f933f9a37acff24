"""Fully, semi- and non-adaptive tessellation by error and frame rate: Concheiro 2013, figures 4.6 to 4.8."""

from __future__ import annotations

from collections.abc import Sequence

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
SAVED = ((5, 3e-8), (5, 3e-9), (5, 1e-9), (6, 3e-9), (6, 1e-9), (6, 3e-10))
ON_SURFACE = ((5, 3e-9), (6, 1e-9), (6, 3e-10))  # of these also with vertices on the surface
"""By the test "mean", level and price, of a model of a hundred patches; smaller ones: `SMALLER` times the price."""
LARGE, SMALLER = "elephant_gumbo", 10
ELSEWHERE = ("teapot", "teaspoon")  # where that test is judged too
MEDIUM, HIGH = 5, 6
BASELINES = ("vst", "dabt")


def _errors(model: str, level: int) -> Group:
    asked = [
        Subject(name, {"level": level, "threshold": threshold}, f"{name}_{threshold:g}")
        for name in shared.ADAPTIVE
        for threshold in THRESHOLDS
    ]
    return _compared(model, level, [*asked, *_bound(level)])


def _bound(level: int) -> list[Subject]:
    name = shared.BOUND
    return [Subject(name, {"level": level, "price": p}, f"{name}_{p:g}") for p in PRICES]


def _mean(system: str, level: int, price: float, fitted: bool = True) -> Subject:
    size = {"level": level, "test": "mean", "threshold": price, "fitted": fitted}
    words = "" if fitted else "_on_surface"
    return Subject(system, size, f"{system}_mean_{level}_{price:g}{words}")


def _compared(model: str, level: int, asked: Sequence[Subject] = ()) -> Group:
    times = 1 if model == LARGE else SMALLER
    saved = ON_SURFACE if model in ELSEWHERE else SAVED
    saving = [_mean("dabt", finest, times * price) for finest, price in saved]
    systems = shared.ADAPTIVE if model == LARGE else shared.ADAPTIVE[:1]
    saving += [_mean("semi_adaptive", finest, times * price) for finest, price in ON_SURFACE]
    saving += [
        _mean(system, finest, times * price, False)
        for system in systems
        for finest, price in ON_SURFACE
    ]
    return Group(
        model, (*shared.uniform(), *asked, *saving, shared.reference()),
        {"work": ERROR, "scene": model, "level": level}, once=True, standin_ok=True,
        reference="reference", nearest=True, weight=2.0,
    )  # fmt: skip


def _frames(model: str, level: int) -> Group:
    size = {"level": level}
    names = "vst", "semi_adaptive", "dabt"
    subjects = (
        *(Subject(name, size, draw=DRAW) for name in names),
        Subject("dabt", {**size, "test": "mean"}, "dabt_mean", draw=DRAW),
    )
    facts = {"work": FRAMES, "scene": f"S{COPIES} {model}", "level": level}
    return Group(f"{model}_x{COPIES}", subjects, facts, weight=2.0, standin_ok=True)


def groups(quick: bool) -> list[Group]:
    """Errors of models, frames of scenes at two degrees; `quick` has one of each."""
    errors = [_errors("teacup", MEDIUM)]
    if not quick:
        errors += [_errors(LARGE, MEDIUM)]
        errors += [_compared(model, MEDIUM, _bound(MEDIUM)[1:2]) for model in ELSEWHERE]
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
    any_count=(*BASELINES, "semi_adaptive", "dabt_mean"),
    columns=(
        Column("work", "work"),
        Column("scene", "scene", brief=True),
        Column("dataset", "dataset"),
        Column("level", "L at the finest"),
        Column("system", "subject", brief=True),
        Column("test", "test"),
        Column("threshold", "threshold", "1"),
        Column("fitted", "vertices rise"),
        Column("triangles_k", "triangles, thousands", brief=True),
        Column("least_share", "least share at equal mean error", "1", brief=True),
        *shared.FRAME_AND_WORK_COLUMNS,
        *ratio_columns(BASELINES, shown=("dabt",)),
        *frame_ratio_columns(BASELINES),
        Column("published_frame_fps", "published fps", "1/s"),
        *STATUS_COLUMNS,
    ),
    notes=(
        "Figure 4.6 is of the teacup. Frames of figures 4.7 (32 segments) and 4.8 (64) have the whole scene of five "
        "copies in view at 1280 x 1024; distance test, high quality, or where named so the test mean.",
        shared.ERROR_NOTE,
        "uncoupled_bezier: each cell of level 2 by itself, cut into the grid of power-of-two segments, a number for "
        "each direction, and along the diagonal with which the mean error of all is least for their triangles: cracks "
        "and all. No tessellation of such grids without them does with fewer.",
        "The thesis's tests ask of each candidate whether it is as far off as a threshold, wherever it is; that "
        "spends triangles where little area is and leaves them out where much is. Coarse triangles cost as well: "
        "their common edge must bend with the surface, so that a cell which is cut into n parts in one direction "
        "has 4 n - 2 triangles in place of 2 n. Test mean, ours, is of cells as a whole: each is cut into halves, "
        "in either direction, and these into grids, so that each triangle saves the threshold of the surface's "
        "mean error; with it both systems give the same. Then vertices rise along the surface's normals by what the "
        "triangles around lie under it in the mean, so that these lie on both sides: half the error. Triangles of a "
        "uniform grid would gain as much if its vertices rose, which the thesis's do not; rows on_surface have "
        "what the choice of grids gains by itself. Coarse cells are of level 2 where the finest are of 5, "
        "of 3 where they are of 6.",
        "Least share at equal mean error, computed from the curvatures of the patches: that of grids along u and "
        "v which have at each place whatever segments, of any length, and diagonal are best there, neighbours or "
        "not, in the limit of many triangles. No tessellation by grids with its vertices on the surface can do "
        "with less, so that of rows on_surface a share of 0.35 is out of reach wherever it is "
        "larger.",
        "Divergence: see rc13_3_18_3_19.",
    ),
)
