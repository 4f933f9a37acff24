"""Verdicts on what the papers claim, from the records of runs alone."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from lodbench.harness.claims import CLAIMS, Claim, Comparison, Evidence
from lodbench.harness.record.record import RunRecord
from lodbench.harness.report.evidence import Measured, Tables, measured

CONFIRMED, REFUTED, PARTLY = "confirmed", "refuted", "partly confirmed"
UNDECIDED, NOT_HERE = "undecided", "not measurable here"
NOT_IN_RUN = "not measured in this run"
UNJUDGED = (NOT_HERE, NOT_IN_RUN)

_ORDER = (REFUTED, NOT_IN_RUN, UNDECIDED, PARTLY, CONFIRMED)  # the first of a claim's is its own
_WORDS = {
    "faster": "times as fast",
    "frames faster": "times the frame rate",
    "closer": "times as close",
    "fewer triangles": "times fewer triangles",
    "fewer KSQuads": "times fewer KSQuads",
    "fewer stored vertices": "times fewer stored vertices",
}


def _said(evidence: Evidence, found: Sequence[Measured]) -> str:
    """Such as "1.5 to 1.7 times as fast (1.4 to 1.9)"."""
    if isinstance(evidence, Comparison):
        stage = f"stage {evidence.stage} alone" if evidence.stage else ""
        facts = (f"{key.replace('_', ' ')} {value}" for key, value in evidence.facts.items())
        words = ", ".join(filter(None, (_WORDS[evidence.what], stage, *facts)))
    else:
        words = evidence.says
    values = [one.ratio for one in found]
    text = f"{_span(min(values), max(values))} {words}"
    sampled = [one for one in found if (one.low, one.high) != (one.ratio, one.ratio)]
    ends = [end for one in sampled for end in (one.low, one.high) if end is not None]
    return f"{text} ({_span(min(ends), max(ends))})" if ends else text


def _span(low: float, high: float) -> str:
    one, other = (
        f"{value:,.3g}" if abs(value) < 1000 else f"{value:,.0f}" for value in (low, high)
    )
    return one if one == other else f"{one} to {other}"


def _rule(evidence: Evidence) -> str:
    """Such as "at least 0.9 in every case"."""
    least, most = evidence.least, evidence.most
    ends = (("at least", least), ("at most", most)) if least != most else (("exactly", least),)
    parts = [f"{word} {_span(value, value)}" for word, value in ends if value is not None]
    return f"{' and '.join(parts)} in {evidence.reach} case"


def _outcome(evidence: Evidence, found: Sequence[Measured]) -> tuple[str, str]:
    """Verdict and reason of one piece of evidence."""
    if not found:
        return NOT_IN_RUN, f"no group of the run has measured {evidence}"
    held, failed = (sum(one.holds is value for one in found) for value in (True, False))
    left = len(found) - held - failed
    where = f"in {held} of {len(found)} cases" + (f", {left} undecided" if left and held else "")
    if evidence.reach == "one":
        if held:
            return CONFIRMED, where
        return (REFUTED, where) if failed == len(found) else (UNDECIDED, where)
    if held and not failed:
        return CONFIRMED, where if held < len(found) else ""
    if failed and not held:
        return REFUTED, where
    if held:
        return PARTLY, where
    return UNDECIDED, "every interval has both outcomes"


def _on_cpu(run: RunRecord) -> bool:
    return (run.environment.get("device") or {}).get("kind") != "gpu"


def judged(
    claim: Claim, runs: RunRecord | Sequence[RunRecord], known: Tables | None = None
) -> dict[str, Any]:
    """One claim, of one run or of several together.

    Returns:
        `name`, `claim`, `source`, `published`, `measured`, `rule`, `verdict`, `reason`, and `cases`, each value by
        itself (see `evidence.Measured`).
    """
    runs = [runs] if isinstance(runs, RunRecord) else runs
    able = [run for run in runs if not (claim.not_on_cpu and _on_cpu(run))]
    outcomes, said, cases = [], [], []
    for evidence in claim.evidence:
        found = measured(evidence, able or runs, known)
        outcomes.append(_outcome(evidence, found))
        if found:
            said.append(_said(evidence, found))
        what = evidence.what if isinstance(evidence, Comparison) else evidence.says
        cases += [{"what": what, **vars(one)} for one in found]
    if not able:
        verdict, reasons = NOT_HERE, [claim.not_on_cpu or "no run was given"]
    elif not outcomes:
        verdict, reasons = NOT_IN_RUN, ["no table tests it"]
    else:
        verdict = next(one for one in _ORDER if one in [outcome for outcome, _ in outcomes])
        reasons = [reason for own, reason in outcomes if reason and own == verdict]
    return {
        "name": claim.name,
        "claim": claim.text,
        "source": claim.source,
        "published": claim.published,
        "measured": "; ".join(said) or None,
        "rule": "; ".join(dict.fromkeys(_rule(one) for one in claim.evidence)) or None,
        "verdict": verdict,
        "reason": "; ".join(
            dict.fromkeys([*reasons, *([claim.note] if said and claim.note else [])])
        ),
        "cases": cases,
    }


def verdicts(
    runs: RunRecord | Sequence[RunRecord], claims: Iterable[Claim] = CLAIMS
) -> list[dict[str, Any]]:
    """Every claim, in their order, of one run or of several together."""
    known = Tables()
    return [judged(claim, runs, known) for claim in claims]
