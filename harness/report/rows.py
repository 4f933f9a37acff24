"""The rows of a table: what every table says of a subject, from records alone.

Each row has `status` (`ok`, `noisy`, `skipped`, `failed`; `published`: nothing of it was measured) and `reason`;
unknown values are None. Its other keys:

```
counters and params by their names, the group's facts over them; dataset, triangles_in, system
triangles_out, vertices_out, cells      what came out, and the grid that was asked for or found
wall_s, wall_s_min, _lower, _upper, samples, stage_fps      of the counted samples
wall_s_low, wall_s_high                 95 % interval of the median wall_s; None with fewer than 6 samples
frame_s_low, frame_s_high               the same of whole frames
wall_error                              how far its farther end is from the median, as a share of it
stage_s, <stage>_s                      device seconds, of all stages and of each
frame_s, frame_s_lower, _upper, frames, frame_fps           whole frames, drawn
steps, least_fps, most_fps, most_triangles, least_triangles, most_moved along a camera path
stored_vertices, stored_bytes, batches, memory_bytes, limit_share, first_launch_s
rms_error ... flipped_triangles, border_error   where quality was measured
ratio_to_<subject>, frame_ratio_to_<subject>, with _low and _high
slope, slope_low, slope_high            of a table's lines
```
`ratio_to_<subject>` says how many times faster the row is than that subject, taken turn by turn, with a 95 % bootstrap
interval; it is None where either of the two failed its check or ran in batches, or where they leave unlike numbers of
triangles: see `harness.report.ratios`.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np

from lodbench.harness.measure.limits import Limits
from lodbench.harness.measure.precision import median_interval
from lodbench.harness.plan.table import BORDER_COLUMN, QUALITY_COLUMNS, Entry, Row, Table
from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.report.ratios import frame_ratios, ratios, verdict
from lodbench.harness.report.statistics import log_slope, off, summary
from lodbench.kernels.system import Traffic


def measured(group: GroupRecord, subject: SubjectRecord) -> Row:
    """What every row says of its subject, but for what needs the run or other subjects."""
    params = {key: value for key, value in (subject.params or {}).items() if value is not None}
    status, reason = verdict(group, subject)
    row: Row = {**subject.counters, **params, **group.facts}
    row |= {
        "system": subject.label,
        "status": status,
        "reason": reason,
        "triangles_out": subject.counters.get("triangles"),
        "vertices_out": subject.counters.get("vertices"),
        "cells": group.facts.get(
            "cells", params.get("cells", subject.counters.get("cells_along_longest"))
        ),
        "first_launch_s": subject.phases.get("first_launch"),
        "memory_bytes": memory_bytes(group, subject),
    }
    row |= {
        key: subject.footprint.get(key) for key in ("stored_vertices", "stored_bytes", "batches")
    }
    measured = subject.quality or {}
    row |= {column.key: measured.get(column.key) for column in (*QUALITY_COLUMNS, BORDER_COLUMN)}
    return row | _times(subject) | _path(subject)


def _times(subject: SubjectRecord) -> Row:
    """Medians and quartiles of samples, stages and whole frames."""
    row: Row = {}
    for stage in subject.stages:
        found = summary(subject.stage_s(stage))
        row[f"{stage}_s"] = found.median if found else None
    wall, stages = summary(list(subject.wall_s.values())), summary(subject.stage_s())
    row["wall_s"] = wall.median if wall else None
    row["wall_s_min"] = wall.minimum if wall else None
    row["wall_s_lower"] = wall.lower if wall else None
    row["wall_s_upper"] = wall.upper if wall else None
    row["wall_s_low"], row["wall_s_high"] = median_interval(list(subject.wall_s.values()))
    row["wall_error"] = off(list(subject.wall_s.values()))
    row["samples"] = wall.n if wall else 0
    row["stage_fps"] = 1 / wall.median if wall and wall.median else None
    row["stage_s"] = stages.median if stages else None
    frames = summary(list(subject.frame_s.values()))
    row["frames"] = frames.n if frames else None
    row["frame_s"] = frames.median if frames else None
    row["frame_s_lower"] = frames.lower if frames else None
    row["frame_s_upper"] = frames.upper if frames else None
    row["frame_s_low"], row["frame_s_high"] = median_interval(list(subject.frame_s.values()))
    row["frame_fps"] = 1 / frames.median if frames else None
    return row


def steps(subject: SubjectRecord) -> dict[int, float]:
    """Step of the camera path -> median seconds of its frames."""
    return {step: float(np.median(found)) for step, found in sorted(subject.path_s.items())}


def _path(subject: SubjectRecord) -> Row:
    """The slowest and the fastest view of a camera path, and how much was drawn; nothing without a path."""
    seconds = steps(subject).values()
    if not seconds:
        return {}
    row: Row = {
        "steps": len(seconds),
        "least_fps": 1 / max(seconds),
        "most_fps": 1 / min(seconds),
    }
    drawn = [frame["triangles"] for frame in subject.frames if frame.get("triangles")]
    if drawn:
        row |= {"most_triangles": max(drawn), "least_triangles": min(drawn)}
    moved = [frame["moved"] for frame in subject.frames if "moved" in frame]
    return row | ({"most_moved": max(moved)} if moved else {})


def published(group: GroupRecord, system: str, **values: float | None) -> Row:
    """The row of a method that only the paper ran: the group's facts and `published_*` values alone."""
    return {**group.facts, "system": system, "status": "published", **values}


