import numpy as np
import pytest

from lodbench.kernels.opencl.device import Device
from lodbench.kernels.opencl.driver import Unsupported
from lodbench.kernels.opencl.image import upload_image
from lodbench.kernels.opencl.timeline import Timeline

SOURCE = """
__constant sampler_t texel = CLK_NORMALIZED_COORDS_FALSE | CLK_ADDRESS_CLAMP_TO_EDGE | CLK_FILTER_NEAREST;
__kernel void fetch(read_only image2d_t texels, __global float *out, const uint width)
{
    const int k = get_global_id(0);
    vstore4(read_imagef(texels, texel, (int2)(k % width, k / width)), k, out);
}
"""


@pytest.fixture
def program(device, tmp_path):
    file = tmp_path / "fetch.cl"
    file.write_text(SOURCE)
    return device.build(str(file))


@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (160, 16)])
def test_image_is_read_texel_by_texel(device, program, shape):
    texels = np.random.default_rng(0).normal(size=(*shape, 4)).astype(np.float32)
    count = shape[0] * shape[1]
    out = device.allocate("out", (count, 4), np.float32)
    image = upload_image(device, "texels", texels)
    program.launch("fetch", count, stage="s", local=1, texels=image, out=out, width=shape[1])(
        Timeline()
    )
    assert np.array_equal(device.read(out).reshape(texels.shape), texels)
    assert image.size_bytes == texels.nbytes


def test_image_and_buffer_are_not_taken_for_each_other(device, program):
    image = upload_image(device, "texels", np.zeros((1, 1, 4), np.float32))
    buffer = device.allocate("out", 4, np.float32)
    with pytest.raises(TypeError, match="texels: expected an Image, got out"):
        program.launch("fetch", 1, stage="s", texels=buffer, out=buffer, width=1)
    with pytest.raises(TypeError, match="out: expected a Buffer, got texels"):
        program.launch("fetch", 1, stage="s", texels=image, out=image, width=1)


def test_image_refuses_what_it_cannot_hold(device):
    with pytest.raises(TypeError, match="texels: expected float32, got float64"):
        upload_image(device, "texels", np.zeros((1, 1, 4)))
    for shape in ((1, 4), (1, 1, 3), (0, 1, 4)):
        with pytest.raises(ValueError, match=r"texels: expected shape \(h, w, 4\)"):
            upload_image(device, "texels", np.zeros(shape, np.float32))
    high = Device.open().handle.image2d_max_height + 1
    with pytest.raises(Unsupported, match="texels: needs 1 x"):
        upload_image(device, "texels", np.zeros((high, 1, 4), np.float32))
