"""Adaptive patterns against uniform ones: triangles at equal error, and frames along a path. GPU Gems 3, chapter 5."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from math import exp, log
from typing import Any

from lodbench.harness.plan.group import Draw, Group, Subject
from lodbench.harness.plan.table import (
    FRAME_COLUMNS,
    PATH_COLUMNS,
    STATUS_COLUMNS,
    WALL_COLUMNS,
    Column,
    Entry,
    Table,
    brief,
    frame_ratio_columns,
    ratio_columns,
    stage_columns,
)
from lodbench.harness.record.record import GroupRecord
from lodbench.kernels.stages.paths import CameraPath

COARSE = ("bunny_69k_to_1k", "armadillo_86k_to_1k", "mechpart_g3_to_1k", "sphere_1000")
UNIFORM, ADAPTIVE = "pn_triangles", "adaptive_patterns"
BOUND, BINNED = "uncoupled_pn_triangles", "binned_adaptive_patterns"
SEGMENTS = (2, 4, 8, 16, 32)
TOLERANCES = (3e-3, 1e-3, 3e-4, 1e-4, 3e-5)
PATH_SEGMENTS = 32
BASELINE = "uniform"
DRAW = Draw((1280, 1024), apart=True)
FRAMES = 60
ERROR, VERTICES, SHADERS, PATH = "error", "vertices", "draw", "path"
SHADER = "gl_adaptive_tessellation"


def _errors(dataset: str, quick: bool) -> Group:
    finest = 64 if quick else 128
    uniform = SEGMENTS[:-2] if quick else SEGMENTS
    asked = [
        ({"segments": 64, "tolerance": tolerance}, f"{tolerance:g}")
        for tolerance in (TOLERANCES[:-2] if quick else TOLERANCES)
    ]
    subjects = [
        *(Subject(UNIFORM, {"segments": n}, f"{UNIFORM}_{n}") for n in uniform),
        *(Subject(ADAPTIVE, size, f"curvature_{name}") for size, name in asked),
        *(Subject(BOUND, size, f"uncoupled_{name}") for size, name in asked),
        *(
            Subject(BOUND, {**size, "doubling": True}, f"uncoupled_doubling_{name}")
            for size, name in asked
        ),
        Subject(UNIFORM, {"segments": finest}, "reference"),
    ]
    return Group(
        dataset, tuple(subjects), {"work": ERROR}, weight=8.0, standin_ok=dataset != "sphere_1000",
        reference="reference", nearest=True,
    )  # fmt: skip


def _vertices(segments: int) -> Group:
    """The same vertices by one pattern and out of the pool, and fewer: what does adapting cost for each?"""
    size = {"segments": segments}
    bare = {**size, "indices": False}
    subjects = (
        Subject(UNIFORM, size, BASELINE),
        Subject(ADAPTIVE, {**bare, "by": "distance"}, "all_finest"),
        Subject(ADAPTIVE, {**size, "by": "distance"}, "all_finest_listed"),
        Subject(ADAPTIVE, {**bare, "tolerance": 0.1 / segments**2}, "curvature"),
        Subject(BINNED, {**bare, "tolerance": 0.1 / segments**2}, "curvature_binned"),
    )
    facts = {"work": VERTICES, "segments": segments}
    return Group(COARSE[0], subjects, facts, weight=2.0, standin_ok=True)


def _shaders(segments: int) -> Group:
    """Whole frames of what the screen asks for, by our stages and by a driver's tessellator."""
    size = {"segments": segments, "pixels": 4.0}
    width, height = DRAW.size
    subjects = (
        Subject(ADAPTIVE, {**size, "by": "screen"}, "screen", draw=Draw(DRAW.size)),
        Subject(SHADER, {**size, "width": width, "height": height}),
    )
    facts = {"work": SHADERS, "segments": segments}
    return Group(COARSE[0], subjects, facts, weight=2.0, standin_ok=True)


def _path(dataset: str, quick: bool) -> Group:
    size = {"segments": PATH_SEGMENTS}
    levels = {**size, "levels": PATH_SEGMENTS.bit_length()}
    subjects = (
        Subject(UNIFORM, size, BASELINE, draw=DRAW),
        Subject(UNIFORM, levels, "levels", draw=DRAW),
        Subject(ADAPTIVE, {**size, "by": "distance"}, "distance", draw=DRAW),
        Subject(ADAPTIVE, {**size, "by": "screen"}, "screen", draw=DRAW),
        Subject(ADAPTIVE, {**size, "by": "screen", "geomorphing": True}, "morphing", draw=DRAW),
        Subject(ADAPTIVE, {**size, "by": "curvature"}, "curvature", draw=DRAW),
        Subject(ADAPTIVE, {**size, "by": "mixed"}, "mixed", draw=DRAW),
    )
    return Group(
        dataset, subjects, {"work": PATH}, weight=6.0, standin_ok=True,
        path=CameraPath("orbit", 20 if quick else FRAMES),
    )  # fmt: skip


def groups(quick: bool) -> list[Group]:
    """Errors of four coarse meshes, time for each vertex, and an orbit; `quick` has the first mesh, and fewer views."""
    datasets = COARSE[:1] if quick else COARSE
    sizes = (16, 32, 64)[: 1 if quick else 3]
    return [
        *(_errors(dataset, quick) for dataset in datasets),
        *(_vertices(segments) for segments in sizes),
        *(_shaders(segments) for segments in sizes),
        _path(COARSE[0], quick),
    ]


