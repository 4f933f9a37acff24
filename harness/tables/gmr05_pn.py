"""Curved PN triangles under patterns against what else evaluates or subdivides a coarse mesh."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lodbench.datasets_gen import catalogue
from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.plan.table import (
    WALL_COLUMNS,
    Column,
    Entry,
    Row,
    Table,
    brief,
    ratio_columns,
)
from lodbench.harness.tables import real_shaders
from lodbench.harness.tables.real_shaders import DRAWN, RINGS, SIZE, WHOLE

COARSE = ("sphere_1000", "knight_1k")  # the scan where the data folder has it
SEGMENTS = (16, 64)
OURS = ("pattern", "pn_triangles", "st_triangles")
ARRAYS = ("igl_upsample", "igl_loop", "trimesh_subdivide")
VTK = ("vtk_linear_subdivision", "vtk_loop_subdivision")
SHADERS = ("gl_pn_pattern", "gl_pn_tessellation")
BASELINES = ("pattern", "numpy_pn_triangles", *SHADERS, *ARRAYS, *VTK)
SHOWN = ("numpy_pn_triangles", "gl_pn_pattern", "igl_upsample", "igl_loop")
REFINE, DRAW = "refine", DRAWN[2]
LEAST = SEGMENTS[0]  # at more the packages fill the memory


def _refined(dataset: str, segments: int, vtk: bool) -> Group:
    params: dict[str, Any] = {"segments": segments}
    names = [*OURS, "numpy_pn_triangles"]
    if segments == LEAST:
        names += [*ARRAYS, *(VTK if vtk else ())]
    subjects = (
        *(Subject(name, params) for name in names),
        Subject(SHADERS[0], {**params, "output": "points"}),
    )
    return Group(dataset, subjects, {"work": REFINE, **params}, weight=1 + segments / 16)


def _drawn(dataset: str, segments: int) -> Group:
    params: dict[str, Any] = {"segments": segments}
    subjects = (
        *(Subject(name, params, draw=WHOLE) for name in ("pattern", "pn_triangles")),
        *(Subject(name, {**params, **SIZE}) for name in SHADERS),
    )
    return Group(dataset, subjects, {"work": DRAW, **params}, weight=10.0)


def _is_there(dataset: str) -> bool:
    return dataset in catalogue.names()


def groups(quick: bool) -> list[Group]:
    """Each coarse mesh with each pattern: the surface alone, then whole frames.

    `quick` stops at 16 segments and leaves out VTK.
    """
    return [
        group
        for dataset in filter(_is_there, COARSE)
        for segments in (SEGMENTS[:1] if quick else SEGMENTS)
        for group in (_refined(dataset, segments, vtk=not quick), _drawn(dataset, segments))
    ]


def own(entry: Entry) -> Mapping[str, Any]:
    """The driver, whether neighbours share their vertices; vertices per second, or frames where a sample drew."""
    row = entry.row
    vertices, wall = row["vertices_out"], row["wall_s"]
    more: Row = dict(real_shaders.own(entry))
    more["welded"] = "yes" if entry.subject.label in ARRAYS + VTK else "no"
    if vertices and wall and row["work"] == REFINE:
        more["vertices_per_s"] = vertices / wall
        if entry.subject.label in OURS and row["stage_s"]:
            more["launch_s"] = wall - row["stage_s"]
    return more


TABLE = Table(
    id="gmr05_pn",
    title="Curved PN triangles against shaders, NumPy and subdivision",
    source="Vlachos et al. 2001; Boubekeur & Schlick 2005, appendix A; nothing of it was published as times",
    groups=groups,
    own=own,
    # a tessellator cuts the same segments into half as many triangles again: that is its way of doing the work
    any_count=("gl_pn_tessellation",),
    columns=(
        Column("work", "work", brief=True),
        Column("dataset", "dataset", brief=True),
        Column("segments", "segments", brief=True),
        Column("system", "system", brief=True),
        Column("triangles_out", "triangles out"),
        Column("vertices_out", "vertices out"),
        Column("welded", "welded", brief=True),
        *brief(WALL_COLUMNS, "wall_s"),
        Column("stage_s", "device time", "s"),
        Column("launch_s", "wall time around it", "s"),
        Column("vertices_per_s", "vertices per second", "1/s", brief=True),
        Column("frame_fps", "frame fps", "1/s", brief=True),
        *ratio_columns(BASELINES, shown=SHOWN),
        Column("driver", "driver"),
    ),
    notes=(
        "refine: points and normals alone; an OpenGL driver keeps them by transform feedback. refine and draw: whole "
        "frames at 1280 x 1024, refined anew in each, with the same camera, lights and colours on both sides.",
        "pn_triangles, numpy_pn_triangles and the gl_pn baselines evaluate the same surface from control points and "
        "normals; all but gl_pn_tessellation, which makes them in every frame, have them made beforehand.",
        "Subdivision packages give a welded mesh, about half as many vertices for the same triangles, without normals: "
        "vertices per second are those that they give. Their linear forms leave the coarse surface as it is, which is "
        "the work of pattern. Loop's scheme is smooth, but another surface: it looks at neighbours, not at normals, "
        "and leaves the given vertices.",
        "Wall time around device time is the launch and the wait for it: it does not grow with the output.",
        RINGS,
    ),
)
