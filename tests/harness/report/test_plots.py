import json

import numpy as np
import pytest
from matplotlib import rcParams
from PIL import Image

from lodbench.harness.measure.limits import Limits
from lodbench.harness.record.record import read_run
from lodbench.harness.report.charts import CHARTS, ChartData, bars, curves, styles
from lodbench.harness.report.charts.chart_data import case, varying
from lodbench.harness.report.plots import documents, write_figures
from tests.harness.made_run import edit_table, make_run


@pytest.fixture(scope="module")
def run_folder(tmp_path_factory):
    return make_run(tmp_path_factory.mktemp("run"))


@pytest.fixture(scope="module")
def figures(run_folder):
    return write_figures(run_folder)


def chart_data(folder, name):
    run = read_run(folder)
    made = next(made for made in documents(folder) if made["id"] == name)
    return ChartData(made, run.of_table(name), styles([[row["system"] for row in made["rows"]]]))


def texts(canvas):
    return [text.get_text() for axes in canvas.axes for text in axes.texts]


def test_figures_are_drawn_where_the_table_has_the_data(figures):
    drawn = {(figure.table, figure.kind) for figure in figures}
    assert drawn == {
        ("clustering", "time"), ("clustering", "error-time"), ("clustering", "stages"),
        ("clustering", "samples"), ("patterns", "time"), ("patterns", "fps"),
        ("patterns", "footprint"), ("patterns", "stages"), ("patterns", "samples"),
    }  # fmt: skip


def test_figures_are_readable_files(figures):
    for figure in figures:
        assert figure.svg.read_text().startswith("<?xml")
        pixels = np.asarray(Image.open(figure.png).convert("L"))
        assert pixels.shape[1] >= 1000
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
    chart = bars.stages(chart_data(run_folder, "clustering"))
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
    chart = bars.stages(ChartData(made, [group], {}, Limits.of_record(run.limits)))
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
    lines = bars._lines({str(i): list(range(30)) for i in range(4)})
    assert list(lines.cases) == ["3"]
    assert lines.more == " 1 of 4 cases are drawn; all are in the table."
    assert bars._lines(bars._subjects(m)).more == ""


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


def test_looks_are_shared_between_tables_and_differ_within_one():
    many = [f"s{i}" for i in range(12)]
    found = styles([["a", "b"], ["c", "b"], many])
    assert found["c"] == found["a"]  # never seen together
    assert len({found[name] for name in many}) == 12


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
