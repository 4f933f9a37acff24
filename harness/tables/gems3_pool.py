"""The pool of adaptive patterns: how many there are and what they take, by the largest depth. GPU Gems 3, chapter 5."""

from __future__ import annotations

from collections.abc import Mapping
from math import comb
from typing import Any

from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.plan.table import Column, Entry, Table

DEPTHS = tuple(range(8))
DATASET = "sphere_100"


def groups(quick: bool) -> list[Group]:
    """A pool for each largest depth; `quick` leaves out the one that takes seconds to make."""
    depths = DEPTHS[:-1] if quick else DEPTHS
    subjects = tuple(
        Subject("adaptive_patterns", {"segments": 1 << depth, "by": "distance"}, f"depth_{depth}")
        for depth in depths
    )
    return [Group(DATASET, subjects, weight=1.0)]


def own(entry: Entry) -> Mapping[str, Any]:
    """What the pool holds, as the subject counted it."""
    counters = entry.subject.counters
    depth = counters["segments"].bit_length() - 1 if counters else None
    return {
        "depth": depth,
        "unique_patterns": None if depth is None else comb(depth + 3, 3),
        **{
            key: counters.get(key)
            for key in (
                "segments", "patterns", "lattice_vertices", "pool_triangles", "pool_index_bytes",
                "pool_bytes",
            )
        },
    }  # fmt: skip


TABLE = Table(
    id="gems3_pool",
    title="The pool of adaptive refinement patterns",
    source="Boubekeur & Schlick 2007, GPU Gems 3, chapter 5; no figures of its memory are published",
    groups=groups,
    own=own,
    columns=(
        Column("depth", "largest depth", brief=True),
        Column("segments", "segments", brief=True),
        Column("system", "subject"),
        Column("patterns", "patterns", brief=True),
        Column("unique_patterns", "unique but for turns", brief=True),
        Column("lattice_vertices", "lattice vertices", brief=True),
        Column("pool_triangles", "triangles of all", brief=True),
        Column("pool_index_bytes", "index lists", "B", brief=True),
        Column("pool_bytes", "with vertices and records", "B", brief=True),
        Column("triangles_out", "triangles refined"),
        Column("wall_s", "median wall", "s"),
    ),
    notes=(
        "A pattern for every three depths of a triangle's edges, (depth + 1)^3 in all. The source indexes them so and "
        "keeps one lattice of vertices; which triangles a pattern has it leaves open, and here a vertex of the uniform "
        "lattice goes to the nearest that the edge keeps. Patterns that differ by a turn or a mirror image could share "
        "a list; they do not.",
        "With vertices and records: each pattern has its weights one after the other too, eight bytes a vertex, so "
        "that the vertex stage reads whole vectors.",
    ),
)
