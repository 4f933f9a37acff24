import pytest

from lodbench.harness.plan import table as tables
from lodbench.harness.plan.table import Column, Table
from lodbench.harness.report import derive
from lodbench.harness.report.derive import MOST_NOISE, brief_columns, reasons, statuses
from tests.harness.records import group, run, subject


def row(system, status="ok", reason="", dataset="d"):
    return {"system": system, "dataset": dataset, "status": status, "reason": reason}


def test_statuses_are_counted_over_all_tables():
    documents = [{"rows": [row("a"), row("b", "noisy")]}, {"rows": [row("a"), row("c", "skipped")]}]
    assert statuses(documents) == {"ok": 2, "noisy": 1, "skipped": 1}


def test_rows_that_share_a_reason_share_a_line():
    made = {
        "id": "t",
        "rows": [
            row("a"),
            row("b", "skipped", "needs wings"),
            row("c", "skipped", "needs wings", dataset=None),
            row("d", "failed", "needs wings"),
            *(row(f"e{k}", "skipped", "needs air") for k in range(4)),
        ],
    }
    assert reasons(made) == [
        "skipped: needs wings (d b, c)",
        "failed: needs wings (d d)",
        "skipped: needs air (4 rows)",
    ]


def test_ratio_that_is_lacking_is_a_reason_of_its_own_beside_noise():
    reason = "samples vary; with others; no ratio to x: 3 triangles against 9; no ratio to y: 3"
    assert reasons({"id": "t", "rows": [row("a", "noisy", reason)]}) == [
        "noisy: samples vary; with others (d a)",
        "no ratio: to x: 3 triangles against 9 (d a)",
        "no ratio: to y: 3 (d a)",
    ]


@pytest.mark.parametrize("count", [MOST_NOISE, MOST_NOISE + 1])
def test_much_noise_is_one_line(count):
    rows = [row("a", "noisy", f"reason {k}") for k in range(count)] + [row("b", "failed", "check")]
    found = reasons({"id": "t", "rows": rows})
    if count == MOST_NOISE:
        assert len(found) == count + 1
    else:
        assert found == [
            "failed: check (d b)",
            f"noisy: {count} rows, the reason of each stands in tables/t.csv",
        ]


@pytest.mark.parametrize("brief", [False, True])
def test_terminal_shows_brief_columns_or_all_but_quartiles_and_intervals(monkeypatch, brief):
    keys = ("system", "wall_s", "wall_s_min", "wall_s_lower", "ratio_to_a_high", "status", "reason")
    columns = [Column(key, key, brief=brief and key in ("wall_s_min", "system")) for key in keys]
    made = Table("t", "", "", lambda quick: (), columns)
    monkeypatch.setattr(tables, "tables", lambda: {"t": made})
    found = run(group(subject("a", [1.0] * 3)))
    found.environment["options"] = {}
    monkeypatch.setattr(derive, "read_run", lambda folder: found)
    shown = brief_columns(found.folder, {"id": "t", "columns": [{"key": key} for key in keys]})
    expected = ["system", "wall_s_min"] if brief else ["system", "wall_s", "status"]
    assert [column["key"] for column in shown] == expected


def test_tables_of_a_run_are_those_known_and_its_own_sweep(monkeypatch):
    known = Table("t", "", "", lambda quick: (), ())
    monkeypatch.setattr(tables, "tables", lambda: {"t": known})
    found = run(*(group(subject("a", [1.0]), table=name) for name in ("t", "mine", "unknown")))
    spec = {"name": "mine", "systems": ["quadric_clustering"], "datasets": ["icosphere_1"]}
    found.environment["options"] = {"sweep": spec}
    assert [one.id for one in derive.tables_of(found)] == ["t", "mine"]
    found.environment["options"] = {}
    assert derive.tables_of(found) == [known]
