"""Records of made-up subjects, and the rows that a table has of them."""

from pathlib import Path

from lodbench.harness.plan import table
from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.report import document


def subject(label, seconds, *, status="ok", system=None, **facts):
    """Samples in turns 3, 4 ...; `seconds` is a list of wall times, or of {stage: seconds}."""
    found = SubjectRecord(label, system=system or label, status=status, reason="", **facts)
    for turn, value in enumerate(seconds, 3):
        stages = value if isinstance(value, dict) else {"call": value}
        wall = sum(stages.values())
        found.samples.append({"turn": turn, "wall_s": wall, "cpu_s": wall, "stage_s": stages})
    return found


def group(*subjects, table="t", config=None, others=0.0, **facts):
    found = GroupRecord(
        "g", table, "n", str(facts.get("dataset")), "d", facts, config or {}, others
    )
    found.subjects = {subject.label: subject for subject in subjects}
    return found


def run(*groups):
    return RunRecord(Path(), {"seed": 0, "device": {"name": "a device"}}, list(groups))


def rows_of(name, *groups):
    made = document.document(table.table(name), run(*groups))
    return {row["system"]: row for row in made["rows"]}, made
