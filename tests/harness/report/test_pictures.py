import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.report import pictures
from lodbench.harness.report.embedded import pictures as embedded
from lodbench.harness.report.pictures import write_pictures


@pytest.fixture
def draw(device, tmp_path, monkeypatch):
    def drawn(*groups):
        records = [
            GroupRecord(
                "g", "t", "n", dataset, "d", {}, {}, subjects={"s": SubjectRecord("s", system)}
            )
            for dataset, system in groups
        ]
        monkeypatch.setattr(pictures, "SIZE", (80, 64))
        monkeypatch.setattr(pictures, "TABLE_SIZE", (80, 64))
        monkeypatch.setattr(
            pictures, "read_run", lambda folder: RunRecord(Path(folder), {}, records)
        )
        return write_pictures(tmp_path, device)

    return drawn


def test_every_mesh_is_drawn_once_and_the_simplified_one_at_each_level(draw, tmp_path):
    found = draw(
        ("sphere_10", "pattern"),
        ("icosphere_3", "quadric_clustering"),
        ("sphere_10_sorted", "pattern"),
        ("quilt_4", "other"),  # no mesh
    )
    files = [picture["file"] for picture in found]
    assert files == [f"level_{k}_icosphere_3.png" for k in range(5)] + ["sphere_10.png"]
    for file in files:
        pixels = np.asarray(Image.open(tmp_path / "images" / file))
        assert pixels.shape == (64, 80, 3)
        assert len(np.unique(pixels[:, 40], axis=0)) > 6
    whole, _, tenth, _, hundredth = found[:5]
    assert whole["caption"].startswith("icosphere_3 at 100 %: 1,280 triangles, ")
    assert tenth["caption"].startswith("icosphere_3 at 10 %: 1")
    assert hundredth["fps"] > 0
    assert hundredth["samples"] == pictures.SAMPLES
    assert "frames/s" in hundredth["caption"]
    assert json.loads((tmp_path / "images/pictures.json").read_text())[5] == found[5]


def test_report_shows_listed_pictures_in_order_with_captions_and_others_by_name(draw, tmp_path):
    draw(("sphere_100", "pattern"), ("sphere_10", "pattern"))
    Image.new("RGB", (1, 1)).save(tmp_path / "images/a_view.png")
    names = [image.caption for image in embedded(tmp_path)]
    assert names == ["sphere_100: 100 triangles", "sphere_10: 10 triangles", "a view"]


def test_pictures_of_a_series_stand_together(draw, tmp_path):
    draw(("icosphere_1", "pn_triangles"), ("spool_72", "st_triangles"))
    series = [image.series for image in embedded(tmp_path)]
    assert series == ["curved"] * 2 + ["creases"] * 3 + [""] * 2


def test_chain_of_levels_is_drawn_beside_its_mesh(draw, tmp_path):
    draw(("quilt_4", "level_chain"), ("icosphere_3", "other"))
    assert [image.series for image in embedded(tmp_path)] == [""], "which is no mesh"
    draw(("icosphere_4", "level_chain"))
    assert [image.series for image in embedded(tmp_path)][:2] == ["chain"] * 2


def test_run_without_meshes_has_no_pictures(draw, tmp_path):
    assert draw(("quilt_4", "other")) == []
    assert embedded(tmp_path) == []
