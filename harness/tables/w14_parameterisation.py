"""Three ways from a mesh to a sphere, and what a geometry image keeps of the mesh: Wang et al., section 2."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lodbench.datasets_gen import catalogue
from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.plan.table import (
    QUALITY_COLUMNS,
    WALL_COLUMNS,
    Column,
    Entry,
    Table,
    brief,
    stage_columns,
)

SMALL = ("knight_1k", "goathead_od", "spot", "wingnut_od", "elephant_mesh")
LARGE = ("bunny_closed_70k", "armadillo_86k", "koala_100k")
OTHERS = (
    "fandisk", "cheburashka", "fish_od", "penguin_od", "armadillo_29k", "boat_od", "bumpy_cube",
)  # fmt: skip
ALWAYS = "blob_with_ears_20k"  # generated, so that the table has rows without any scan
WEIGHTS = {name: 60.0 for name in LARGE} | {name: 30.0 for name in OTHERS}
STEPS = ("parameterise", "rotation", "resample")


def groups(quick: bool) -> list[Group]:
    """Every closed scan of genus 0 that is here, every mode, three seeds; `quick`: three small ones, one seed."""
    there = set(catalogue.names())
    names = SMALL[:3] if quick else (*SMALL, *OTHERS, *LARGE)
    system = "make_geometry_image"
    made = []
    for name in (ALWAYS, *names):
        if name not in there:
            continue
        subjects = [Subject(system, {"n": 8}, "coarse_to_fine", case="coarse_to_fine")]
        for seed in () if quick else (1, 2):
            params: dict[str, Any] = {"n": 8, "seed": seed}
            subjects.append(
                Subject(system, params, f"coarse_to_fine_seed_{seed}", case="coarse_to_fine")
            )
        for n in (7, 9):
            params = {"n": n, "cache": True}
            subjects.append(Subject(system, params, f"coarse_to_fine_n{n}", case="coarse_to_fine"))
        for mode in ("cmcf", "ray"):
            subjects.append(Subject(system, {"n": 8, "mode": mode}, mode, case="cmcf"))
        weight = WEIGHTS.get(name, 12.0)
        made.append(Group(name, tuple(subjects), {}, True, weight=weight, once=True))
    return made


def own(entry: Entry) -> Mapping[str, Any]:
    """Whether the sphere was read from disk."""
    return {"from_cache": "yes" if (entry.subject.params or {}).get("cache") else "no"}


TABLE = Table(
    id="w14_parameterisation",
    title="From a mesh to its geometry image",
    source="Wang, Liu, Feng & Li, section 2; no figures are published",
    groups=groups,
    own=own,
    columns=(
        Column("dataset", "dataset", brief=True),
        Column("triangles_in", "triangles"),
        Column("system", "way", brief=True),
        Column("n", "n", brief=True),
        Column("seed", "seed"),
        Column("from_cache", "sphere from cache"),
        *WALL_COLUMNS,
        *stage_columns(STEPS),
        Column("flipped", "turned over", brief=True),
        Column("flipped_before_repair", "turned over before repair"),
        Column("degree", "degree", brief=True),
        Column("area_least_hundredth", "relative area below which 1 % lies", "1", brief=True),
        Column("area_min", "least relative area", "1"),
        Column("area_max", "largest relative area", "1"),
        *brief(QUALITY_COLUMNS, "rms_error", "rms_error_back", "max_error"),
    ),
    notes=(
        "Times are of the whole set-up, on the host but for the star optimisation, one sample each: the first and only "
        "run. Sphere from cache: sampling is timed, with the sphere and its turn read from disk.",
        "Relative area: a triangle's share of the sphere over its share of the surface. Where it is small, the image "
        "has few samples and the feature is lost, though nothing is turned over.",
        "cmcf and ray are skipped where triangles stay turned over after repair; the reason says how many.",
        "Errors compare the full image's surface with the mesh.",
    ),
)
