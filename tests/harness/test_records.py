"""Rows for data frames of one's own."""

import re

import numpy as np
import pytest

from lodbench.harness import records
from lodbench.harness.plan import table as tables
from lodbench.harness.record.samples import pack
from tests.harness.made_run import TABLES, make_run


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_run(tmp_path_factory.mktemp("run"))


@pytest.fixture(autouse=True)
def made_tables(monkeypatch):
    monkeypatch.setattr(tables, "tables", lambda: {table.id: table for table in TABLES})


def test_rows_are_flat_and_have_the_same_keys_in_the_same_order(folder):
    rows = records.load(folder)
    assert {tuple(row) for row in rows} == {tuple(rows[0])}
    assert list(rows[0])[:5] == ["table", "dataset", "system", "status", "reason"]
    kinds = {type(value) for row in rows for value in row.values()}
    assert kinds <= {str, int, float, bool, tuple, type(None)}


def test_row_has_what_its_table_says_and_the_interval_of_its_median(folder):
    rows = records.load(str(folder), "clustering")
    assert {row["table"] for row in rows} == {"clustering"}
    mine = [row for row in rows if row["system"] == "quadric_clustering"]
    assert [row["triangles_in"] for row in mine] == [20 * 4**size for size in (5, 6, 7, 8)]
    for row in mine:
        assert row["wall_s_low"] < row["wall_s"] < row["wall_s_high"]
        assert row["ratio_to_fast_simplification"] > 1
    skipped = next(row for row in rows if row["system"] == "manifold3d")
    assert (skipped["status"], skipped["wall_s"], skipped["wall_s_low"]) == ("skipped", None, None)


def test_published_values_of_a_table_come_along(folder):
    rows = records.load(folder, "patterns")
    assert any(row["published_frame_fps"] == 912.0 for row in rows)


def test_samples_are_rows_with_the_facts_of_their_case(folder):
    rows = records.load(folder, "clustering", samples=True)
    mine = [r for r in rows if r["system"] == "quadric_clustering" and r["triangles_in"] == 20480]
    assert [row["turn"] for row in mine] == list(range(15))
    assert [row["warmup"] for row in mine] == [True] * 3 + [False] * 12
    (row,) = (
        r for r in records.load(folder, "clustering")
        if r["system"] == "quadric_clustering" and r["triangles_in"] == 20480
    )  # fmt: skip
    assert np.median([r["wall_s"] for r in mine if not r["warmup"]]) == row["wall_s"]
    assert mine[0]["stage_vertex_s"] > 0


def test_run_of_a_table_that_this_version_does_not_know_has_its_measurements(folder, monkeypatch):
    monkeypatch.setattr(tables, "tables", dict)
    rows = records.load(folder, "clustering")
    assert len(rows) == 4 * 6
    assert rows[0]["wall_s"] and "ratio_to_fast_simplification" not in rows[0]


def test_reading_writes_nothing_and_takes_a_packed_run(tmp_path):
    folder = make_run(tmp_path / "run")
    before = records.load(folder)
    pack(folder)
    files = sorted(path.name for path in folder.rglob("*"))
    assert records.load(folder) == before
    assert sorted(path.name for path in folder.rglob("*")) == files


@pytest.mark.parametrize("name", ["clusters", "nothing"])
def test_unknown_table_is_named(folder, name):
    with pytest.raises(ValueError, match=rf"table: expected .*clustering.*, got '{name}'"):
        records.load(folder, name)


def test_no_run_is_named(tmp_path):
    with pytest.raises(ValueError, match=re.escape("run: expected a folder with run.json")):
        records.load(tmp_path)
