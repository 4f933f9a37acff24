import pytest

from lodbench.harness.plan.table import Column, Table, frame_ratio_columns, ratio_columns
from lodbench.harness.report.rows import limit_share, measured, memory_bytes, table_rows
from tests.harness.records import group, run, subject


def rate(best, median):
    return {"subject": "k", "unit": "B/s", "best": best, "median": median, "samples": [best]}


LIMITS = {"device": "d", "size_bytes": 1, "fill": rate(1000.0, 40.0)} | {
    name: rate(9.0, 9.0) for name in ("copy", "multiply_add", "launch_wall", "launch_event")
}


def table(*columns, **options):
    return Table("t", "", "", lambda quick: (), columns, **options)


def test_share_of_the_limit_is_taken_against_medians_not_against_one_best_sample():
    one = subject("a", [{"vertex": 0.5}] * 10, traffic={"vertex": {"bytes": 10, "flops": 0}})

    found = run(group(one))
    found.limits = LIMITS
    assert limit_share(found, one) == pytest.approx(10 / 40 / 0.5)
    one.traffic["raster"] = {"bytes": 10, "flops": 0}  # of a stage that never ran
    assert limit_share(found, one) is None


def test_noisy_row_says_why():
    row = measured(group(others=0.5), subject("ours", [1.0] * 10))
    quiet = measured(group(others=0.5), subject("ours", [1.0] * 10))
    assert row == quiet
    found = group(subject("ours", [1.0] * 10), others=0.5)
    row = measured(found, found.subjects["ours"])
    assert (row["status"], row["samples"]) == ("noisy", 10)
    assert "50%" in row["reason"]


def test_times_are_medians_and_quartiles_of_samples_and_stages():
    one = subject("a", [{"vertex": 0.1 * k, "solve": 1.0} for k in (1, 2, 3, 4, 9)])
    row = measured(group(), one)
    assert row["vertex_s"] == pytest.approx(0.3) and row["solve_s"] == 1.0
    assert row["stage_s"] == row["wall_s"] == pytest.approx(1.3)
    assert (row["wall_s_min"], row["samples"]) == (pytest.approx(1.1), 5)
    assert row["wall_s_min"] < row["wall_s_lower"] < row["wall_s"] < row["wall_s_upper"] < 1.9
    assert row["stage_fps"] == pytest.approx(1 / 1.3)
    assert row["frames"] is row["frame_s"] is row["frame_fps"] is None


def test_row_of_nothing_measured_has_no_times():
    row = measured(group(), subject("a", [], status="skipped"))
    assert (row["status"], row["samples"]) == ("skipped", 0)
    for key in ("wall_s", "stage_s", "stage_fps", "rms_error", "triangles_out", "memory_bytes"):
        assert row[key] is None


def test_facts_stand_over_params_and_these_over_counters():
    one = subject(
        "a", [1.0] * 3, counters={"triangles": 7, "depth": 1, "n": 1, "only": 5, "system": "x"},
        params={"depth": 2, "n": 2, "none": None, "cells": 9},
    )  # fmt: skip
    row = measured(group(dataset="d", n=3), one)
    assert (row["only"], row["depth"], row["n"], row["dataset"]) == (5, 2, 3, "d")
    assert row["system"] == "a", "a row's own keys stand over all"
    assert "none" not in row
    assert row["triangles_out"] == 7


@pytest.mark.parametrize(
    ("facts", "params", "counters", "cells"),
    [
        ({"cells": 1}, {"cells": 2}, {"cells_along_longest": 3}, 1),
        ({}, {"cells": 2}, {"cells_along_longest": 3}, 2),
        ({}, {"cells": None}, {"cells_along_longest": 3}, 3),
        ({}, {}, {}, None),
    ],
)
def test_cells_are_those_asked_for_or_else_those_found(facts, params, counters, cells):
    one = subject("a", [1.0] * 3, params=params, counters=counters)
    assert measured(group(**facts), one)["cells"] == cells


def test_path_has_its_slowest_and_fastest_view_and_what_was_drawn():
    one = subject("a", [1.0] * 3)
    seconds = {0: [0.1, 0.1, 0.9], 1: [0.5, 0.5, 0.5], 2: [0.2, 0.01, 0.2]}
    one.frames = [
        {"turn": turn, "step": step, "wall_s": found[turn], "triangles": 10 * (step + 1)}
        for step, found in seconds.items()
        for turn in range(3)
    ]
    row = measured(group(), one)
    assert row["steps"] == 3
    assert (row["least_fps"], row["most_fps"]) == (pytest.approx(2), pytest.approx(10))
    assert (row["least_triangles"], row["most_triangles"]) == (10, 30)
    for frame in one.frames:
        del frame["triangles"]
    assert "most_triangles" not in measured(group(), one)
    one.frames = []
    assert "steps" not in measured(group(), one)