def _uniform(group: GroupRecord) -> list[tuple[float, int]]:
    """Largest difference and triangles of each uniform refinement, finest first."""
    found = [
        (subject.quality["max_difference"], subject.counters["triangles"])
        for subject in group.subjects.values()
        if subject.system == UNIFORM and subject.quality and subject.counters
    ]
    return sorted(pair for pair in found if pair[0])


def at_equal_error(group: GroupRecord, error: float) -> tuple[float | None, int | None]:
    """Triangles of uniform refinement with this largest difference: between its levels, and of the next level.

    Between levels it is interpolated, logarithm over logarithm, as if there were patterns of any number of segments.
    """
    known = _uniform(group)
    level = next((triangles for own, triangles in reversed(known) if own <= error), None)
    for (finer, many), (coarser, few) in pairwise(known):
        if finer <= error <= coarser:
            along = log(error / finer) / log(coarser / finer) if coarser > finer else 0.0
            return exp(log(many) + along * log(few / many)), level
    return None, level


def own(entry: Entry) -> Mapping[str, Any]:
    """Errors, the share of a uniform refinement's triangles at equal error, and vertices per second."""
    subject, row = entry.subject, entry.row
    quality, triangles = subject.quality or {}, subject.counters.get("triangles")
    error = quality.get("max_difference")
    more: dict[str, Any] = {
        "rms_difference": quality.get("rms_difference"), "max_difference": error,
    }  # fmt: skip
    if vertices := subject.counters.get("vertices"):
        more["vertices"] = vertices
        more["vertices_per_s"] = vertices / row["wall_s"] if row["wall_s"] else None
        more["s_per_vertex"] = row["wall_s"] / vertices if row["wall_s"] else None
    if error and triangles and subject.system in (ADAPTIVE, BOUND):
        between, level = at_equal_error(entry.group, error)
        more["share_at_error"] = triangles / between if between else None
        more["share_of_level"] = triangles / level if level else None
    tags_s, selection_s = row.get("tags_s"), row.get("selection_s")
    if row.get("frame_s") and tags_s is not None and selection_s is not None:
        more["choosing_share"] = (tags_s + selection_s) / row["frame_s"]
    return more


TABLE = Table(
    id="gems3_adaptive",
    title="Adaptive patterns against uniform ones",
    source="Boubekeur & Schlick 2007, GPU Gems 3, chapter 5; Computer Graphics Forum 27(1), 2008: figures not known",
    groups=groups,
    own=own,
    # a tessellator cuts the same segments into rings, half as many triangles again: that is its way of doing the work
    any_count=(SHADER,),
    columns=(
        Column("work", "work"),
        Column("dataset", "dataset", brief=True),
        Column("system", "subject", brief=True),
        Column("segments", "at most segments"),
        Column("triangles_out", "triangles", brief=True),
        Column("vertices", "vertices"),
        Column("rms_difference", "RMS distance from the reference", "1"),
        Column("max_difference", "largest distance from the reference", "1", brief=True),
        Column("share_at_error", "share of uniform's triangles at equal error", "1", brief=True),
        Column("share_of_level", "share of the uniform level that does as well", "1", brief=True),
        *brief(WALL_COLUMNS, "wall_s"),
        Column("vertices_per_s", "vertices per second", "1/s"),
        *stage_columns(("tags", "selection", "vertex", "morph", "indices")),
        Column("choosing_share", "tags and selection, share of the frame", "1"),
        *FRAME_COLUMNS,
        *PATH_COLUMNS,
        Column("s_per_vertex", "time per vertex", "s"),
        *ratio_columns([BASELINE, SHADER], shown=()),
        *frame_ratio_columns([BASELINE]),
        *STATUS_COLUMNS,
    ),
    notes=(
        "error: coarse versions of scans and of a part, 1,000 triangles by fast-simplification, as curved PN "
        "triangles. The reference is the same surface with 128 segments; distances are from 200,000 of its vertices to "
        "the nearest point, as shares of the diagonal. Curvature refines until arcs are lower than the tolerance in a "
        "row's name.",
        "Share of uniform's triangles at equal error: those of uniform refinement with the same largest distance, "
        "between its levels interpolated, as if patterns of any number of segments were at hand. Share of the level "
        "that does as well: those of the coarsest power of two that is no farther away.",
        "A coarse version by quadric errors has small triangles where the surface bends: that leaves curvature less to "
        "gain than on meshes of even triangles. Tags are by the height of the arc over an edge, not by the angle "
        "between its normals alone, which is largest where edges are short.",
        "uncoupled: each triangle by itself with the fewest segments at which its flat pieces are as near as asked, "
        "with cracks: no pattern without them does with fewer at that tolerance. doubling: powers of two, as the pool.",
        "vertices: all_finest has the very vertices of uniform, out of the pool, its triangles listed or not; "
        "curvature has fewer, of many patterns; curvature_binned has the same, of triangles that lie sorted by "
        "pattern. A list of triangles is as many bytes as the vertices.",
        "draw: whole frames at 1280 x 1024 of the same camera, edges with the same segments on both sides; the driver "
        "cuts a triangle into rings.",
        "path: an orbit that draws back to 16 times the distance and returns; see gmr05_path. The largest move between "
        "views is how far any point of the surface goes from one view to the next, at the same parameters. Where an "
        "edge is coarser than its triangle, a level of that edge comes and goes with a change of triangles beside it, "
        "which geomorphing does not take away.",
    ),
)
