"""Nested patterns along a camera path: Boubekeur & Schlick 2005, section 4, level of detail by distance."""

from __future__ import annotations

from lodbench.harness.plan.group import Draw, Group, Subject
from lodbench.harness.plan.table import (
    FRAME_COLUMNS,
    PATH_COLUMNS,
    WALL_COLUMNS,
    Column,
    Table,
    brief,
    frame_ratio_columns,
)
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


TABLE = Table(
    id="gmr05_path",
    title="Nested patterns along a camera path",
    source="Boubekeur & Schlick 2005, section 4 (level of detail); no figures are published",
    groups=groups,
    columns=(
        Column("path", "path", brief=True),
        Column("segments", "segments"),
        Column("system", "system", brief=True),
        *PATH_COLUMNS,
        *brief(WALL_COLUMNS),
        *FRAME_COLUMNS,
        *frame_ratio_columns([BASELINE]),
    ),
    notes=(
        "Whole frames with raster and shading at 1280 x 1024. The orbit goes once around while the eye draws back to "
        "16 times the distance from which the model fills the image, and returns; the fly-through comes from there "
        "straight through the model. Every view is drawn by all subjects in turn, the whole path five times; the "
        "ratio is taken view by view.",
        "pattern halves its segments for each doubling of the eye's distance past one bounding-box diagonal; one_level "
        "and static_vbo draw all triangles from everywhere.",
    ),
)
