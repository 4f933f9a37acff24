"""Triangles of the three tests, and of ours, at three qualities: Concheiro 2013, table 3.1."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from math import exp, log
from typing import Any

from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.plan.table import (
    FRAME_COLUMNS,
    STATUS_COLUMNS,
    WALL_COLUMNS,
    Column,
    Entry,
    Row,
    Table,
    brief,
    stage_columns,
)
from lodbench.harness.record.record import GroupRecord
from lodbench.harness.report.rows import published

MODELS = ("teapot", "teacup", "elephant_gumbo")
TESTS = ("distance", "flat", "length")
OURS = "mean"
QUALITIES = ("low", "medium", "high")
LEVEL, REFERENCE = 5, 7
UNIFORM, ADAPTIVE, BOUND = "vst", ("dabt", "semi_adaptive"), "uncoupled_bezier"
UNIFORM_LEVELS = (1, 2, 3, 4, 5)


def uniform(levels: Sequence[int] = UNIFORM_LEVELS) -> list[Subject]:
    """Tessellations of all patches alike, whose errors others are compared at."""
    return [Subject(UNIFORM, {"level": level}, f"{UNIFORM}_{level}") for level in levels]


def reference() -> Subject:
    """What errors are measured from."""
    return Subject(UNIFORM, {"level": REFERENCE, "normals": False}, "reference")


def asked(system: str, test: str, quality: str, level: int = LEVEL) -> Subject:
    """An adaptive tessellation."""
    size = {"level": level, "test": test, "quality": quality}
    return Subject(system, size, f"{system}_{test}_{quality}")


def groups(quick: bool) -> list[Group]:
    """Every model with every test at every quality; `quick` has the first one."""
    subjects = (
        *uniform(),
        *(asked("dabt", test, quality) for test in (*TESTS, OURS) for quality in QUALITIES),
        reference(),
    )
    return [
        Group(
            model, subjects, {"model": model}, once=True, standin_ok=True, reference="reference",
            nearest=True, weight=2.0,
        )
        for model in (MODELS[:1] if quick else MODELS)
    ]  # fmt: skip


def at_equal_error(group: GroupRecord, error: float) -> tuple[float | None, int | None]:
    """Triangles of uniform tessellation with this mean error: between its levels, and of the next level.

    Between levels it is interpolated, logarithm over logarithm, as if there were any number of segments.
    """
    known = sorted(
        (subject.quality["mean_difference"], subject.counters["triangles"])
        for subject in group.subjects.values()
        if subject.system == UNIFORM and subject.quality and subject.counters
    )
    level = next((triangles for own, triangles in reversed(known) if own <= error), None)
    for (finer, many), (coarser, few) in pairwise(known):
        if 0 < finer <= error <= coarser:
            along = log(error / finer) / log(coarser / finer) if coarser > finer else 0.0
            return exp(log(many) + along * log(few / many)), level
    return None, level


def own(entry: Entry) -> Mapping[str, Any]:
    """Triangles in thousands, errors, and the share of a uniform tessellation's triangles at equal mean error."""
    subject = entry.subject
    quality, triangles = subject.quality or {}, subject.counters.get("triangles")
    error = quality.get("mean_difference")
    keys = ("mean_difference", "rms_difference", "max_difference")
    more: Row = {key: quality.get(key) for key in keys}
    more["triangles_k"] = triangles / 1000 if triangles else None
    if error and triangles and subject.system in (*ADAPTIVE, BOUND):
        between, level = at_equal_error(entry.group, error)
        more["share_at_error"] = triangles / between if between else None
        more["share_of_level"] = triangles / level if level else None
    more["least_share"] = subject.counters.get("least_share")
    return more


def also(group: GroupRecord) -> Sequence[Row]:
    """What was found of the published figures, below the elephant: which model it is was not."""
    if group.dataset != MODELS[-1]:
        return ()
    values = {"published_triangles_k": 284.94, "published_frame_fps": 148.97}
    return (published(group, "dabt, length, high quality, a model not named", **values),)


ERROR_COLUMNS = (
    Column("mean_difference", "mean error", "1", brief=True),
    Column("rms_difference", "RMS error", "1"),
    Column("max_difference", "largest error", "1"),
    Column("share_at_error", "share of vst's triangles at equal mean error", "1", brief=True),
    Column("share_of_level", "share of the vst level that does as well", "1", brief=True),
)
WORK_COLUMNS = (
    Column("work_spread", "work of coarse triangles, deviation over mean", "1"),
    Column("lanes_used", "share of 32 lanes at work", "1"),
)
FRAME_AND_WORK_COLUMNS = (
    *ERROR_COLUMNS,
    *brief(WALL_COLUMNS, "wall_s"),
    *stage_columns(("geometry_test", "scan", "geometry_emit", "vertex")),
    *FRAME_COLUMNS,
    *brief(WORK_COLUMNS, "lanes_used"),
)
ERROR_NOTE = (
    "Errors are distances from 200,000 vertices of a tessellation with 128 segments to the nearest point, as shares of "
    "the diagonal; in the mean a vertex counts by the area around it. Share of vst's triangles at equal mean error: "
    "between its levels interpolated, as if it had any number of segments. Share of the vst level that does as well: "
    "of the coarsest level that is no farther away."
)

MEAN_NOTE = (
    "Test mean, ours: its threshold is the mean error that a triangle must save, and its vertices rise over the "
    "surface so that triangles lie on both sides of it. All that is compared with, vst too, has its vertices on it."
)

TABLE = Table(
    id="rc13_3_1",
    title="Triangles of the three tests",
    source="Concheiro 2013, table 3.1, whose values were not at hand; one of a walk at 1280 x 1024 is in GRAPP 2011",
    groups=groups,
    own=own,
    also=also,
    columns=(
        Column("model", "model", brief=True),
        Column("dataset", "dataset"),
        Column("system", "subject", brief=True),
        Column("test", "test"),
        Column("quality", "quality"),
        Column("threshold", "threshold"),
        Column("triangles_k", "triangles, thousands", brief=True),
        Column("published_triangles_k", "published triangles, thousands"),
        Column("coarse_triangles", "coarse triangles"),
        *ERROR_COLUMNS,
        *WORK_COLUMNS,
        Column("published_frame_fps", "published fps", "1/s"),
        Column("wall_s", "wall", "s"),
        *STATUS_COLUMNS,
    ),
    notes=(
        "Coarse triangles are those of level 2, with up to three levels more: 32 segments along a patch at the finest. "
        "Thresholds of the three qualities are ours: a share of the diagonal, one less the cosine of an angle, pixels "
        "of an image that is as high as the diagonal is long.",
        ERROR_NOTE,
        MEAN_NOTE,
        "What would bring the share down, and how far it could go: see rc13_4_6_to_4_8.",
    ),
)
