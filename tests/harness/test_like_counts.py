"""Simplifiers of every kind, asked for the same, are compared; asked for different things, they are not."""

import json

import pytest

from lodbench.harness.cli import main

SYSTEMS = ["quadric_clustering", "fast_simplification", "numpy_quadric_clustering", "simplify_call"]


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    """Rows of a sweep over the target, by target and system."""
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "targets.toml").write_text(
        f"systems = {SYSTEMS}\ndatasets = ['displaced_icosphere_20k']\n"
        "[params]\ntarget_reduction = [0.8, 0.97]\n"
    )
    words = ["sweep", str(folder / "targets.toml"), "--samples", "1", "-q"]
    assert main([*words, "--out", str(folder / "run")]) == 0
    made = json.loads((folder / "run/tables/targets.json").read_text())
    return {(row["target_reduction"], row["system"]): row for row in made["rows"]}


@pytest.mark.parametrize("share", [0.8, 0.97])
def test_sweep_over_a_target_compares_like_with_like(rows, share):
    asked = round((1 - share) * 20480)
    for system in SYSTEMS:
        row = rows[share, system]
        assert row["status"] in ("ok", "noisy")
        assert 0.95 * asked <= row["triangles_out"] <= asked
        if system != SYSTEMS[0]:
            assert row["ratio_to_quadric_clustering"] > 0
        assert "no ratio" not in row["reason"]


def test_run_with_unlike_counts_has_no_ratio_and_says_so(capsys, tmp_path):
    words = ["run", "quadric_clustering", "-d", "icosphere_4", "-a", "fast_simplification"]
    out = ["--samples", "1", "-q", "--out", str(tmp_path / "run")]
    assert main([*words, "-s", "cells=20", *out]) == 0
    assert "no ratio: to quadric_clustering: 512 triangles against" in capsys.readouterr().out
    (table,) = (tmp_path / "run/tables").glob("*.json")
    ours, theirs = json.loads(table.read_text())["rows"]
    assert ours["triangles_out"] > 2 * theirs["triangles_out"]
    assert theirs["ratio_to_quadric_clustering"] is None
    assert theirs["reason"].endswith(f"512 triangles against {ours['triangles_out']:,}")


def test_cells_of_a_case_give_way_to_a_target(capsys, tmp_path):
    words = ["run", "quadric_clustering", "-d", "icosphere_4", "--case", "cells_30", "--json"]
    out = ["--samples", "1", "-q", "--out", str(tmp_path / "run")]
    assert main([*words, "-s", "target_count=400", *out]) == 0
    (row,) = json.loads(capsys.readouterr().out)[0]["rows"]
    assert 380 <= row["triangles_out"] <= 400
