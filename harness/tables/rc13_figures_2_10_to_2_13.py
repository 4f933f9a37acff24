"""Vertex shader against geometry shader tessellation by level: Concheiro 2013, figures 2.10 to 2.13."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lodbench.harness.plan.group import Draw, Group, Subject
from lodbench.harness.plan.table import (
    FRAME_COLUMNS,
    STATUS_COLUMNS,
    WALL_COLUMNS,
    Column,
    Entry,
    Row,
    Table,
    brief,
    frame_ratio_columns,
    interval_columns,
    ratio_columns,
)
from lodbench.harness.report.ratios import ratios
from lodbench.kernels.bezier.lattice import side_vertices
from lodbench.kernels.stages.camera import TABLE_SIZE
from lodbench.kernels.subject import POINT

MODELS = ("teapot", "teacup", "elephant_gumbo")
COPIES = 5
LEVELS = (4, 5, 6)
DRAW = Draw(TABLE_SIZE, apart=True)
GST, ZONE, NONE = "gst", "gst_zone_reuse", "gst_no_reuse"
POINTS = "vst_positions"
SHADERS = ("gl_vst", "gl_gst", "gl_bezier_tessellation")
FLAT, FILL = "flat_patches", "device_fill"
BASELINES = (
    GST,
    NONE,
    "dx11",
    "numpy_bezier",
    "scipy_bspline",
    "splipy",
    "vst_one_core",
    *SHADERS,
    FILL,
)
SHADED_LEVELS = (4, 5)
WHOLE = Draw(TABLE_SIZE)
ALONE = ((False, 7), (True, 7), (True, 5))  # normals, level
ARRAYS = ("one model, positions", "one model, with normals")
TAKES = (GST, "numpy_bezier")  # are told whether to make normals
PATCHES = 32  # of the first model
PEERS = {False: ("numpy_bezier", "scipy_bspline", "splipy", FILL), True: ("numpy_bezier", FLAT)}
REUSE = {GST: "zone and row", ZONE: "zone", NONE: "none"}


def _scene(model: str, level: int) -> Group:
    size: dict[str, Any] = {"level": level}
    subjects = (
        Subject("vst", size, draw=DRAW),
        Subject("gst", size, GST, draw=DRAW),
        Subject("gst", {**size, "reuse": "zone"}, ZONE),
        Subject("gst", {**size, "reuse": "none"}, NONE),
        Subject("vst", size, "vst_one_core", one_core=True),
        Subject("dx11", size, draw=DRAW),
    )
    facts = {"scene": f"S{COPIES} {model}", "level": level}
    weight = 1 + 4.0**level / 500
    return Group(_scene_name(model, COPIES), subjects, facts, weight=weight, standin_ok=True)


def _against(dataset: str, scene: str, peer: str, level: int, **more: Any) -> Group:
    """Ours and one peer alone, so that nothing but the two takes the caches and the cores."""
    size: dict[str, Any] = {"level": level}
    theirs = size | (more if peer in TAKES else {})
    if peer == FILL:
        theirs = {"size_bytes": PATCHES * POINT * side_vertices(level) ** 2}
    subjects = (Subject("vst", size | more), Subject(peer, theirs))
    facts = {"scene": scene, "level": level, "against": peer}
    return Group(dataset, subjects, facts, standin_ok=True, warm=True)


def _alone(normals: bool, level: int) -> list[Group]:
    more: dict[str, Any] = {"normals": normals}
    return [
        _against(MODELS[0], ARRAYS[normals], peer, level, **more) for peer in (GST, *PEERS[normals])
    ]


def _shaded(model: str, copies: int, level: int, drawn: bool = True) -> Group:
    """Ours and those of a driver's shaders, in turns: whole frames, or points and normals alone."""
    size: dict[str, Any] = {"level": level}
    output = "image" if drawn else "points"
    theirs = {**size, "output": output, "width": TABLE_SIZE[0], "height": TABLE_SIZE[1]}
    draw = WHOLE if drawn else None
    subjects = (
        Subject("vst", size, draw=draw),
        Subject("gst", size, GST, draw=draw),
        *(Subject(name, theirs) for name in SHADERS),
    )
    facts = {"scene": f"S{copies} {model}, {'drawn' if drawn else 'points kept'}", "level": level}
    weight = 2.0 * 4 ** (level - 4)
    name = _scene_name(model, copies)
    return Group(name, subjects, facts, weight=weight, standin_ok=True, warm=True)


def _scene_name(model: str, copies: int) -> str:
    return model if copies == 1 else f"{model}_x{copies}"


