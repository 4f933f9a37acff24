import json
from pathlib import Path

import pytest

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.read import write_mesh
from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.cli.app import main
from lodbench.harness.measure import limits
from lodbench.harness.record import record
from lodbench.harness.record.samples import rows_file
from lodbench.harness.report import derive
from tests.harness import fake


@pytest.fixture(autouse=True)
def fakes(monkeypatch):
    fake.install(monkeypatch.setattr)


@pytest.fixture
def error(capsys):
    """Runs a command that must fail; gives its one line."""

    def run(*words):
        assert main([str(word) for word in words]) == 2
        captured = capsys.readouterr()
        (line,) = captured.err.strip().splitlines()
        assert line.startswith("error: ")
        assert captured.out == ""
        return line

    return run


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["run", "fak"], "expected one like fake, got 'fak'"),
        (["run", "fake", "-d", "onne"], "dataset: expected one of"),
        (["run", "fake", "-d", "one", "-s", "size"], "set: expected NAME=VALUE"),
        (["run", "fake", "-d", "one", "-s", "size=0"], "size: expected at least 1, got 0"),
        (["run", "fake", "-d", "one", "-s", "sise=1"], "expected one like size, got 'sise'"),
        (["run", "fake", "-d", "one", "--filter", "("], "filter: expected a regular expression"),
        (["run", "fake", "-d", "one", "--filter", "x"], "filter: expected the name of some group"),
        (["run", "fake", "-d", "one", "--samples", "0"], "--samples"),
        (["run", "fake", "-d", "one", "--device", "abacus"], "device: expected one of"),
        (["reproduce", "fake_tabel"], "table: expected one like fake_table"),
        (["report", "nowhere"], "run: expected a folder with run.json, got nowhere"),
        (["sweep", "nowhere.toml"], "nowhere.toml"),
        (["runn"], "runn"),
    ],
)
def test_wrong_words_end_with_one_line(error, words, text):
    assert text in error(*words)


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ("systems = [", "expected TOML"),
        ("systems = ['fake']", "datasets: expected a list of names, got None"),
        ("systems = ['fake']\ndatasets = ['one']\nsample = 3", "key: expected one like name"),
        ("systems = ['fake']\ndatasets = ['one']\n[params]\ncells = 3", "params: expected"),
        ("systems = ['fake']\ndatasets = ['one']\n[params.other]\nsize = 3", "params: expected"),
    ],
)
def test_bad_sweep_file_is_refused(error, tmp_path, content, text):
    path = tmp_path / "bad.toml"
    path.write_text(content)
    assert text in error("sweep", path)


def test_folder_for_the_run_that_holds_other_things_is_refused(error, tmp_path):
    (tmp_path / "precious").touch()
    assert "out: expected a new or empty folder" in error(
        "run", "fake", "-d", "one", "--out", tmp_path
    )


def test_folder_for_the_run_that_cannot_be_made_is_refused(error, tmp_path):
    (tmp_path / "file").touch()
    line = error("run", "fake", "-d", "one", "--out", tmp_path / "file" / "run")
    assert "Not a directory" in line


def test_debug_shows_the_traceback(capsys):
    assert main(["report", "nowhere", "--debug"]) == 2
    assert "Traceback" in capsys.readouterr().err


