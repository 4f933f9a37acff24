"""Generic mesh refinement against a static vertex buffer: Boubekeur & Schlick 2005, figure 7."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from lodbench.harness.group import Draw, Group, Subject
from lodbench.harness.ratios import counts, ratios
from lodbench.harness.record import GroupRecord, RunRecord
from lodbench.harness.tables import (
    FRAME_COLUMNS,
    WALL_COLUMNS,
    Column,
    Row,
    Table,
    measured,
    ratio_columns,
)
from lodbench.harness.timing import paired_ratio

SEGMENTS = (64, 128)
COARSE = (10, 100, 1000)
BASELINES = ("static_vbo", "numpy_pattern", "pattern_one_core")
PER_TRIANGLE = "pattern_per_triangle"
DRAW = Draw((1280, 1024), apart=True)  # the size that the paper's frames have

# frames per second by segments and coarse triangles; Quadro FX 4400 PCIe, Pentium 4 3.0 GHz
PUBLISHED_FPS = {
    "static_vbo": {64: (973.10, 107.46, 11.94), 128: (271.85, 29.87, 3.97)},
    PER_TRIANGLE: {64: (965.12, 107.11, 11.72), 128: (269.35, 29.05, 3.81)},
}
PUBLISHED_VERTICES = {
    "static_vbo": {64: (42_250, 422_500, 4_225_000), 128: (166_410, 1_664_100, 16_641_000)},
    PER_TRIANGLE: {64: (4_225,) * 3, 128: (16_641,) * 3},
}


def groups(quick: bool) -> list[Group]:
    """Every pattern on every coarse mesh; the same with `quick`."""
    made = []
    for segments in SEGMENTS:
        for coarse in COARSE:
            size: dict[str, Any] = {"segments": segments}
            subjects = (
                Subject("static_vbo", size, draw=DRAW),
                Subject("pattern", size, draw=DRAW),
                Subject("pattern", {**size, "draw": "per_triangle"}, PER_TRIANGLE, draw=DRAW),
                Subject("pattern", size, "pattern_one_core", one_core=True),
                Subject("numpy_pattern", size),
                Subject("device_fill", size, case="kernel"),
                Subject("device_fill", size, "device_fill_streaming", case="streaming"),
            )
            facts = {**size, "coarse_triangles": coarse}
            weight = 1.0 + segments**2 * coarse / 1e6
            made.append(Group(f"sphere_{coarse}", subjects, facts, weight=weight))
    return made


def _published(values: dict[str, dict[int, tuple[float, ...]]], row: Row) -> float | None:
    found = values.get(row["system"], {}).get(row["segments"])
    return found[COARSE.index(row["coarse_triangles"])] if found else None


def _row(group: GroupRecord, label: str, seed: int) -> Row:
    subject = group.subjects[label]
    row = measured(group, subject) | ratios(group, subject, BASELINES, seed)
    segments, coarse = row["segments"], row["coarse_triangles"]
    vertices, wall = subject.counters.get("vertices"), row["wall_s"]
    row["vertices"] = vertices
    row["stage_fps"] = 1 / wall if wall else None
    row["vertices_per_s"] = vertices / wall if vertices and wall else None
    if vertices:
        square = (segments + 1) ** 2
        everything = label in ("static_vbo", "numpy_pattern")
        row["stored_vertices_square"] = square * (coarse if everything else 1)
        static = subject.footprint["static_vertices"]
        row["stored_share"] = row["stored_vertices"] / static if static else None
        if wall:
            row["stage_fps_square"] = row["vertices_per_s"] / (square * coarse)
    fills = [
        summary["wall_s"]
        for name in ("device_fill", "device_fill_streaming")
        if name in group.subjects and (summary := measured(group, group.subjects[name]))["wall_s"]
    ]
    if fills and wall and (row["batches"] or 1) == 1:
        row["fill_share"] = min(fills) / wall
    fps, static_fps = (
        _published(PUBLISHED_FPS, row),
        _published(PUBLISHED_FPS, {**row, "system": "static_vbo"}),
    )
    static = group.subjects.get("static_vbo")
    drawn = paired_ratio(static.frame_s, subject.frame_s, seed) if static else None
    if drawn and label != "static_vbo" and counts(subject) and counts(static):
        row["frame_ratio_to_static_vbo"] = drawn.median
        row["frame_ratio_to_static_vbo_low"] = drawn.low
        row["frame_ratio_to_static_vbo_high"] = drawn.high
    row["published_frame_fps"] = fps
    row["published_vertices"] = _published(PUBLISHED_VERTICES, row)
    row["published_ratio_to_static_vbo"] = fps / static_fps if fps and static_fps else None
    return row


def rows(run: RunRecord, records: Sequence[GroupRecord]) -> list[Row]:
    """One row per subject and size, the sizes in the paper's order."""
    seed = run.environment["seed"]
    return [_row(group, label, seed) for group in records for label in group.subjects]


