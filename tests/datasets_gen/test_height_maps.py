import numpy as np
import pytest
from PIL import Image

from lodbench.datasets_gen.height_maps import height_map
from lodbench.datasets_gen.read import FileError

BYTES = np.arange(6, dtype=np.uint8).reshape(2, 3) * 50
WORDS = np.arange(6, dtype=np.uint16).reshape(2, 3) * 13000


@pytest.mark.parametrize("values", [BYTES, WORDS])
def test_png_of_8_and_16_bits_are_shares_of_white(values, tmp_path):
    Image.fromarray(values).save(tmp_path / "map.png")
    expected = (values / np.iinfo(values.dtype).max).astype(np.float32)
    for given in (tmp_path / "map.png", str(tmp_path / "map.png"), values):
        found = height_map(given)
        assert found.dtype == np.float32 and np.array_equal(found, expected)


@pytest.mark.parametrize("mode", ["RGB", "RGBA", "P", "LA", "1"])
def test_png_of_any_kind_is_grey(mode, tmp_path):
    Image.fromarray(np.array([[0, 255], [255, 255]], np.uint8)).convert(mode).save(
        tmp_path / "map.png"
    )
    assert np.array_equal(height_map(tmp_path / "map.png"), [[0, 1], [1, 1]])


def test_npy_and_arrays_are_taken_as_they_are(tmp_path):
    values = np.random.default_rng(0).random((4, 5))
    np.save(tmp_path / "map.npy", values)
    assert np.array_equal(height_map(tmp_path / "map.npy"), values.astype(np.float32))
    assert np.array_equal(height_map(values.T), values.T.astype(np.float32))


@pytest.mark.parametrize(
    ("values", "error", "said"),
    [
        (np.zeros((2, 2, 3)), ValueError, r"height_map: expected \(h, w\) values, got shape \(2, 2, 3\)"),
        (np.zeros((0, 2)), ValueError, "got shape"),
        (np.zeros((2, 2), int), TypeError, "height_map: expected floats, uint8 or uint16, got int64"),
        (np.full((2, 2), 1.5), ValueError, "height_map: expected values of 0 to 1, got 1.5 to 1.5"),
        (np.array([[0, np.nan]]), ValueError, "expected values of 0 to 1, got nan to nan"),
    ],
)  # fmt: skip
def test_arrays_that_are_no_maps_are_refused(values, error, said, tmp_path):
    with pytest.raises(error, match=said):
        height_map(values)
    np.save(tmp_path / "map.npy", values)
    with pytest.raises(FileError, match=f"map.npy: .*{said}"):
        height_map(tmp_path / "map.npy")


def test_files_that_are_no_maps_are_refused(tmp_path):
    Image.fromarray(BYTES).save(tmp_path / "whole.png")
    whole = (tmp_path / "whole.png").read_bytes()
    for name, content in {
        "cut.png": whole[: len(whole) // 2], "text.png": b"text", "empty.png": b"", "text.npy": b"text",
        "pickled.npy": np.lib.format.magic(1, 0) + b"\x10\x00{'descr': '|O'}\n", "map.jpg": whole,
    }.items():  # fmt: skip
        (tmp_path / name).write_bytes(content)
        with pytest.raises(FileError, match=f"{name}: [^\n]+$"):
            height_map(tmp_path / name)
    for name, reason in (("none.png", "no such file"), ("folder.png", "got a folder")):
        (tmp_path / "folder.png").mkdir(exist_ok=True)
        with pytest.raises(FileError, match=reason):
            height_map(tmp_path / name)
