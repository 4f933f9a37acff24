import numpy as np
import pytest
from numpy.testing import assert_array_equal

from lodbench.datasets_gen.images import read_geometry_image, write_geometry_image
from lodbench.datasets_gen.read import FileError
from lodbench.datasets_gen.surfaces import GeometryImage


def image():
    values = np.random.default_rng(0).random((5, 5, 3))
    return GeometryImage(values, values[::-1])


def test_geometry_image_is_read_as_it_was_written(tmp_path):
    write_geometry_image(tmp_path / "a.npz", image())
    found = read_geometry_image(tmp_path / "a.npz")
    assert_array_equal(found.positions, image().positions)
    assert_array_equal(found.normals, image().normals)


def test_bad_files_are_refused_by_name(tmp_path):
    with pytest.raises(FileError, match="no such file"):
        read_geometry_image(tmp_path / "none.npz")
    (tmp_path / "torn.npz").write_bytes(b"PK\x03\x04 and no more")
    with pytest.raises(FileError, match=r"torn\.npz"):
        read_geometry_image(tmp_path / "torn.npz")
    np.savez(tmp_path / "other.npz", patches=np.zeros(3))
    with pytest.raises(FileError, match="expected the keys positions, normals"):
        read_geometry_image(tmp_path / "other.npz")
    np.savez(tmp_path / "odd.npz", positions=np.zeros((6, 6, 3)), normals=np.zeros((6, 6, 3)))
    with pytest.raises(FileError, match=r"expected \(2\^n \+ 1"):
        read_geometry_image(tmp_path / "odd.npz")
    with pytest.raises(FileError, match=r"expected the suffix \.npz"):
        write_geometry_image(tmp_path / "a.png", image())


@pytest.mark.parametrize("seed", range(60))
def test_broken_archive_ends_in_one_line_that_names_it(tmp_path, seed):
    path, rng = tmp_path / "a.npz", np.random.default_rng(seed)
    write_geometry_image(path, image())
    data = bytearray(path.read_bytes())
    for at in rng.integers(0, len(data), 4):
        data[at] = rng.integers(256)
    path.write_bytes(data[: rng.integers(1, len(data))] if seed % 2 else data)
    try:
        read_geometry_image(path)
    except FileError as error:
        assert str(error).startswith(str(path))
        assert "\n" not in str(error)