TABLE = Table(
    id="gmr05_figure7",
    title="Generic refinement against a static vertex buffer",
    source="Boubekeur & Schlick 2005, figure 7; published on a Quadro FX 4400 PCIe, Pentium 4 3.0 GHz",
    groups=groups,
    rows=rows,
    columns=(
        Column("segments", "segments"),
        Column("coarse_triangles", "coarse triangles"),
        Column("system", "system"),
        *WALL_COLUMNS,
        Column("stage_s", "device time", "s"),
        Column("stage_fps", "stage fps", "1/s"),
        *FRAME_COLUMNS,
        Column("vertices", "vertices out"),
        Column("vertices_per_s", "vertices per second", "1/s"),
        Column("stage_fps_square", "stage fps at the paper's count", "1/s"),
        Column("fill_share", "share of fill bandwidth", "1"),
        Column("stored_vertices", "stored vertices"),
        Column("stored_vertices_square", "stored, counted as the paper does"),
        Column("stored_share", "stored share of static", "1"),
        Column("stored_bytes", "stored", "B"),
        Column("batches", "batches"),
        *ratio_columns(BASELINES),
        Column("frame_ratio_to_static_vbo", "frame fps over static's", "1"),
        Column("frame_ratio_to_static_vbo_low", "... low", "1"),
        Column("frame_ratio_to_static_vbo_high", "... high", "1"),
        Column("published_frame_fps", "published fps", "1/s"),
        Column("published_vertices", "published vertices"),
        Column("published_ratio_to_static_vbo", "published fps over static's", "1"),
    ),
    brief=(
        "segments",
        "coarse_triangles",
        "system",
        "wall_s",
        "stage_fps",
        "frame_fps",
        "vertices_per_s",
        "fill_share",
        "stored_bytes",
        "ratio_to_static_vbo",
        "ratio_to_numpy_pattern",
        "status",
    ),
    notes=(
        "Stage fps is one over the median wall time of a frame up to and including the geometry stage. Frame fps adds "
        "raster and shading at 1280 x 1024 with the whole surface in view, in turns of their own after samples; the "
        "published fps are whole frames on a GPU of 2005. Compare ratios, not frames.",
        "The published vertex counts 4,225 = 65^2 and 16,641 = 129^2 are those of square grids. A triangular pattern, "
        "which is what is run here, has (n + 1)(n + 2) / 2 vertices: 2,145 and 8,385. Both counts are shown; the fps "
        "at the paper's count are derived from vertices per second.",
        "The paper draws the pattern once per coarse triangle (pattern_per_triangle); pattern is one launch for all.",
        "The paper's text gives 331,938 triangles for a mesh of 162 triangles refined by the 64 x 64 pattern; "
        "162 * 64^2 is 663,552. 331,938 = 162 * (64^2 / 2 + 1) is close to the vertices of the welded result, 331,778.",
        "device_fill writes as many bytes as the output has, and computes nothing; the share of fill bandwidth is the "
        "faster of its two forms over the row's time, both of the same group.",
        "published fps over static's is derived: the quotient of the two published values.",
    ),
)
