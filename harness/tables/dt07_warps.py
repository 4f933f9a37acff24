"""Warped clustering grids against even ones at equal triangles: around a place, and as an eye sees it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from lodbench.harness.plan.focus import Focus
from lodbench.harness.plan.group import Context, Group, Subject
from lodbench.harness.plan.table import (
    QUALITY_COLUMNS,
    WALL_COLUMNS,
    Column,
    Entry,
    Table,
    brief,
    ratio_columns,
)

OURS, EVEN = "quadric_clustering", "even"
REDUCTION = 0.95
WEIGHTS = (4, 16)
DEPTHS = ("log", "ndc")
REGIONS = {  # a head each, at about the size of the face
    "armadillo_86k": Focus((0.48, 0.83, 0.85), 0.08),
    "bunny_69k": Focus((0.2, 0.85, 0.6), 0.08),
    "dragon_100k": Focus((0.12, 0.8, 0.5), 0.08),
}
EYES = {  # before one end of each, as near as a visitor
    "dragon_100k": Focus((-0.15, 0.8, 0.8)),
    "armadillo_86k": Focus((0.4, 0.9, 1.3)),
    "terrain_100k": Focus((0.5, 0.0, 1.6)),
}
KEYS = (
    "triangles_inside", "triangles_outside", "rms_error_inside", "rms_error_outside",
    "rms_pixels", "rms_pixels_near", "rms_pixels_far",
)  # fmt: skip


def weighted(focus: Focus, weight: float) -> Callable[[Context], Mapping[str, Any]]:
    """As many triangles as the even grid left, finer in the ball."""

    def params(context: Context) -> Mapping[str, Any]:
        return {**_as_many(context), "regions": (focus.region(context.surface, weight),)}

    return params


def seen(focus: Focus, depth: str) -> Callable[[Context], Mapping[str, Any]]:
    """As many triangles as the even grid left, even where the eye has them."""

    def params(context: Context) -> Mapping[str, Any]:
        return {**_as_many(context), "view": focus.view(context.surface), "view_depth": depth}

    return params


def _as_many(context: Context) -> dict[str, Any]:
    return {"target_count": int(context.counter(EVEN, "triangles"))}


def groups(quick: bool) -> list[Group]:
    """Scans (or their stand-ins) with a region each, then with an eye, and a landscape; `quick`: one of each."""
    even = Subject(OURS, {"target_reduction": REDUCTION}, EVEN)
    found = []
    for name, focus in REGIONS.items():
        regions = (Subject(OURS, weighted(focus, w), f"region_{w}") for w in WEIGHTS)
        found.append(_group(name, focus, "region", even, *regions))
    for name, focus in EYES.items():
        views = (Subject(OURS, seen(focus, depth), f"view_{depth}") for depth in DEPTHS)
        found.append(_group(name, focus, "view", even, *views))
    return [found[0], found[len(REGIONS)]] if quick else found


def _group(name: str, focus: Focus, warp: str, *subjects: Subject) -> Group:
    facts = {"reduction": REDUCTION, "warp": warp}
    return Group(name, subjects, facts, True, weight=3.0, standin_ok=True, focus=focus)


def own(entry: Entry) -> Mapping[str, Any]:
    """What was found inside and outside of the focus, and what the even grid's error inside is to that."""
    quality = entry.subject.quality or {}
    even = entry.group.subjects.get(EVEN)
    key = "rms_pixels" if "rms_pixels" in quality else "rms_error_inside"
    before, after = ((even.quality if even else None) or {}).get(key), quality.get(key)
    return {
        **{name: quality.get(name) for name in KEYS},
        "closer": before / after if before and after else None,
    }


TABLE = Table(
    id="dt07_warps",
    title="Warped clustering grids at equal triangles: a region of interest, and an eye",
    source="DeCoro & Tatarchuk 2007, view-dependent and region-of-interest warps; published as pictures, no figures",
    groups=groups,
    own=own,
    columns=(
        Column("dataset", "dataset", brief=True),
        Column("warp", "warp", brief=True),
        Column("triangles_in", "triangles in"),
        Column("system", "subject", brief=True),
        Column("cells", "cells"),
        Column("triangles_out", "triangles out", brief=True),
        Column("triangles_inside", "triangles inside", brief=True),
        Column("triangles_outside", "triangles outside"),
        Column("rms_error_inside", "RMS error inside", "1", brief=True),
        Column("rms_error_outside", "RMS error outside", "1", brief=True),
        Column("rms_pixels", "RMS error, pixels", brief=True),
        Column("rms_pixels_near", "RMS error of the near half, pixels", brief=True),
        Column("rms_pixels_far", "RMS error of the far half, pixels", brief=True),
        Column("closer", "times closer than the even grid", "1", brief=True),
        *brief(WALL_COLUMNS, "wall_s"),
        *brief(QUALITY_COLUMNS, "nonmanifold_edges"),
        *ratio_columns((EVEN,), shown=()),
    ),
    notes=(
        "The even grid removes 95 % of the triangles; a warped one is searched for as many, 5 % fewer at the most.",
        "A region's cells are 4 or 16 times as fine at its centre as far away, along each axis; inside is the ball of "
        "one standard deviation, 8 % of the diagonal, about a place on the head.",
        "The eye stands before one end of the mesh and looks at its middle, at 1280 x 1024; inside is what the image "
        "has room for, hidden or not, and pixels are distances over depth, so that one which lies along the line of "
        "sight counts in full. Times closer is of pixels there, and of the error inside a region.",
        "What the image has no room for falls into the outermost cells: its error is large, and nobody sees it.",
        "A weight acts along each axis by itself, so that the slabs before, beside and over a region are finer too.",
    ),
)
