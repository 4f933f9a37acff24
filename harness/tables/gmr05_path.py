"""Nested patterns along a camera path: Boubekeur & Schlick 2005, section 4, level of detail by distance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from lodbench.harness.group import Draw, Group, Subject
from lodbench.harness.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.tables import FRAME_COLUMNS, WALL_COLUMNS, Column, Row, Table, measured
from lodbench.harness.timing import paired_ratio
from lodbench.kernels.stages.paths import CameraPath

DRAW = Draw((1280, 1024), apart=True)
FRAMES = 60
BASELINE = "static_vbo"


def groups(quick: bool) -> list[Group]:
    """An orbit around a refined mesh that draws back and returns; fewer triangles and frames with `quick`."""
    dataset, segments, frames = ("sphere_100", 32, 20) if quick else ("sphere_1000", 64, FRAMES)
    levels = segments.bit_length()
    subjects = (
        Subject(BASELINE, {"segments": segments}, draw=DRAW),
        Subject("pattern", {"segments": segments}, "one_level", draw=DRAW),
        Subject("pattern", {"segments": segments, "levels": levels}, draw=DRAW),
    )
    paths = [CameraPath("orbit", frames)] + [CameraPath("fly_through", frames)] * (not quick)
    return [
        Group(dataset, subjects, {"path": path.kind, "segments": segments}, path=path)
        for path in paths
    ]


def steps(subject: SubjectRecord) -> dict[int, float]:
    """Step of the path -> median seconds of its frames."""
    return {step: float(np.median(found)) for step, found in sorted(subject.path_s.items())}


def _row(group: GroupRecord, subject: SubjectRecord, seed: int) -> Row:
    row = measured(group, subject)
    found = steps(subject)
    if found:
        row["steps"] = len(found)
        row["least_fps"], row["most_fps"] = 1 / max(found.values()), 1 / min(found.values())
        drawn = [frame["triangles"] for frame in subject.frames if frame.get("triangles")]
        row["most_triangles"], row["least_triangles"] = max(drawn), min(drawn)
    ratio = paired_ratio(group.subjects[BASELINE].frame_s, subject.frame_s, seed)
    if ratio and subject.label != BASELINE:
        row |= {"ratio": ratio.median, "ratio_low": ratio.low, "ratio_high": ratio.high}
    return row


def rows(run: RunRecord, records: Sequence[GroupRecord]) -> list[Row]:
    """One row per subject and path."""
    seed: Any = run.environment["seed"]
    return [_row(group, subject, seed) for group in records for subject in group.subjects.values()]


TABLE = Table(
    id="gmr05_path",
    title="Nested patterns along a camera path",
    source="Boubekeur & Schlick 2005, section 4 (level of detail); no figures are published",
    groups=groups,
    rows=rows,
    columns=(
        Column("path", "path"),
        Column("segments", "segments"),
        Column("system", "system"),
        Column("steps", "views"),
        *WALL_COLUMNS,
        *FRAME_COLUMNS,
        Column("least_fps", "fps, slowest view", "1/s"),
        Column("most_fps", "fps, fastest view", "1/s"),
        Column("most_triangles", "most triangles"),
        Column("least_triangles", "fewest triangles"),
        Column("ratio", "frame fps over static's", "1"),
        Column("ratio_low", "... low", "1"),
        Column("ratio_high", "... high", "1"),
    ),
    brief=(
        "path", "system", "steps", "frame_fps", "least_fps", "most_fps", "most_triangles",
        "least_triangles", "ratio", "status",
    ),
    notes=(
        "Whole frames with raster and shading at 1280 x 1024. The orbit goes once around while the eye draws back to "
        "16 times the distance from which the model fills the image, and returns; the fly-through comes from there "
        "straight through the model. Every view is drawn by all subjects in turn, the whole path five times; the "
        "ratio is taken view by view.",
        "pattern halves its segments for each doubling of the eye's distance past one bounding-box diagonal; one_level "
        "and static_vbo draw all triangles from everywhere.",
    ),
)  # fmt: skip
