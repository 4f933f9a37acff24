"""A run's folder made up for tests: two groups of shapes, seeded samples, no device needed."""

import json
from pathlib import Path

import numpy as np

from lodbench.harness.plan.table import (
    QUALITY_COLUMNS,
    STATUS_COLUMNS,
    WALL_COLUMNS,
    Column,
    Table,
    ratio_columns,
)
from lodbench.harness.record.record import RUN, SCHEMA, Writer, write_json
from lodbench.harness.report.document import write
from lodbench.harness.report.ratios import counts

ENVIRONMENT = {
    "schema": SCHEMA,
    "started": "2020-02-02T02:02:02+00:00",
    "commit": "0a1b2c3",
    "dirty": False,
    "machine": {"cpu": "Test CPU <x>", "cores": 2, "memory_bytes": 8 << 30, "system": "Linux",
                "python": "3.11.7", "governor": None, "load": 0.4},
    "slug": "pocl-test",
    "device": {"name": "pthread-test", "platform": "Portable Computing Language",
               "driver": "OpenCL 1.2 PoCL 3.0; driver 3.0", "version": "OpenCL 1.2", "kind": "cpu",
               "compute_units": 2, "memory_bytes": 6 << 30, "prelude": True},
    "pocl": "3.0",
    "llvm": "14.0.6",
    "packages": {"numpy": "2.0", "vtk": None},
    "variables": {"POCL_DEVICES": "pthread"},
    "options": {"tables": ["clustering", "patterns"], "quick": True},
    "seed": 0,
}  # fmt: skip

# seconds per triangle, error at 1,000 triangles, stages with their shares, triangles kept
CLUSTERING = {
    "quadric_clustering": (1e-8, 2e-3, {"vertex": 0.2, "pass_1_and_3": 0.6, "solve": 0.2}, 0.09),
    "fast_simplification": (9e-7, 1.6e-3, {"call": 1.0}, 0.09),
    "vtk_binned_decimation": (3e-8, 6e-3, {"call": 1.0}, 0.09),
    "numpy_quadric_clustering": (4e-7, 2e-3, {"call": 1.0}, 0.09),
    "meshoptimizer_sloppy": (6e-8, 4e-3, {"call": 1.0}, 0.08),
}


def _subject(writer, ids, rng, name, wall_s, stages, *, n=12, spread=0.02, **facts):
    writer.write(
        "setup", **ids, subject=name, system=name, params={"cells": 32},
        phases={"build": 0.02, "first_launch": 0.3, "upload": 0.001, "prepare": 0.33},
        from_cache={"build": False}, memory_growth_bytes=1 << 20,
    )  # fmt: skip
    for turn in range(n + 3):
        wall = wall_s * (1 + abs(rng.normal(0, spread)) + (0.5 if turn == 0 else 0))
        writer.write(
            "sample", **ids, subject=name, turn=turn, warmup=turn < 3, wall_s=wall,
            cpu_s=1.9 * wall, load=0.5,
            stage_s={stage: 0.95 * share * wall for stage, share in stages.items()},
        )  # fmt: skip
    writer.write(
        "subject", **ids, subject=name,
        **{"status": "ok", "reason": "", "traffic": {},
           "check": {"passed": True, "what": "distance", "value": 1e-7, "tolerance": 1e-6}, **facts},
    )  # fmt: skip


