from dataclasses import replace

import pytest

from lodbench.harness.plan import table as plan_table
from lodbench.harness.plan.table import (
    Column,
    Table,
    brief,
    frame_ratio_columns,
    ratio_columns,
    stage_columns,
    tables,
)
from lodbench.harness.report.document import document
from tests.harness.records import run


def test_every_table_names_its_module_and_has_status_columns_and_unique_keys():
    for name, table in tables().items():
        assert __import__(f"lodbench.harness.tables.{name}", fromlist=["x"]).TABLE is table
        keys = [column["key"] for column in document(table, run())["columns"]]
        assert len(keys) == len(set(keys))
        assert {"system", "wall_s", "status", "reason"} <= set(keys)


def test_every_table_has_different_groups_with_different_labels():
    for table in tables().values():
        for quick in (False, True):
            names = [made.name for made in table.groups(quick)]
            assert len(set(names)) == len(names)
            for made in table.groups(quick):
                labels = [subject.name for subject in made.subjects]
                assert len(set(labels)) == len(labels)


def test_quick_run_measures_every_table_on_smaller_inputs():
    for table in tables().values():
        sizes = []
        for quick in (True, False):
            entries = [group.found().triangles or 0 for group in table.groups(quick)]
            assert entries, table.id
            sizes.append(max(entries))
        assert sizes[0] <= min(sizes[1], 1_100_000), table.id


def of_columns(*columns):
    return Table("t", "", "", lambda quick: (), columns)


def test_columns_name_the_subjects_of_their_ratios_once():
    made = of_columns(
        Column("system", "system"),
        *ratio_columns(["a_b", "c"]),
        *frame_ratio_columns(["d"]),
        Column("wall_s", "wall", "s"),
    )
    assert made.named("ratio_to") == ["a_b", "c"]
    assert made.named("frame_ratio_to") == ["d"]
    assert made.named("published") == []


def test_terminal_shows_the_columns_that_are_brief():
    columns = Column("a", "a"), Column("b", "b", brief=True), Column("c", "c")
    assert of_columns(*columns).brief == ["b"]
    assert of_columns(*brief(columns, "c", "a", "absent")).brief == ["a", "c"]
    assert of_columns(*brief(columns)).brief == []
    assert [replace(column, brief=False) for column in brief(columns, "a")] == [
        replace(column, brief=False) for column in columns
    ]


def test_ratio_has_an_interval_and_is_brief_unless_others_are_shown():
    columns = ratio_columns(["a", "b"])
    assert [column.key for column in columns] == [
        "ratio_to_a", "ratio_to_a_low", "ratio_to_a_high", "ratio_to_b", "ratio_to_b_low", "ratio_to_b_high",
    ]  # fmt: skip
    assert {column.unit for column in columns} == {"1"}
    assert all(name in column.label for name in "ab" for column in ratio_columns([name]))
    for shown, expected in ((None, ["a", "b"]), (["b"], ["b"]), ([], [])):
        made = of_columns(*ratio_columns(["a", "b"], shown))
        assert made.brief == [f"ratio_to_{name}" for name in expected]


def test_frame_ratios_and_stages_have_the_keys_that_rows_have():
    assert [column.key for column in frame_ratio_columns(["a"])] == [
        "frame_ratio_to_a", "frame_ratio_to_a_low", "frame_ratio_to_a_high",
    ]  # fmt: skip
    (column,) = stage_columns(["pass_1_and_3"])
    assert (column.key, column.label, column.unit) == ("pass_1_and_3_s", "pass 1 and 3", "s")


def test_unknown_table_comes_with_close_ones():
    assert plan_table.table("w14_table1").id == "w14_table1"
    with pytest.raises(ValueError, match=r"table: expected one like .*w14_table1.*, got 'w14_tab"):
        plan_table.table("w14_tables")