def test_share_of_the_limit_is_left_out_where_it_is_not_asked_for_or_one_core_ran():
    traffic = {"vertex": {"bytes": 10, "flops": 0}}
    subjects = [subject(label, [{"vertex": 0.5}] * 5, traffic=traffic) for label in ("a", "b")]
    config = {"subjects": [{"label": "a"}, {"label": "b", "one_core": True}]}
    found = run(group(*subjects, config=config))
    asking = table(Column("limit_share", "share"))
    assert [row.get("limit_share") for row in table_rows(asking, found)] == [None, None]
    found.limits = LIMITS
    all_cores, one_core = table_rows(asking, found)
    assert all_cores["limit_share"] == pytest.approx(10 / 40 / 0.5)
    assert "limit_share" not in one_core
    assert all("limit_share" not in row for row in table_rows(table(), found))


def test_ratios_are_taken_to_the_subjects_that_columns_name():
    slow, fast = subject("slow", [2.0] * 10), subject("fast", [0.5] * 10)
    for one, seconds in ((slow, 3.0), (fast, 1.0)):
        one.frames = [{"turn": turn, "wall_s": seconds} for turn in range(3, 13)]
    asking = table(*ratio_columns(["slow"]), *frame_ratio_columns(["slow"]))
    own, other = table_rows(asking, run(group(slow, fast)))
    assert other["ratio_to_slow"] == pytest.approx(4) and own["ratio_to_slow"] is None
    assert other["frame_ratio_to_slow"] == pytest.approx(3)
    assert other["frame_ratio_to_slow_low"] <= 3 <= other["frame_ratio_to_slow_high"]
    assert "frame_ratio_to_slow" not in own
    assert not [
        key for row in table_rows(table(), run(group(slow, fast))) for key in row if "ratio" in key
    ]


def test_rows_of_a_line_share_the_slope_of_time_over_size():
    groups = []
    for size in (100, 1000, 10000):
        linear = subject("linear", [1e-3 * size] * 5, counters={"triangles": 1})
        square = subject("square", [1e-6 * size**2] * 5)
        failed = subject("linear, failed", [5.0] * 5, status="failed")
        groups.append(group(linear, square, failed, triangles_in=size))
    lines = table(line=lambda row: row["system"].split(",")[0] if row["system"] != "none" else None)
    rows = table_rows(lines, run(*groups))
    slopes = {row["system"]: row.get("slope") for row in rows}
    assert slopes == {
        "linear": pytest.approx(1),
        "square": pytest.approx(2),
        "linear, failed": None,
    }
    for row in rows:
        if "slope" in row:
            assert (
                row["slope_low"] <= row["slope"] + 1e-9 and row["slope"] <= row["slope_high"] + 1e-9
            )
    assert not any("slope" in row for row in table_rows(table(), run(*groups)))


def test_rows_stand_in_the_order_of_the_groups_with_the_tables_own_words():
    groups = [group(subject("a", [1.0] * 5), subject("b", [1.0] * 5), n=n) for n in (1, 2)]
    other = group(subject("c", [1.0] * 5), table="another")
    made = table(
        own=lambda entry: {"own": (entry.subject.label, entry.row["n"]), "samples": -1},
        also=lambda found: [{"system": "paper", "status": "published", "n": found.facts["n"]}],
    )
    rows = table_rows(made, run(groups[0], other, groups[1]))
    assert [(row["system"], row["n"]) for row in rows] == [
        ("a", 1), ("b", 1), ("paper", 1), ("a", 2), ("b", 2), ("paper", 2),
    ]  # fmt: skip
    assert [row.get("own") for row in rows[:3]] == [("a", 1), ("b", 1), None]
    assert rows[0]["samples"] == -1, "a table may overwrite"


def test_memory_is_that_of_buffers_or_of_the_input_and_the_rise():
    device = subject(
        "a",
        [{"vertex": 1.0}] * 3,
        footprint={"input_bytes": 5, "scratch_bytes": 7, "stored_bytes": 90},
    )
    host = [subject(label, [1.0] * 3, footprint={"input_bytes": 5}) for label in ("b", "c")]
    for one, rise in zip(host, (100, 40), strict=True):
        one.system, one.peak_growth_bytes = "host", rise
    found = group(device, *host)
    assert memory_bytes(found, device) == 12
    assert [memory_bytes(found, one) for one in host] == [105, 105], "the highest of one system"
    assert memory_bytes(found, subject("d", [1.0] * 3)) is None


def test_memory_is_what_the_device_holds_or_the_highest_rise_of_a_system_on_the_host():
    held = {"input_bytes": 5, "output_bytes": 7, "scratch_bytes": 11, "stored_bytes": 1000}
    first = subject("first", [1.0], footprint={"input_bytes": 10}, peak_growth_bytes=300)
    again = subject("again", [1.0], footprint={"input_bytes": 20}, peak_growth_bytes=0)
    first.system = again.system = "package"
    other = subject("other", [1.0], footprint={"input_bytes": 10}, peak_growth_bytes=9000)
    kernels = subject("kernels", [{"vertex": 1.0}], footprint=held, peak_growth_bytes=9000)
    both = group(first, again, other, kernels)
    found = {name: memory_bytes(both, one) for name, one in both.subjects.items()}
    assert found == {"first": 310, "again": 320, "other": 9010, "kernels": 23}
    assert memory_bytes(group(one := subject("one", [1.0])), one) is None
