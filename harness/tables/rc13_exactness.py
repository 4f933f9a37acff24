"""Every tessellation of Bezier patches against exact values: systems of Concheiro 2013, chapters 2 to 5."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lodbench.harness.plan.group import Context, Group, Subject
from lodbench.harness.plan.table import STATUS_COLUMNS, Column, Entry, Table, untimed

MODELS = ("teapot", "teacup", "teaspoon", "elephant_gumbo")
LEVEL = 4
SIZE = {"level": LEVEL}
NEAR = ("points", "normals")
LEVELS = range(2, 6)
REUSES, MEMORIES = ("row", "zone", "none"), ("uniform", "texture", "global")
GL = ("gl_vst", "gl_gst", "gl_bezier_tessellation")


def unlike_levels(context: Context) -> Mapping[str, Any]:
    """Another level for each patch than for the one before."""
    return {"levels": tuple(LEVELS[k % len(LEVELS)] for k in range(len(context.surface.points)))}


def _groups(model: str) -> list[Group]:
    def group(work: str, subjects: Sequence[Subject], *names: str) -> Group:
        return Group(
            model, tuple(subjects), {"work": work, "scene": model}, standin_ok=True, once=True,
            exact=(*NEAR, *(names or ("cracks",))),
        )  # fmt: skip

    leveled = ("vst", "gst", "vsthd")
    return [
        group(
            "same vertices",
            [
                Subject("vst", SIZE),
                *(Subject("gst", SIZE | {"reuse": reuse}, f"gst, {reuse}") for reuse in REUSES),
            ],
            "cracks",
            "vertices",
        ),
        group(
            "same bytes",
            [
                Subject("vsthd", SIZE | {"memory": memory}, f"vsthd, {memory}")
                for memory in MEMORIES
            ],
            "cracks",
            "bytes",
        ),
        group("levels unlike", [Subject(name, unlike_levels, name) for name in leveled]),
        group(
            "adaptive",
            [
                *(Subject(name, {"level": LEVEL + 1}) for name in ("dabt", "semi_adaptive")),
                Subject("dx11", SIZE),
                Subject("dx11", {"factor": 7.5, "edges": "length", "spacing": "odd"}, "dx11, odd"),
            ],
        ),
        group("real shaders", [Subject(name, SIZE | {"output": "points"}) for name in GL], "open"),
    ]


def groups(quick: bool) -> list[Group]:
    """Every model; `quick` has the smallest."""
    return [group for model in (MODELS[2:3] if quick else MODELS) for group in _groups(model)]


def own(entry: Entry) -> Mapping[str, Any]:
    """The figures by name, and how much they are of."""
    found = dict(entry.subject.exact)
    if "open" in found:
        found["cracks"] = found.pop("open")
    return {
        **{f"exact_{name}": figure["value"] for name, figure in found.items()},
        "looked_at": found["points"]["looked_at"] if "points" in found else None,
        **untimed(entry.row),
    }


TABLE = Table(
    id="rc13_exactness",
    title="Bezier tessellations against exact values",
    source="none; systems of Concheiro 2013, chapters 2 to 5. Limits are ours",
    groups=groups,
    own=own,
    columns=(
        Column("scene", "scene", brief=True),
        Column("dataset", "dataset"),
        Column("work", "compared"),
        Column("system", "subject", brief=True),
        Column("triangles_out", "triangles", brief=True),
        Column("looked_at", "looked at"),
        Column("exact_points", "points off, of the diagonal (1e-6)", "1", brief=True),
        Column("exact_normals", "normals off, degrees (0.1)", "1", brief=True),
        Column("exact_cracks", "open edges where patches meet (0)", brief=True),
        Column("exact_vertices", "vertices apart from vst's (0)", brief=True),
        Column("exact_bytes", "bytes unlike constant memory's (0)", brief=True),
        Column("wall_s", "first frame", "s"),
        *STATUS_COLUMNS,
    ),
    notes=(
        "In brackets the limit: a row over one of them has failed. Points: the largest error of a coordinate against "
        "float64. Normals: the largest angle, but where the surface has none of its own, as at a collapsed edge.",
        "Open edges: of triangles that no other has, to the bit, apart from borders of one patch alone; real "
        "shaders are rivals that have no rule for borders, and are not held to the limit. Vertices: "
        "of patches, at the same parameters, that are not within 1e-6 of the diagonal; sums differ in their order. "
        "Bytes: of points, normals and triangles.",
        "16 segments along each side of a patch; adaptive ones have up to 32, by the test of distance, high quality. "
        "Levels unlike: 2, 3, 4, 5, 2 ... one patch after the other.",
    ),
)
