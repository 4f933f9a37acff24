import numpy as np
import pytest

from lodbench.kernels.image import mean_absolute_difference, psnr, write_png


def test_write_png_writes_what_a_reader_reads(tmp_path):
    image = np.random.default_rng(0).integers(0, 256, (7, 5, 3), dtype=np.uint8)
    write_png(tmp_path / "image.png", image)
    from PIL import Image

    np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / "image.png")), image)


def test_write_png_refuses_what_is_no_image(tmp_path):
    with pytest.raises(TypeError, match="image: expected uint8, got float64"):
        write_png(tmp_path / "image.png", np.zeros((2, 2, 3)))
    with pytest.raises(ValueError, match=r"image: expected \(height, width, 3\), got shape \(2,\)"):
        write_png(tmp_path / "image.png", np.zeros(2, np.uint8))


def test_psnr_and_mean_absolute_difference_of_known_images():
    a = np.zeros((4, 4, 3), np.uint8)
    b = np.full((4, 4, 3), 5, np.uint8)
    assert psnr(a, a) == np.inf
    assert psnr(a, b) == pytest.approx(10 * np.log10(255**2 / 25))
    assert mean_absolute_difference(a, b) == 5
    b[0] = 0
    assert mean_absolute_difference(a, b) == pytest.approx(3.75)
    assert psnr(a, b, where=np.arange(16).reshape(4, 4) < 4) == np.inf


def test_comparing_two_shapes_is_an_error():
    a, b = np.zeros((2, 2, 3), np.uint8), np.zeros((2, 3, 3), np.uint8)
    with pytest.raises(ValueError, match="two images of one shape"):
        psnr(a, b)
    with pytest.raises(ValueError, match="at least one pixel"):
        psnr(a, a, where=np.zeros((2, 2), bool))