def memory_bytes(group: GroupRecord, subject: SubjectRecord) -> int | None:
    """What the subject holds while it runs: a device's buffers, or a host's input and the rise of its memory peak.

    The rise is a lower bound: memory that a package kept from an earlier call is not counted again, so subjects of
    one system share the highest. None where it is not known; that of a call into the device's pool says nothing.
    """
    parts = ("input_bytes", "pattern_bytes", "output_bytes", "scratch_bytes")
    if subject.stages and subject.stages != ["call"]:
        return sum(subject.footprint.get(part) or 0 for part in parts)
    same = [other for other in group.subjects.values() if other.system == subject.system]
    rises = [other.peak_growth_bytes for other in same if other.peak_growth_bytes is not None]
    if not rises or subject.system == "simplify_call":
        return None
    return (subject.footprint.get("input_bytes") or 0) + max(rises)


def limit_share(run: RunRecord, subject: SubjectRecord) -> float | None:
    """Which share of the device's measured limits its stages reach: least possible over median device time.

    Source: Williams, Waterman & Patterson 2009, Roofline: bytes over bandwidth, or operations over their peak rate.
    """
    stages = {name: summary(subject.stage_s(name)) for name in subject.traffic}
    ran = set(subject.traffic) <= set(subject.stages)
    if run.limits is None or not stages or not ran or None in stages.values():
        return None
    limits = Limits.of_record(run.limits)
    least = sum(limits.least_s(Traffic(**traffic)) for traffic in subject.traffic.values())
    spent = sum(stage.median for stage in stages.values() if stage)
    return least / spent if spent else None


def _one_core(group: GroupRecord, label: str) -> bool:
    subjects = group.config.get("subjects", ())
    return any(subject["label"] == label and subject.get("one_core") for subject in subjects)


def _row(table: Table, run: RunRecord, group: GroupRecord, subject: SubjectRecord) -> Row:
    seed = group.config.get("seed", run.environment["seed"])
    row = measured(group, subject)
    asked = any(column.key == "limit_share" for column in table.columns)
    if asked and not _one_core(group, subject.label):  # whose own limits were not measured
        row["limit_share"] = limit_share(run, subject)
    row |= ratios(group, subject, table.named("ratio_to"), seed, any_count=table.any_count)
    row |= frame_ratios(group, subject, table.named("frame_ratio_to"), seed)
    return row | dict(table.own(Entry(run, group, subject, row)))


def _fit(table: Table, rows: Sequence[Row]) -> None:
    """Put the slope of the logarithm of time over that of size into the rows of each of the table's lines."""
    lines: dict[Hashable, list[Row]] = {}
    for row in rows:
        timed = row.get("wall_s") and row["status"] in ("ok", "noisy")
        if timed and (name := table.line(row)) is not None:
            lines.setdefault(name, []).append(row)
    for line in lines.values():
        fit: Any = log_slope([row[table.size] for row in line], [row["wall_s"] for row in line])
        if fit:
            for row in line:
                row["slope"], row["slope_low"], row["slope_high"] = fit


def table_rows(table: Table, run: RunRecord) -> list[Row]:
    """One row per subject of each of the table's whole groups, in the order of its definition."""
    rows: list[Row] = []
    for group in run.of_table(table.id):
        rows += [_row(table, run, group, subject) for subject in group.subjects.values()]
        rows += table.also(group)
    _fit(table, rows)
    return rows
