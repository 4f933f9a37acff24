import re

import numpy as np
import pytest
from PIL import Image

from lodbench.harness.cli.app import main
from lodbench.harness.plan import table as tables
from lodbench.harness.record.record import read_run
from lodbench.harness.report.charts.chart_data import styles, subjects
from lodbench.harness.report.own_plot import write_plot
from tests.harness.made_run import TABLES, make_run


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_run(tmp_path_factory.mktemp("run"))


@pytest.fixture(autouse=True)
def made_tables(monkeypatch):
    monkeypatch.setattr(tables, "tables", lambda: {table.id: table for table in TABLES})


def drawn(folder, path, x="triangles_in", y="wall_s", by="system", table="clustering", **options):
    said = write_plot(folder, table, x, y, by, path, **options)
    return path.read_text("utf-8") if path.suffix == ".svg" else said


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
def test_plot_is_written_with_the_same_bytes_each_time(folder, tmp_path, suffix):
    first, second = tmp_path / f"a{suffix}", tmp_path / f"b{suffix}"
    for path in (first, second):
        write_plot(folder, "clustering", "triangles_in", "wall_s", "system", path, "xy")
    assert first.read_bytes() == second.read_bytes()
    if suffix == ".png":
        assert (np.asarray(Image.open(first).convert("L")) < 128).any()


def test_systems_have_the_colours_of_the_report(folder, tmp_path):
    svg = drawn(folder, tmp_path / "a.svg", log="xy")
    shared = styles(subjects(read_run(folder)))["clustering"]
    for name in ("quadric_clustering", "fast_simplification"):
        assert name in svg and shared[name].colour in svg


def test_what_cannot_be_drawn_is_counted(folder, tmp_path):
    # of 24 rows, 4 are of a package that is not there
    assert drawn(folder, tmp_path / "a.png") == "20 rows of clustering; 4 have nothing to draw"
    keep = re.compile("quadric_clustering")
    assert drawn(folder, tmp_path / "a.png", keep=keep) == "8 rows of clustering"
    facts = re.compile("triangles_in=20,480")
    assert drawn(folder, tmp_path / "a.png", keep=facts).startswith("5 rows")


@pytest.mark.parametrize(
    ("x", "y", "by", "log"),
    [
        ("dataset", "wall_s", "system", "y"),
        ("rms_error", "wall_s", "system", "xy"),
        ("triangles_in", "ratio_to_fast_simplification", "system", "x"),
        ("wall_s", "triangles_out", "dataset", ""),
        ("system", "stored_bytes", "triangles_in", "y"),
    ],
)
def test_any_column_goes_over_any_other(folder, tmp_path, x, y, by, log):
    svg = drawn(folder, tmp_path / "a.svg", x, y, by, log=log)
    assert svg.startswith("<?xml") and svg.count("<use") > 10


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"x": "triangle_in"}, "x: expected one like triangles_in"),
        ({"y": "system"}, "y: expected numbers under system"),
        ({"y": "none"}, "y: expected"),
        ({"by": "sytem"}, "by: expected one like system"),
        ({"table": "cluster"}, "table: expected one like clustering"),
        ({"table": None}, "table: expected one of clustering, patterns, got ''"),
        ({"log": "z"}, "log: expected one of x, y, xy, got 'z'"),
        ({"keep": re.compile("nobody")}, "x: expected"),
    ],
)
def test_wrong_names_end_with_one_line(folder, tmp_path, change, said):
    with pytest.raises(ValueError, match=re.escape(said)):
        drawn(folder, tmp_path / "a.png", **change)
    assert not list(tmp_path.iterdir())


def test_another_format_is_refused(folder, tmp_path):
    with pytest.raises(
        ValueError, match=r"out: expected a name in \.png, \.svg, \.pdf, got .*a\.gif"
    ):
        drawn(folder, tmp_path / "a.gif")


def test_command_writes_where_it_is_told_or_by_the_columns_names(
    folder, tmp_path, monkeypatch, capfd
):
    monkeypatch.chdir(tmp_path)
    words = ["plot", str(folder), "--x", "triangles_in", "--y", "wall_s", "--table", "clustering"]
    assert main([*words, "--log", "xy"]) == 0
    assert capfd.readouterr().out == (
        "clustering-wall_s-triangles_in.png: 20 rows of clustering; 4 have nothing to draw\n"
    )
    assert (tmp_path / "clustering-wall_s-triangles_in.png").exists()
    assert main([*words, "--y", "wall"]) == 2
    error = capfd.readouterr().err
    assert error.startswith("error: y: expected one like wall") and error.count("\n") == 1
