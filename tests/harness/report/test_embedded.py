import base64
import io
import json

import numpy as np
import pytest
from PIL import Image

from lodbench.harness.report import embedded


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "images").mkdir()
    return tmp_path


def save(folder, name, size=(700, 350)):
    noise = np.random.default_rng(1).integers(0, 255, (size[1], size[0], 3), np.uint8)
    Image.fromarray(noise).save(folder / "images" / name)


def listed(folder, *pictures):
    (folder / "images/pictures.json").write_text(json.dumps(pictures))


def decoded(picture):
    return Image.open(io.BytesIO(base64.b64decode(picture.data.partition(",")[2])))


def test_pictures_are_made_small_in_the_order_of_their_list(folder):
    for name in ("a.png", "b.jpg", "c.png"):
        save(folder, name)
    (folder / "images/d.txt").write_text("no picture")
    listed(
        folder,
        {"file": "c.png", "caption": "third", "series": "s", "table": "t"},
        {"file": "b.jpg", "caption": "second", "name": "b"},
    )
    found = embedded.pictures(folder)
    assert [one.caption for one in found] == ["third", "second", "a"]
    assert (found[0].series, found[0].table, found[1].name) == ("s", "t", "b")
    assert found[0].data.startswith("data:image/webp;base64,")
    assert decoded(found[0]).size == (embedded.WIDTH, embedded.WIDTH // 2)
    assert (found[1].width, found[1].height) == (embedded.SMALL, embedded.SMALL // 2)
    assert embedded.pictures(folder) == found


def test_many_pictures_are_made_smaller_so_that_the_page_is(folder, monkeypatch):
    save(folder, "a.png")
    (fine,) = embedded.pictures(folder)
    monkeypatch.setattr(embedded, "ROOM", len(fine.data) - 1)
    (coarse,) = embedded.pictures(folder)
    assert len(coarse.data) < len(fine.data) and coarse.width == fine.width


def test_small_pictures_stay_as_large_as_they_are(folder):
    save(folder, "a.png", (3, 1))
    assert decoded(embedded.pictures(folder)[0]).size == (3, 1)


def test_what_is_no_picture_is_named(folder, monkeypatch):
    (folder / "images/a.png").write_bytes(b"\x89PNG no")
    with pytest.raises(ValueError, match=r"a\.png: expected a picture, got"):
        embedded.pictures(folder)
    save(folder, "a.png", (30, 20))
    monkeypatch.setattr(embedded, "MOST_PIXELS", 100)
    with pytest.raises(ValueError, match=r"a\.png: expected a picture, got 30 x 20 pixels"):
        embedded.pictures(folder)


def test_series_are_strips_and_levels_sliders(folder):
    names = [f"{k}.png" for k in range(6)]
    for name in names:
        save(folder, name, (3, 2))
    listed(
        folder,
        *({"file": name, "caption": "", "series": "levels", "level": k} for k, name in enumerate(names[:3])),
        *({"file": name, "caption": "", "series": "methods"} for name in names[3:]),
    )  # fmt: skip
    found = embedded.pictures(folder)
    strips = embedded.strips(found)
    assert [len(strip) for strip in strips] == [3, 3]
    assert [embedded.is_slider(strip) for strip in strips] == [True, False]
    assert embedded.rivals(found) == strips[1]
    assert embedded.pictures(folder / "none") == []
