import json

import numpy as np
import pytest
from matplotlib import rcParams
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from lodbench.harness.measure.limits import Limits
from lodbench.harness.record.record import read_run
from lodbench.harness.report.charts import (
    CHARTS,
    ChartData,
    bars,
    curves,
    front,
    scales,
    stages,
    styles,
)
from lodbench.harness.report.charts.chart_data import (
    MARKERS,
    PALETTE,
    STAGES,
    case,
    subjects,
    varying,
)
from lodbench.harness.report.plots import documents, write_figures
from tests.harness.made_run import edit_table, make_run
from tests.harness.records import group, rows_of, subject


@pytest.fixture(scope="module")
def run_folder(tmp_path_factory):
    return make_run(tmp_path_factory.mktemp("run"))


@pytest.fixture(scope="module")
def figures(run_folder):
    return write_figures(run_folder)


def chart_data(folder, name):
    run = read_run(folder)
    made = next(made for made in documents(folder) if made["id"] == name)
    return ChartData(made, run.of_table(name), styles(subjects(run))[name])


def texts(canvas):
    return [text.get_text() for axes in canvas.axes for text in axes.texts]


def test_figures_are_drawn_where_the_table_has_the_data(figures):
    drawn = {(figure.table, figure.kind) for figure in figures}
    assert drawn == {
        ("clustering", "front"), ("clustering", "time"), ("clustering", "error-time"), ("clustering", "stages"),
        ("clustering", "samples"), ("patterns", "time"), ("patterns", "fps"),
        ("patterns", "footprint"), ("patterns", "stages"), ("patterns", "samples"),
    }  # fmt: skip


def test_figures_are_readable_files(figures):
    for figure in figures:
        assert figure.svg.read_text().startswith("<?xml")
        pixels = np.asarray(Image.open(figure.png).convert("L"))
        assert pixels.shape[1] >= 800
        assert (pixels < 128).any()  # something is drawn
        assert figure.caption.endswith(".")


def test_figures_have_the_same_bytes_each_time_and_leave_the_users_style_alone(run_folder, figures):
    before = {path.name: path.read_bytes() for path in (run_folder / "figures").iterdir()}
    style = dict(rcParams)
    write_figures(run_folder)
    after = {path.name: path.read_bytes() for path in (run_folder / "figures").iterdir()}
    assert after == before
    assert not any(b"dc:date" in content for content in after.values())
    assert dict(rcParams) == style


def test_time_curves_carry_the_fitted_power(run_folder):
    chart = curves.time_against_triangles(chart_data(run_folder, "clustering"))
    assert chart is not None
    # the made-up time is 0.9 us per triangle and 0.2 ms: all but linear
    assert "fast_simplification  n^1.00" in texts(chart.canvas)
    assert "manifold3d" not in " ".join(texts(chart.canvas))  # skipped everywhere


def test_datasets_of_several_sizes_each_are_panels_of_the_time_chart(run_folder):
    m = chart_data(run_folder, "clustering")
    assert len(curves.time_against_triangles(m).canvas.axes) == 1  # each dataset is one size
    sizes = sorted({row["triangles_in"] for row in m.document["rows"]})
    for row in m.document["rows"]:
        row["dataset"] = "torus" if sizes.index(row.pop("triangles_in")) % 2 else "sphere"
    assert len(curves.time_against_triangles(m).canvas.axes) == 2


def test_labels_of_curves_that_end_together_do_not_overlap(run_folder):
    m = chart_data(run_folder, "clustering")
    for row in m.document["rows"]:
        if row["wall_s"]:
            row["wall_s"] = 1e-8 * row["triangles_in"]
    chart = curves.time_against_triangles(m)
    assert chart is not None
    heights = sorted(text.xyann[1] for text in chart.canvas.axes[0].texts)
    assert len(heights) == 5
    assert np.diff(heights).min() > 0.06


def test_failed_rows_are_not_drawn(run_folder):
    chart = bars.frames_per_second(chart_data(run_folder, "patterns"))
    assert chart is not None
    assert len(chart.canvas.axes[0].patches) == 11  # 12 rows, one of them failed


def test_published_values_are_marked_and_their_hardware_named(run_folder):
    chart = bars.frames_per_second(chart_data(run_folder, "patterns"))
    assert chart is not None
    diamonds = [line for line in chart.canvas.axes[0].lines if line.get_marker() == "D"]
    assert sorted(diamonds[0].get_xdata()) == [105.0, 411.0, 912.0]
    assert "GeForce 1" in chart.caption


def test_footprint_is_left_out_where_all_store_alike(run_folder):
    assert bars.footprint(chart_data(run_folder, "clustering")) is None


