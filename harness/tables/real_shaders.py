"""Our stages against real shader stages of an OpenGL driver: the same mesh, the same camera, the same size."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lodbench.harness.measure.timing import VERY_SLOW_S
from lodbench.harness.plan.group import Draw, Group, Subject
from lodbench.harness.plan.table import (
    WALL_COLUMNS,
    Column,
    Entry,
    Row,
    Table,
    brief,
    ratio_columns,
)
from lodbench.kernels.stages.camera import TABLE_SIZE

BASELINES = ("gl_static_vbo", "gl_pattern", "gl_tessellation", "gl_quadric_clustering")
STATIC = ("10k", "100k", "1m", "4m")
SEGMENTS = (16, 32, 64)
ONLY_QUICK = {"static": STATIC[:2], "segments": SEGMENTS[:1]}
CELLS = 64
SECONDS = {16: 4.0, 32: 8.0, 64: 16.0}  # of a group with a software driver, about
WHOLE = Draw(TABLE_SIZE)
SIZE = {"width": TABLE_SIZE[0], "height": TABLE_SIZE[1]}
RINGS = (
    "The driver's tessellator cuts a triangle into rings, 1.5 segments^2 triangles; a pattern has segments^2: "
    "ratios to it are between equal segments, not between equal counts."
)
DRAWN = ("draw", "fill the image", "refine and draw")  # work that ends with an image


def _static(dataset: str, work: str, zoom: float | None = None) -> Group:
    subjects = (
        Subject("drawn_mesh", SIZE),
        Subject("gl_static_vbo", {"segments": 1, **SIZE}),
    )
    return Group(dataset, subjects, {"work": work}, weight=3.0, zoom=zoom)


def _refined(segments: int, drawn: bool) -> Group:
    params: dict[str, Any] = {"segments": segments}
    theirs = {**params, "output": "image" if drawn else "points", **SIZE}
    names = ["gl_static_vbo", "gl_pattern", "gl_tessellation"] if drawn else list(BASELINES[1:3])
    subjects = (
        Subject("pattern", params, draw=WHOLE if drawn else None),
        *([Subject("static_vbo", params, draw=WHOLE)] if drawn else []),
        *(Subject(name, theirs) for name in names),
    )
    facts = {"work": DRAWN[2] if drawn else "refine", **params}
    return Group("sphere_1000", subjects, facts, weight=SECONDS[segments])


def _clustered(dataset: str) -> Group:
    params = {"cells": CELLS}
    subjects = (Subject("quadric_clustering", params), Subject("gl_quadric_clustering", params))
    facts = {"work": "simplify", "cells": CELLS}
    return Group(dataset, subjects, facts, weight=4.0, standin_ok=True)


def groups(quick: bool) -> list[Group]:
    """Static meshes, a quad that fills the image, refinement with and without drawing, and clustering.

    `quick` stops at 100 k triangles and 16 segments.
    """
    sizes = ONLY_QUICK["static"] if quick else STATIC
    made = [_static(f"displaced_icosphere_{size}", DRAWN[0]) for size in sizes]
    made.append(_static("plane_2", DRAWN[1], zoom=4.0))
    for segments in ONLY_QUICK["segments"] if quick else SEGMENTS:
        made.append(_refined(segments, drawn=True))
        made.append(_refined(segments, drawn=False))
    return [*made, _clustered("bunny_69k"), *([] if quick else [_clustered("dragon_871k")])]


def own(entry: Entry) -> Mapping[str, Any]:
    """The driver; and a sample that drew is a whole frame."""
    row, subject, environment = entry.row, entry.subject, entry.run.environment
    pocl = environment.get("pocl")
    ours = f"PoCL {pocl}" if pocl else environment["device"].get("platform")
    more: Row = {
        "driver": subject.driver or (ours and subject.samples and f"OpenCL, {ours}") or None
    }
    wall = row["wall_s"]
    if wall and row["work"] in DRAWN:
        more["frame_fps"] = 1 / wall
    if wall and wall > VERY_SLOW_S:
        more["reason"] = ", ".join(filter(None, (row["reason"], "one sample: over 30 s")))
    return more


TABLE = Table(
    id="real_shaders",
    title="Our stages against an OpenGL driver's shaders",
    source="OpenGL through EGL: vertex, tessellation, geometry and fragment shaders of the driver named in each row",
    groups=groups,
    own=own,
    # a tessellator cuts the same segments into half as many triangles again: that is its way of doing the work
    any_count=("gl_tessellation",),
    columns=(
        Column("work", "work", brief=True),
        Column("dataset", "dataset"),
        Column("triangles_in", "triangles in", brief=True),
        Column("segments", "segments", brief=True),
        Column("cells", "cells", brief=True),
        Column("system", "system", brief=True),
        Column("triangles_out", "triangles out"),
        *brief(WALL_COLUMNS, "wall_s", "samples"),
        Column("stage_s", "device time", "s"),
        Column("frame_fps", "frame fps", "1/s", brief=True),
        *ratio_columns(BASELINES),
        Column("driver", "driver"),
    ),
    notes=(
        "Images are 1280 x 1024 with the same camera, lights and colours on both sides. A driver's frame ends when it "
        "has finished; it includes no read-back.",
        "draw: a mesh that lies in buffers, its points transformed, rasterised and shaded. fill the image: two "
        "triangles over every pixel. refine and draw: 1000 coarse triangles, refined anew in every frame.",
        "refine: points and normals alone, which the driver keeps by transform feedback. simplify: quadric clustering "
        "without drawing, the driver in the three passes that were published.",
        RINGS,
        "Patches are drawn in calls of at most 32,768 tessellated vertices: past 65,536 llvmpipe numbers them anew, so "
        "that patches are missing and others come twice, in many times the time.",
    ),
)
