"""How many times faster one subject is than another: only where both are verified and leave like counts."""

from __future__ import annotations

from collections.abc import Container, Iterable
from typing import Any

from lodbench.harness.measure.precision import ENOUGH
from lodbench.harness.record.record import GroupRecord, SubjectRecord
from lodbench.harness.report.statistics import Ratio, noise, paired_ratio, unpaired_ratio

LIKE_COUNTS = 0.05
"""Share of the larger by which two triangle counts may differ for times to be compared: what a search for a grid keeps
its target to."""


def verdict(group: GroupRecord, subject: SubjectRecord) -> tuple[str, str]:
    """Status and reason of a row: the subject's own, or "noisy" where its samples are."""
    if subject.status == "ok":
        cpu = [row["cpu_s"] for row in subject.samples]
        why = noise(list(subject.wall_s.values()), cpu, group.others)
        if why:
            return "noisy", why
    return subject.status, subject.reason


def counts(subject: SubjectRecord | None) -> bool:
    """May this subject stand in a ratio: verified, measured, and not run in batches?"""
    return (
        subject is not None
        and subject.status == "ok"
        and bool(subject.samples)
        and (subject.footprint.get("batches") or 1) == 1
    )


def like(subject: SubjectRecord, other: SubjectRecord) -> bool:
    """Do both leave about as many triangles? Also where either counts none, such as a fill."""
    ours, theirs = (one.counters.get("triangles") for one in (subject, other))
    if ours is None or theirs is None:
        return True
    return abs(ours - theirs) <= LIKE_COUNTS * max(ours, theirs)


def interval(key: str, ratio: Ratio | None) -> dict[str, float | None]:
    """The three columns of a ratio; None where there is none."""
    values = (ratio.median, ratio.low, ratio.high) if ratio else (None,) * 3
    return dict(zip((key, f"{key}_low", f"{key}_high"), values, strict=True))


def ratios(
    group: GroupRecord,
    subject: SubjectRecord,
    baselines: Iterable[str],
    seed: int = 0,
    any_count: Container[str] = (),
) -> dict[str, Any]:
    """How many times faster `subject` is than each baseline of its group, with intervals.

    Args:
        group: where both took turns.
        subject: whose row it is.
        baselines: labels.
        seed: of the bootstrap.
        any_count: labels of subjects that stand in a ratio whatever they leave, because that is the comparison.

    Returns:
        The columns of `ratio_columns`; with the row's `reason` where counts are too unlike for one, or samples too few
        for its interval.
    """
    row: dict[str, Any] = {}
    unlike: dict[Any, list[str]] = {}
    few: dict[int, list[str]] = {}
    for name in baselines:
        other = group.subjects.get(name)
        ratio = None
        if other is not None and name != subject.label and counts(subject) and counts(other):
            theirs, ours = other.wall_s, subject.wall_s
            if like(subject, other) or name in any_count or subject.label in any_count:
                ratio = paired_ratio(theirs, ours, seed)
                if ratio is None:  # a subject over 30 s has one sample, in a turn of its own
                    ratio = unpaired_ratio(list(theirs.values()), list(ours.values()), seed)
                if ratio is not None and ratio.few:
                    few.setdefault(ratio.n, []).append(name)
            else:
                unlike.setdefault(other.counters["triangles"], []).append(name)
        row |= interval(f"ratio_to_{name}", ratio)
    if unlike or few:
        left = subject.counters.get("triangles")
        words = [
            f"no ratio to {', '.join(names)}: {left:,} triangles against {count:,}"
            for count, names in unlike.items()
        ]
        words += [
            f"too few samples for an interval of the ratio to {', '.join(names)}: {n} of {ENOUGH}"
            for n, names in few.items()
        ]
        row["reason"] = "; ".join(filter(None, (verdict(group, subject)[1], *words)))
    return row


def frame_ratios(
    group: GroupRecord, subject: SubjectRecord, baselines: Iterable[str], seed: int = 0
) -> dict[str, Any]:
    """How many times as many whole frames per second `subject` draws as each baseline of its group."""
    row: dict[str, Any] = {}
    for name in baselines:
        other = group.subjects.get(name)
        if other is None or name == subject.label or not (counts(subject) and counts(other)):
            continue
        ratio = paired_ratio(other.frame_s, subject.frame_s, seed)
        row |= interval(f"frame_ratio_to_{name}", ratio)
    return row