def test_stage_shares_add_up_to_the_whole(run_folder):
    chart = stages.stages(chart_data(run_folder, "clustering"))
    assert chart is not None
    widths = [patch.get_width() for patch in chart.canvas.axes[0].patches]
    assert sum(widths) == pytest.approx(100 * 4)  # four bars


def test_stages_have_the_least_that_they_could_take(run_folder):
    run = read_run(run_folder)
    group = next(group for group in run.groups if group.table == "clustering")
    subject = next(iter(group.subjects.values()))
    stage = subject.stages[0]
    seconds = float(np.median(subject.stage_s(stage)))
    subject.traffic = {stage: {"bytes": round(0.25 * seconds * 2.6e10), "flops": 0}}
    made = next(made for made in documents(run_folder) if made["id"] == "clustering")
    chart = stages.stages(ChartData(made, [group], {}, Limits.of_record(run.limits)))
    assert chart is not None
    (lines,) = chart.canvas.axes[0].collections[:1]
    ((begin, _), (end, _)), *_ = lines.get_segments()
    patch = chart.canvas.axes[0].patches[0]
    assert (end - begin) / patch.get_width() == pytest.approx(0.25, rel=1e-3)
    assert "the least that the bytes" in chart.caption


def test_noisy_subjects_are_marked_in_the_sample_strip(run_folder):
    chart = bars.samples(chart_data(run_folder, "clustering"))
    assert chart is not None
    names = [label.get_text() for label in chart.canvas.axes[0].get_yticklabels()]
    assert names.count("numpy_quadric_clustering (noisy)") == 1


def test_too_many_cases_are_counted_in_the_caption(run_folder):
    m = chart_data(run_folder, "clustering")
    lines = bars.lines_of({str(i): list(range(30)) for i in range(4)})
    assert list(lines.cases) == ["3"]
    assert lines.more == " 1 of 4 cases are drawn; all are in the table."
    assert bars.lines_of(bars.subjects_of(m)).more == ""


def test_error_curves_need_several_counts_of_one_dataset(run_folder):
    m = chart_data(run_folder, "clustering")
    assert curves.error_against_triangles(m) is None
    for row in m.document["rows"]:
        row["dataset"] = "one"
    assert curves.error_against_triangles(m) is not None


def test_difference_curves_need_several_patterns(run_folder):
    m = chart_data(run_folder, "clustering")
    assert curves.difference_against_segments(m) is None
    for number, row in enumerate(m.document["rows"]):
        row |= {"segments": 8, "rms_difference": 0.1 / (1 + number)}
    assert curves.difference_against_segments(m) is None
    for number, row in enumerate(m.document["rows"]):
        row["segments"] = 1 << number
    assert "segments" in curves.difference_against_segments(m).caption


@pytest.mark.parametrize("kind", CHARTS)
def test_chart_of_an_empty_table_is_left_out(kind):
    empty = {"id": "e", "title": "", "source": "", "device": "", "columns": [], "rows": []}
    assert CHARTS[kind][1](ChartData(empty, [], {})) is None


def test_a_colour_means_one_system_in_all_tables():
    first = {"a": "a", "a_one_core": "a", "b": "b"}
    second = {f"s{i}": f"s{i}" for i in range(len(PALETTE) - 4)} | {"b": "b", "again": "a"}
    found = styles({"first": first, "second": second})
    assert found["first"]["b"] == found["second"]["b"]
    colours = [style.colour for name, style in found["second"].items() if name != "again"]
    assert len(set(colours)) == len(colours)
    assert found["first"]["a"].colour not in colours
    assert not {style.colour for own in found.values() for style in own.values()} & set(STAGES)


def test_subjects_of_one_system_differ_in_shade_mark_and_dash():
    own = {"a": "a", **{f"a_{i}": "a" for i in range(7)}}
    found = styles({"t": own})["t"]
    assert found["a"].colour == PALETTE[0]
    assert len({style.colour for style in found.values()}) == 3
    assert len({style.marker for style in found.values()}) == len(MARKERS)
    assert len({(style.colour, style.dash) for style in found.values()}) == len(found)


def test_systems_past_the_colours_share_one_with_those_of_other_tables():
    tables = {f"t{i}": {f"s{i}_{k}": f"s{i}_{k}" for k in range(len(PALETTE))} for i in range(2)}
    for own in styles(tables).values():
        assert len({style.colour for style in own.values()}) == len(PALETTE)