def _clustering(writer, rng):
    for size in (5, 6, 7, 8):
        triangles = 20 * 4**size
        ids = {"group": f"c{size}", "attempt": 0}
        facts = {"dataset": f"icosphere_{size}", "standin": False, "triangles_in": triangles,
                 "vertices_in": triangles // 2 + 2}  # fmt: skip
        writer.write("begin", **ids, table="clustering", name=facts["dataset"],
                     dataset=facts["dataset"], device="pocl-test", facts=facts, config={})  # fmt: skip
        for name, (rate, error, stages, kept) in CLUSTERING.items():
            out = int(kept * triangles)
            _subject(
                writer, ids, rng, name, 2e-4 + rate * triangles, stages,
                spread=0.9 if name == "numpy_quadric_clustering" and size == 6 else 0.02,
                counters={"triangles": out, "vertices": out // 2},
                footprint={"stored_vertices": out // 2, "stored_bytes": 18 * out, "batches": 1},
                quality={"rms_error": error * 1000 / out, "rms_error_back": 1.1 * error * 1000 / out,
                         "max_error": 9 * error * 1000 / out, "open_edges": 0,
                         "nonmanifold_edges": out // 90, "flipped_triangles": 3},
            )  # fmt: skip
        writer.write(
            "subject", **ids, subject="manifold3d", status="skipped",
            reason="needs manifold3d, this environment has none <script>alert(1)</script>",
        )  # fmt: skip
        writer.write("end", **ids, others=0.01, seconds=3.0)


def _patterns(writer, rng):
    for segments in (64, 128):
        for coarse in (10, 100, 1000):
            vertices = coarse * (segments + 1) * (segments + 2) // 2
            ids = {"group": f"p{segments}-{coarse}", "attempt": 0}
            facts = {"dataset": f"ball_{coarse}", "standin": True, "triangles_in": coarse,
                     "segments": segments, "coarse_triangles": coarse}  # fmt: skip
            writer.write("begin", **ids, table="patterns", name=f"ball_{coarse}",
                         dataset=facts["dataset"], device="pocl-test", facts=facts, config={})  # fmt: skip
            for name, rate, stored in (
                ("static_vbo", 1.2e-9, vertices * 24),
                ("pattern", 1e-9, 4e3),
            ):
                failed = name == "static_vbo" and (segments, coarse) == (128, 1000)
                _subject(
                    writer, ids, rng, name, 3e-5 + rate * vertices,
                    {"vertex": 0.7, "geometry": 0.3},
                    status="failed" if failed else "ok",
                    reason="check: distance is 1, tolerance 0" if failed else "",
                    counters={"triangles": coarse * segments**2, "vertices": vertices},
                    footprint={"stored_vertices": vertices, "stored_bytes": int(stored), "batches": 1},
                    quality=None,
                )  # fmt: skip
            writer.write("end", **ids, others=0.0, seconds=1.0)


PUBLISHED = {(64, 10): 912.0, (64, 100): 105.0, (128, 10): 411.0}


def _pattern(entry):
    row, mine = entry.row, entry.subject.label == "pattern"
    key = row["segments"], row["coarse_triangles"]
    return {
        "frame_fps": 1 / row["wall_s"] if counts(entry.subject) else None,
        "published_frame_fps": PUBLISHED.get(key) if mine else None,
    }


TABLES = [
    Table(
        id="clustering",
        title="Clustering against edge collapse",
        source="Made up for a test",
        groups=lambda quick: [],
        columns=(
            Column("dataset", "dataset"),
            Column("triangles_in", "triangles in"),
            Column("system", "system"),
            Column("triangles_out", "triangles out"),
            *WALL_COLUMNS,
            Column("stage_s", "device time", "s"),
            Column("stored_bytes", "stored", "B"),
            *QUALITY_COLUMNS,
            *ratio_columns(["fast_simplification"]),
            *STATUS_COLUMNS,
        ),
        notes=("Errors are shares of the diagonal & nothing else.",),
    ),
    Table(
        id="patterns",
        title="Refinement patterns",
        source="Made up for a test; published on a GeForce 1",
        groups=lambda quick: [],
        columns=(
            Column("segments", "segments"),
            Column("coarse_triangles", "coarse triangles"),
            Column("system", "system"),
            Column("triangles_out", "triangles out"),
            Column("frame_fps", "frame fps", "1/s"),
            Column("published_frame_fps", "published fps", "1/s"),
            Column("stored_bytes", "stored", "B"),
            *WALL_COLUMNS,
            *STATUS_COLUMNS,
        ),
        own=_pattern,
    ),
]


def make_run(folder: Path) -> Path:
    """The folder, with its record and its tables."""
    folder.mkdir(parents=True, exist_ok=True)
    write_json(folder / RUN, ENVIRONMENT)
    writer, rng = Writer(folder), np.random.default_rng(7)
    rate = {
        "subject": "kernel",
        "unit": "B/s",
        "best": 2.7e10,
        "median": 2.6e10,
        "samples": [2.7e10],
    }
    writer.write("limits", device="pthread-test", size_bytes=1 << 28, fill=rate, copy=rate,
                 multiply_add={**rate, "unit": "flop/s", "best": 9.9e10},
                 launch_wall={**rate, "unit": "s"}, launch_event={**rate, "unit": "s"})  # fmt: skip
    _clustering(writer, rng)
    _patterns(writer, rng)
    writer.close()
    from lodbench.harness.record.record import read_run

    for table in TABLES:
        write(table, read_run(folder))
    return folder


def edit_table(folder: Path, name: str, change) -> None:
    """Apply `change` to a written table's document."""
    path = folder / "tables" / f"{name}.json"
    made = json.loads(path.read_text())
    change(made)
    path.write_text(json.dumps(made))
