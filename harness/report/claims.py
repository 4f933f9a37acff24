"""Verdicts on what the papers claim, from a run's records alone."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from lodbench.harness.claims import CLAIMS, Claim, Comparison, Pick
from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.report.ratios import counts
from lodbench.harness.report.statistics import paired_ratio

CONFIRMED, REFUTED, PARTLY = "confirmed", "refuted", "partly confirmed"
UNDECIDED, NOT_HERE = "undecided", "not measurable here"


@dataclass(frozen=True)
class Measured:
    """One ratio: `group` is its name, the interval equal to the ratio where counts leave no doubt.

    `holds` is None where the interval has both outcomes, or where there is none.
    """

    group: str
    ratio: float
    low: float | None
    high: float | None
    holds: bool | None


def _subjects(group: GroupRecord, pick: Pick) -> list[SubjectRecord]:
    return [
        subject
        for subject in group.subjects.values()
        if subject.system == pick.system
        and counts(subject)
        and all((subject.params or {}).get(key) == value for key, value in pick.params.items())
        and not any((subject.params or {}).get(key) == value for key, value in pick.without.items())
        and not _one_core(group, subject.label)
    ]


def _alike(comparison: Comparison, one: SubjectRecord, other: SubjectRecord) -> bool:
    """Two subjects whose parameters of the same name are the same, but for those that the comparison is of."""
    picked = {*comparison.subject.params, *comparison.other.params}
    ours, theirs = (subject.params or {} for subject in (one, other))
    shared = ours.keys() & theirs.keys() - picked
    return one is not other and all(ours[key] == theirs[key] for key in shared)


def _one_core(group: GroupRecord, label: str) -> bool:
    subjects = group.config.get("subjects", ())
    return any(one["label"] == label and one.get("one_core") for one in subjects)


def _drawn(group: GroupRecord, label: str) -> bool:
    """Is a sample of this subject a whole frame?"""
    subjects = group.config.get("subjects", ())
    draws = [one.get("draw") for one in subjects if one["label"] == label]
    return any(draw and not draw.get("apart") for draw in draws)


def _ratio(
    group: GroupRecord, one: SubjectRecord, other: SubjectRecord, comparison: Comparison, seed: int
) -> tuple[float, float | None, float | None] | None:
    what, stage = comparison.what, comparison.stage
    if what == "fewer triangles":
        ours, theirs = (subject.counters.get("triangles") for subject in (one, other))
        return (theirs / ours,) * 3 if ours and theirs else None
    whole = all(_drawn(group, subject.label) for subject in (one, other))
    if stage:
        times = other.stage_by_turn(stage), one.stage_by_turn(stage)
    elif what == "frames faster":
        times = (other.wall_s, one.wall_s) if whole else (other.frame_s, one.frame_s)
    elif whole:
        return None  # samples with drawing say little of the stages before it
    else:
        times = other.wall_s, one.wall_s
    found = paired_ratio(*times, seed)
    return (found.median, found.low, found.high) if found else None


def _holds(
    comparison: Comparison, ratio: float, low: float | None, high: float | None
) -> bool | None:
    if low is None or high is None:
        return None
    sure = [low, high]
    if comparison.least is not None:
        outcomes = {value >= comparison.least for value in sure}
    else:
        outcomes = {value <= (comparison.most or 0.0) for value in sure}
    return outcomes.pop() if len(outcomes) == 1 else None


def measured(comparison: Comparison, run: RunRecord) -> Iterator[Measured]:
    """The comparison in each of the run's groups that has both subjects, for each pair of them."""
    for group in run.groups:
        seed = group.config.get("seed", run.environment["seed"])
        for one in _subjects(group, comparison.subject):
            for other in _subjects(group, comparison.other):
                found = _ratio(group, one, other, comparison, seed)
                if found is not None and _alike(comparison, one, other):
                    yield Measured(
                        f"{group.table}: {group.name}", *found, _holds(comparison, *found)
                    )


def _said(comparison: Comparison, found: Sequence[Measured]) -> str:
    """Such as "1.5 to 1.7 times faster (1.4 to 1.9)"."""
    ratios = [one.ratio for one in found]
    ends = [end for one in found for end in (one.low, one.high) if end is not None]
    text = _span(min(ratios), max(ratios))
    sure = comparison.what == "fewer triangles" or not ends
    return f"{text} times {comparison.what}" + ("" if sure else f" ({_span(min(ends), max(ends))})")


def _span(low: float, high: float) -> str:
    one, other = f"{low:.3g}", f"{high:.3g}"
    return one if one == other else f"{one} to {other}"


def _outcome(comparison: Comparison, found: Sequence[Measured]) -> tuple[str, str]:
    """Verdict and reason of one comparison."""
    if not found:
        both = f"{comparison.subject} and {comparison.other}"
        return NOT_HERE, f"no group of the run has measured both {both}"
    held, failed = (sum(one.holds is value for one in found) for value in (True, False))
    where = f"in {held} of {len(found)} cases"
    if held and not failed:
        return CONFIRMED, where if held < len(found) else ""
    if failed and not held:
        return REFUTED, where
    if held:
        return PARTLY, where
    return UNDECIDED, "every interval has both outcomes"


def judged(claim: Claim, run: RunRecord) -> dict[str, Any]:
    """One claim: `claim`, `source`, `published`, `measured`, `verdict`, `reason`, and `cases`, each ratio by itself."""
    outcomes, said, cases = [], [], []
    for comparison in claim.comparisons:
        found = list(measured(comparison, run))
        outcomes.append(_outcome(comparison, found))
        if found:
            said.append(_said(comparison, found))
        cases += [{"what": comparison.what, **vars(one)} for one in found]
    verdicts = [verdict for verdict, _ in outcomes]
    order = (REFUTED, NOT_HERE, UNDECIDED, PARTLY, CONFIRMED)  # the first of these that there is
    verdict = next(one for one in order if one in verdicts)
    reasons = [reason for own, reason in outcomes if reason and own == verdict]
    return {
        "name": claim.name,
        "claim": claim.text,
        "source": claim.source,
        "published": claim.published,
        "measured": "; ".join(said) or None,
        "verdict": verdict,
        "reason": "; ".join([*reasons, *([claim.note] if said and claim.note else [])]),
        "cases": cases,
    }


def verdicts(run: RunRecord, claims: Iterable[Claim] = CLAIMS) -> list[dict[str, Any]]:
    """Every claim, in their order."""
    return [judged(claim, run) for claim in claims]