def test_run_measures_against_another_and_prints_rows(tmp_path, capsys):
    words = [
        "run",
        "fake",
        "-d",
        "one",
        "-a",
        "other",
        "-s",
        "size=[1,2]",
        "--samples",
        "2",
        "--json",
    ]
    assert main([*words, "--quiet", "--out", str(tmp_path / "run")]) == 0
    (made,) = json.loads(capsys.readouterr().out)
    assert [(r["system"], r["size"], r["triangles_out"]) for r in made["rows"]] == [
        ("fake", 1, 4), ("other", 1, 4), ("fake", 2, 8), ("other", 2, 8),
    ]  # fmt: skip
    assert made["rows"][1]["ratio_to_fake"] > 0
    assert main(["report", str(tmp_path / "run"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["tables"] == [made], "made again from records alone"


def test_sweep_makes_axes_of_lists(tmp_path, capsys):
    path = tmp_path / "sizes.toml"
    path.write_text(
        "systems = ['fake', 'other']\ndatasets = ['one', 'two']\n[params]\nsize = [1, 2]\n"
        "[params.other]\nseconds = [0.0, 0.001]\n"
    )
    assert (
        main(["sweep", str(path), "--samples", "1", "--quiet", "--out", str(tmp_path / "run")]) == 0
    )
    made = json.loads((tmp_path / "run/tables/sizes.json").read_text())
    assert len(made["rows"]) == 2 * 2 * 3
    assert {row["system"] for row in made["rows"]} == {
        "fake",
        "other seconds=0.0",
        "other seconds=0.001",
    }
    assert "other seconds=0.001" in capsys.readouterr().out


def test_mesh_files_are_datasets_under_safe_names(tmp_path, monkeypatch, capsys):
    monkeypatch.undo()  # the real catalogue and systems
    monkeypatch.setattr(catalogue, "_own", {})
    monkeypatch.setattr(limits, "measure", lambda device: fake.LIMITS)
    monkeypatch.setattr(derive, "write_report", lambda folder: None)
    scans = tmp_path / "My Scans"
    scans.mkdir()
    write_mesh(scans / "Torso A.ply", icosphere(2))
    spec = tmp_path / "own.toml"
    spec.write_text(
        "systems = ['quadric_clustering']\n"
        "datasets = ['My Scans/Torso A.ply', 'icosphere_1']\nparams = { cells = 4 }\n"
    )
    options = ["--samples", "1", "--quiet", "--json", "--out"]
    assert main(["sweep", str(spec), *options, str(tmp_path / "swept")]) == 0
    (made,) = json.loads(capsys.readouterr().out)
    assert [row["dataset"] for row in made["rows"]] == ["torso_a", "icosphere_1"]
    words = ["run", "quadric_clustering", "-d", str(scans / "Torso A.ply"), "-s", "cells=4"]
    assert main([*words, *options, str(tmp_path / "run")]) == 0
    for folder in ("swept", "run"):
        (group, *_) = record.read_run(tmp_path / folder).groups
        assert group.dataset == "torso_a"
        assert (
            group.facts["content"] == group.config["content"] == catalogue.find("torso_a").content
        )
        for row in record.read_rows(rows_file(tmp_path / folder)):
            assert "My Scans" not in json.dumps(row)
        for file in ("run.json", "tables/own.md", "tables/quadric_clustering.md"):
            path = tmp_path / folder / file
            assert not path.exists() or "My Scans" not in path.read_text("utf-8")


def test_reproduce_measures_the_groups_that_the_filter_matches(tmp_path, capsys):
    words = ["reproduce", "--filter", "fake_table: t", "--samples", "1", "--quiet", "--json"]
    assert main([*words, "--out", str(tmp_path / "run")]) == 0
    (made,) = json.loads(capsys.readouterr().out)["tables"]
    assert {row["dataset"] for row in made["rows"]} == {"two", "three"}


def test_rows_are_packed_when_all_is_measured(tmp_path, capsys):
    words = ["reproduce", "--samples", "1", "--quiet", "--out", str(tmp_path / "run")]
    assert main([*words, "--time-budget", "0"]) == 0
    assert rows_file(tmp_path / "run").name == record.SAMPLES
    assert "go on with --resume" in capsys.readouterr().err
    assert main([*words, "--resume"]) == 0
    assert rows_file(tmp_path / "run").suffix == ".gz"


def test_datasets_make_asks_whether_thousands_were_meant(monkeypatch, tmp_path, capsys):
    monkeypatch.undo()  # the real catalogue
    assert main(["datasets", "make", "torus_20", str(tmp_path / "torus.ply")]) == 0
    said = capsys.readouterr()
    assert "36 triangles, 18 points" in said.out
    assert said.err == "hint: torus_20 has 36 triangles; was torus_20k meant?\n"
    assert main(["datasets", "make", "sphere_10", str(tmp_path / "ball.ply")]) == 0
    assert capsys.readouterr().err == ""


def test_list_systems_says_why_one_cannot_be_used(capsys):
    assert main(["list", "systems", "--json"]) == 0
    rows = {row["system"]: row for row in json.loads(capsys.readouterr().out)}
    assert set(rows) == {"fake", "other", "gone"}
    assert "no package" in rows["gone"]["source"]


@pytest.fixture
def runs(tmp_path, device, capsys):
    """Two runs of the same; the second as slow as `slower` asks."""

    def make(slower):
        for name in ("a", "b"):
            words = ["run", "fake", "-d", "one", "--samples", "8", "--quiet", "--out"]
            assert main([*words, str(tmp_path / name)]) == 0
        for name, factor in (("a", 1.0), ("b", slower)):
            path = tmp_path / name / record.SAMPLES
            rows = record.read_rows(rows_file(path.parent))
            for row in rows:
                if row["kind"] == "sample":
                    row["wall_s"] = factor * (1 + 0.01 * (row["turn"] % 3))
            path.write_text("".join(json.dumps(row) + "\n" for row in rows))
        capsys.readouterr()
        return [str(tmp_path / name) for name in ("a", "b")]

    return make


@pytest.mark.parametrize(
    ("slower", "options", "code", "verdict"),
    [
        (1.0, [], 0, "same"),
        (1.5, [], 1, "regression"),
        (1.05, [], 0, "same"),
        (1.5, ["--threshold", "0.8"], 0, "same"),
        (0.5, [], 0, "faster"),
    ],
)
def test_compare_exit_code_tells_a_regression(
    runs, capsys, monkeypatch, slower, options, code, verdict
):
    # of runs that others disturbed it says nothing
    monkeypatch.setattr("lodbench.harness.report.compare.NOISY_OTHERS", 2.0)
    assert main(["compare", *runs(slower), "--json", *options]) == code
    found = json.loads(capsys.readouterr().out)
    assert found["same_machine"]
    assert [row["verdict"] for row in found["rows"]] == [verdict]
    assert found["rows"][0]["ratio"] == pytest.approx(slower, rel=0.05)


def test_compare_counts_a_check_that_fails_now(runs, capsys):
    a, b = runs(1.0)
    path = Path(b, record.SAMPLES)
    path.write_text(path.read_text().replace('"status": "ok"', '"status": "failed"'))
    assert main(["compare", a, b]) == 1
    assert "regression" in capsys.readouterr().out
