"""A sine displacement under coarser and finer patterns: Boubekeur & Schlick 2005, figure 4, as an error."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.plan.table import WALL_COLUMNS, Column, Entry, Table, brief

DATASET = "torus_36"  # of few triangles, over which the distance from the origin changes much
SEGMENTS = tuple(1 << depth for depth in range(9))  # the paper shows 1, 16 and 256
REFERENCE = 512
WAVES = (16.0, 64.0)  # per diagonal; the second has its limit between 16 and 256 segments
AMPLITUDE = 0.008


@cache
def longest_edge(name: str) -> float:
    """Of a dataset's triangles, as a share of its diagonal, four digits."""
    mesh = catalogue.find(name).surface
    assert isinstance(mesh, TriangleMesh)
    corners = mesh.positions.astype(np.float64)[mesh.triangles]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max()
    return round(float(longest) / mesh.diagonal, 4)


def groups(quick: bool) -> list[Group]:
    """Patterns of 1 to 256 segments and the reference, a slow wave and a fast one; `quick` has the fast one."""
    made = []
    for waves in WAVES[1:] if quick else WAVES:
        wave = {"displacement": "sine", "amplitude": AMPLITUDE, "waves": waves}
        subjects = [
            Subject("pattern", {"segments": segments, **wave}, f"pattern_{segments}")
            for segments in (*SEGMENTS, REFERENCE)
        ]
        facts = {"waves": waves, "longest_edge": longest_edge(DATASET)}
        made.append(Group(DATASET, tuple(subjects), facts, weight=6.0, reference=subjects[-1].name))
    return made


def own(entry: Entry) -> Mapping[str, Any]:
    """How densely the wave is sampled, and what that leaves out: one line of rows per wave."""
    row, quality = entry.row, entry.subject.quality or {}
    edge_waves = row["waves"] * row["longest_edge"]
    segments = row.get("segments")
    return {
        "system": entry.subject.system,
        "least_segments": 2 * edge_waves,
        "samples_per_wave": segments / edge_waves if segments else None,
        "rms_difference": quality.get("rms_difference"),
        "max_difference": quality.get("max_difference"),
    }


TABLE = Table(
    id="gmr05_figure4",
    title="Aliasing of a displacement against the size of the pattern",
    source="Boubekeur & Schlick 2005, figure 4, shown for patterns of 1, 16 and 256 segments; no figures are published",
    groups=groups,
    own=own,
    columns=(
        Column("waves", "waves per diagonal", brief=True),
        Column("longest_edge", "longest edge / diagonal", "1"),
        Column("least_segments", "segments needed, more than", brief=True),
        Column("system", "system"),
        Column("segments", "segments", brief=True),
        Column("triangles_out", "triangles", brief=True),
        Column("samples_per_wave", "samples per wave", brief=True),
        Column("rms_difference", "RMS difference", "1", brief=True),
        Column("max_difference", "largest difference", "1", brief=True),
        *brief(WALL_COLUMNS, "wall_s"),
        Column("stage_s", "device time", "s"),
    ),
    notes=(
        f"Differences are from the same surface with {REFERENCE} segments, at the parameters of its vertices, as "
        "shares of the diagonal; every coarse triangle counts alike. They include how far flat triangles lie from a "
        "curved surface, which goes on falling where aliasing has ended.",
        "The displacement is a sin(f |P|). |P| changes along an edge by at most its length, so that more than "
        "f L / pi segments take more than two samples of every wave, L being the longest coarse edge: samples per wave "
        "are those along it. This is enough, and more than is needed where the edge does not point at the origin.",
        f"The paper's mesh, amplitude and frequency are not known: here {DATASET} is raised by {AMPLITUDE} diagonals.",
    ),
)
