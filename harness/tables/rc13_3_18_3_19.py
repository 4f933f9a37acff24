"""Error of the three tests, and frames with each against one level for all: Concheiro 2013, figures 3.18 and 3.19."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lodbench.harness.plan.group import Draw, Group, Subject
from lodbench.harness.plan.table import (
    STATUS_COLUMNS,
    Column,
    Entry,
    Table,
    frame_ratio_columns,
    ratio_columns,
)
from lodbench.harness.tables import rc13_3_1 as shared

COPIES = 5
DRAW = Draw((1280, 1024), apart=True)
ERROR, FRAMES = "error", "frames"


def _errors(model: str) -> Group:
    subjects = (
        *shared.uniform(),
        *(
            shared.asked("dabt", test, quality)
            for test in shared.TESTS
            for quality in shared.QUALITIES
        ),
        shared.reference(),
    )
    return Group(
        model, subjects, {"work": ERROR, "scene": model}, once=True, standin_ok=True,
        reference="reference", nearest=True,
    )  # fmt: skip


def _frames(model: str) -> Group:
    size = {"level": shared.LEVEL}
    subjects = (
        Subject("vst", size, draw=DRAW),
        *(
            Subject("dabt", {**size, "test": test}, f"dabt_{test}", draw=DRAW)
            for test in shared.TESTS
        ),
    )
    facts = {"work": FRAMES, "scene": f"S{COPIES} {model}"}
    return Group(f"{model}_x{COPIES}", subjects, facts, weight=2.0, standin_ok=True)


def groups(quick: bool) -> list[Group]:
    """Errors of the teacup, and frames of each scene at high quality; `quick` has the teapots' frames alone."""
    models = shared.MODELS[:1] if quick else shared.MODELS
    return [_errors("teacup"), *(_frames(model) for model in models)]


def own(entry: Entry) -> Mapping[str, Any]:
    """Errors as in `rc13_3_1`."""
    return shared.own(entry)


LABELS = tuple(f"dabt_{test}" for test in shared.TESTS)

TABLE = Table(
    id="rc13_3_18_3_19",
    title="Error and frame rate of the three tests",
    source="Concheiro 2013, figures 3.18 and 3.19; published on a GeForce 295 GTX and a Radeon 5870, whose values were "
    "not at hand",
    groups=groups,
    own=own,
    any_count=("vst", *LABELS),  # fewer triangles are the method's way
    columns=(
        Column("work", "work"),
        Column("scene", "scene", brief=True),
        Column("dataset", "dataset"),
        Column("system", "subject", brief=True),
        Column("test", "test"),
        Column("quality", "quality"),
        Column("threshold", "threshold"),
        Column("triangles_k", "triangles, thousands", brief=True),
        *shared.FRAME_AND_WORK_COLUMNS,
        *ratio_columns(["vst"], shown=()),
        *frame_ratio_columns(["vst"]),
        Column("published_frame_fps", "published fps", "1/s"),
        *STATUS_COLUMNS,
    ),
    notes=(
        "Figure 3.18 is of the teacup. Scenes of figure 3.19 are five copies of a model, all in view at 1280 x 1024; "
        "coarse triangles of level 2 and three levels more, against vst with 32 segments.",
        shared.ERROR_NOTE,
        "Work of a coarse triangle is the candidates that it tests and the vertices that it emits. A GPU's lanes wait "
        "for the slowest of them: of 32 neighbours the mean over the largest is the share at work. A CPU's cores do "
        "not wait, so that divergence costs nothing here but mispredicted branches.",
    ),
)