def test_front_has_the_case_with_the_fewest_triangles_and_whom_nobody_beats(run_folder):
    data = chart_data(run_folder, "clustering")
    rows = front.front_rows(data.document, data.facts)
    assert {row["dataset"] for row in rows} == {"icosphere_5"}
    assert "manifold3d" not in {row["system"] for row in rows}
    best = front.front(rows)
    assert [row["system"] for row in best] == ["quadric_clustering", "fast_simplification"]
    for row in rows:
        beaten = [b["wall_s"] <= row["wall_s"] and b["rms_error"] <= row["rms_error"] for b in best]
        assert any(beaten)
    chart = front.pareto_front(data)
    assert chart is not None and "icosphere_5" in chart.caption
    assert {row["system"] for row in rows} <= set(texts(chart.canvas))


def test_names_in_the_front_lie_beside_each_other(run_folder):
    chart = front.pareto_front(chart_data(run_folder, "clustering"))
    assert chart is not None
    renderer = FigureCanvasAgg(chart.canvas).get_renderer()
    boxes = [text.get_window_extent(renderer) for text in chart.canvas.axes[0].texts]
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])


def test_more_samples_than_dots_are_thinned_by_rank():
    kept = bars._thinned(np.arange(1000.0)[::-1])
    assert len(kept) == bars.DOTS and (kept[0], kept[-1]) == (0, 999)
    assert list(bars._thinned([2.0, 1.0])) == [1, 2]


def test_case_names_what_varies_once():
    rows = [
        {"dataset": "a", "triangles_in": 10, "coarse": 10, "cells": 4, "fixed": 1},
        {"dataset": "b", "triangles_in": 20, "coarse": 20, "cells": 4, "fixed": 1},
        {"dataset": "a", "triangles_in": 10, "coarse": 10, "cells": 8, "fixed": 1},
    ]
    keys = varying(rows, ["triangles_in", "coarse", "cells", "fixed"])
    assert keys == ["triangles_in", "cells"]
    assert case(rows[1], ["dataset", *keys]) == "b, 20 triangles in, 4 cells"


def test_a_broken_table_is_named(run_folder, tmp_path):
    folder = make_run(tmp_path)
    (folder / "tables/clustering.json").write_text(json.dumps([1, 2]))
    with pytest.raises(ValueError, match=r"clustering\.json: expected an object"):
        documents(folder)
    edit_table(folder, "patterns", lambda made: made["rows"].clear())
    (folder / "tables/clustering.json").unlink()
    drawn = {figure.kind for figure in write_figures(folder)}
    assert drawn == {"stages", "samples"}  # what the samples alone tell


def made(name, *groups):
    """A chart's data of a table of made-up records."""
    _, document = rows_of(name, *groups)
    systems = {row["system"]: row["system"].partition("_on")[0] for row in document["rows"]}
    return ChartData(document, [], styles({name: systems})[name])


def test_projections_over_cores_are_dashed_and_named():
    def subjects():
        yield subject("private", [0.006] * 6, system="quadric_clustering")
        yield subject("private_one_core", [0.011] * 6, system="quadric_clustering")
        for cores in (2, 16):
            counters = {
                "chain_s": 0.01 / cores,
                "chain_pass_1_and_3_s": 0.008 / cores,
                "chain_pass_2_s": 0.002 / cores,
            }
            yield subject(f"private_on_{cores}", [0.1] * 4, system="projected_cores", counters=counters,
                          params={"cores": cores})  # fmt: skip

    chart = scales.over_cores(
        made("scaling", group(*subjects(), table="scaling", dataset="bunny_69k"))
    )
    assert chart is not None and "a projection" in chart.caption
    time, shares = chart.canvas.axes
    dashed = [line for line in time.lines if line.get_linestyle() == "--"]
    assert [list(line.get_xdata()) for line in dashed] == [[2, 16]]
    assert sorted(bar.get_height() for bar in shares.patches) == pytest.approx([20, 20, 80, 80])
    assert "a projection" in [text.get_text() for text in chart.canvas.legends[0].texts]


def test_memory_is_drawn_over_sizes_with_what_was_allowed():
    groups = [
        group(
            subject("out_of_core", [0.2] * 5, system="simplify_file", counters={
                "triangles": 9, "triangles_read": size, "peak_bytes": 70 * size, "memory_limit_bytes": 90 * size}),
            table="out_of_core", dataset="dragon_100k", copies=size,
        )
        for size in (10**6, 10**7)
    ]  # fmt: skip
    chart = scales.memory_and_rate(made("out_of_core", *groups))
    assert chart is not None
    allowed = [line for line in chart.canvas.axes[0].lines if line.get_marker() == "_"]
    assert list(allowed[0].get_ydata()) == [90 * 10**6, 90 * 10**7]
    assert scales.memory_and_rate(made("out_of_core", groups[0])) is None