def groups(quick: bool) -> list[Group]:
    """Each scene at each level, whole frames against a driver's shaders, then a teapot by itself.

    `quick` has the teapots alone at two levels, against shaders one teapot.
    """
    made = []
    for model in MODELS[:1] if quick else MODELS:
        for level in LEVELS[:2] if quick else LEVELS:
            made.append(_scene(model, level))
            name, scene = _scene_name(model, COPIES), f"S{COPIES} {model}"
            made.append(_against(name, scene, "numpy_bezier", level))
    made += [_shaded(MODELS[0], 1, level) for level in SHADED_LEVELS]
    made.append(_shaded(MODELS[0], 1, SHADED_LEVELS[-1], drawn=False))
    if not quick:
        made += [_shaded(model, COPIES, SHADED_LEVELS[-1]) for model in MODELS]
    return [*made, *(one for normals, level in ALONE for one in _alone(normals, level))]


def _flat_rate(entry: Entry, vertices: int) -> Row:
    """Vertices per second over those of the flat pattern, which has a column more of them."""
    flat = entry.group.subjects.get(FLAT)
    theirs = flat.counters.get("vertices") if flat else None
    found = ratios(entry.group, entry.subject, [FLAT])
    keys = {f"ratio_to_{FLAT}{end}": f"rate_to_{FLAT}{end}" for end in ("", "_low", "_high")}
    if not theirs or found[f"ratio_to_{FLAT}"] is None:
        return {}
    return {name: found[key] * vertices / theirs for key, name in keys.items()}


def own(entry: Entry) -> Mapping[str, Any]:
    """Vertices per second, each of those that are written; what was reused, and how many zones."""
    row = entry.row
    vertices, wall = row["vertices_out"], row["wall_s"]
    triangles = row["triangles_out"]
    more: Row = {"triangles_k": triangles / 1000 if triangles else None}
    drawn = str(row.get("scene")).endswith("drawn")
    if vertices and wall and not drawn:
        more["vertices_per_s"] = vertices / wall
        more |= _flat_rate(entry, vertices)
    if entry.subject.system == "gst":
        more["reused"] = REUSE[entry.subject.label]
    if wall and drawn:  # a sample is a whole frame
        more["frame_fps"] = 1 / wall
    if entry.subject.driver:
        more["driver"] = entry.subject.driver
    return more


TABLE = Table(
    id="rc13_figures_2_10_to_2_13",
    title="Vertex shader against geometry shader tessellation",
    source="Concheiro 2013, figures 2.10 to 2.13; published on a GeForce 9800 GTX, an ATI 3870 X2 and an ATI 5870, "
    "whose values were not at hand",
    groups=groups,
    own=own,
    columns=(
        Column("scene", "scene", brief=True),
        Column("dataset", "dataset"),
        Column("level", "L", brief=True),
        Column("triangles_k", "triangles, thousands", brief=True),
        Column("system", "system", brief=True),
        Column("against", "against"),
        Column("reused", "reused"),
        Column("zones", "zones"),
        Column("zone_values", "values of a zone"),
        *WALL_COLUMNS,
        Column("stage_s", "device time", "s"),
        *FRAME_COLUMNS,
        Column("vertices_out", "vertices written"),
        Column("vertices_per_s", "vertices per second", "1/s", brief=True),
        Column("stored_bytes", "stored", "B"),
        *ratio_columns(BASELINES, shown=(GST, "dx11", "numpy_bezier", *SHADERS)),
        *interval_columns(f"rate_to_{FLAT}", "rate over the flat pattern's", "over it, "),
        *brief(frame_ratio_columns([GST, "dx11"])),
        Column("published_frame_fps", "published fps", "1/s"),
        Column("driver", "driver"),
        *STATUS_COLUMNS,
    ),
    notes=(
        "Frame fps adds raster and shading at 1280 x 1024 with the whole scene in view. In the groups named drawn "
        "every sample is a whole frame, ours and the driver's in turns, with the same camera and colours; there "
        "ratios are of whole frames. Points kept: the stages before the raster alone, the driver's by transform "
        "feedback. Its geometry shader and its tessellator leave triangles that share no points.",
        "A geometry shader emits strips, so inner rows are written twice, in zones of at most 1024 numbers. With "
        "reuse, a zone evaluates the surface by powers once and each row its curve; without, every sample begins with "
        "the control points. Triangles are the same for all.",
        "dx11 cuts patches as the tessellator of DirectX 11 does, here by equal whole factors, and evaluates every "
        "vertex by itself, as its domain shader does.",
        "Each peer on the host takes turns with vst alone, in a group of two: where several share a group, each finds "
        "the caches full of the others' points and the cores asleep or still held by others' threads. "
        "There every sample, ours or a peer's, follows at once on frames of the same subject that are not timed. "
        "The shaders share theirs, warm as well: frames per second are those of a loop.",
        "numpy_bezier is two matrix products for points; its normals take three passes more. "
        "scipy_bspline and splipy make points alone, in float64.",
        "device_fill writes as many bytes as the points of the model have and computes nothing.",
        "The flat pattern evaluates two flat triangles between the corners of each patch: as many triangles, more "
        "vertices. It is compared by vertices per second, points and normals.",
    ),
)
