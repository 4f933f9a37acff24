"""Generic mesh refinement against a static vertex buffer: Boubekeur & Schlick 2005, figure 7."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lodbench.harness.plan.group import Draw, Group, Subject
from lodbench.harness.plan.table import (
    FRAME_COLUMNS,
    WALL_COLUMNS,
    Column,
    Entry,
    Row,
    Table,
    brief,
    frame_ratio_columns,
    ratio_columns,
)
from lodbench.harness.report.statistics import summary

SEGMENTS = (64, 128)
COARSE = (10, 100, 1000)
BASELINES = ("static_vbo", "numpy_pattern", "pattern_one_core")
PER_TRIANGLE = "pattern_per_triangle"
FILLS = ("device_fill", "device_fill_streaming")
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
    """Every pattern on every coarse mesh; `quick` leaves out the largest."""
    made = []
    for segments in SEGMENTS:
        for coarse in COARSE[:2] if quick and segments == SEGMENTS[-1] else COARSE:
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


def _fill_s(entry: Entry) -> float | None:
    """Median seconds of the faster of the two fills."""
    fills = [entry.group.subjects[name] for name in FILLS if name in entry.group.subjects]
    found = [summary(list(fill.wall_s.values())) for fill in fills]
    return min((one.median for one in found if one), default=None)


def own(entry: Entry) -> Mapping[str, Any]:
    """Vertices, as they are and as the paper counts them, the share of the fill, and the published figures."""
    row, subject = entry.row, entry.subject
    segments, coarse = row["segments"], row["coarse_triangles"]
    vertices, wall = subject.counters.get("vertices"), row["wall_s"]
    more: Row = {
        "vertices": vertices,
        "vertices_per_s": vertices / wall if vertices and wall else None,
    }
    if vertices:
        square = (segments + 1) ** 2
        everything = subject.label in ("static_vbo", "numpy_pattern")
        more["stored_vertices_square"] = square * (coarse if everything else 1)
        static = subject.footprint["static_vertices"]
        more["stored_share"] = row["stored_vertices"] / static if static else None
        if wall:
            more["stage_fps_square"] = more["vertices_per_s"] / (square * coarse)
    if (fill := _fill_s(entry)) and wall and (row["batches"] or 1) == 1:
        more["fill_share"] = fill / wall
    fps, static_fps = (
        _published(PUBLISHED_FPS, {**row, "system": name}) for name in (subject.label, "static_vbo")
    )
    more["published_frame_fps"] = fps
    more["published_vertices"] = _published(PUBLISHED_VERTICES, row)
    more["published_ratio_to_static_vbo"] = fps / static_fps if fps and static_fps else None
    return more


TABLE = Table(
    id="gmr05_figure7",
    title="Generic refinement against a static vertex buffer",
    source="Boubekeur & Schlick 2005, figure 7; published on a Quadro FX 4400 PCIe, Pentium 4 3.0 GHz",
    groups=groups,
    own=own,
    columns=(
        Column("segments", "segments", brief=True),
        Column("coarse_triangles", "coarse triangles", brief=True),
        Column("system", "system", brief=True),
        *WALL_COLUMNS,
        Column("stage_s", "device time", "s"),
        Column("stage_fps", "stage fps", "1/s", brief=True),
        *FRAME_COLUMNS,
        Column("vertices", "vertices out"),
        Column("vertices_per_s", "vertices per second", "1/s", brief=True),
        Column("stage_fps_square", "stage fps at the paper's count", "1/s"),
        Column("fill_share", "share of fill bandwidth", "1", brief=True),
        Column("stored_vertices", "stored vertices"),
        Column("stored_vertices_square", "stored, counted as the paper does"),
        Column("stored_share", "stored share of static", "1"),
        Column("stored_bytes", "stored", "B", brief=True),
        Column("batches", "batches"),
        *ratio_columns(BASELINES, shown=BASELINES[:2]),
        *brief(frame_ratio_columns(["static_vbo"])),
        Column("published_frame_fps", "published fps", "1/s"),
        Column("published_vertices", "published vertices"),
        Column("published_ratio_to_static_vbo", "published fps over static's", "1"),
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
