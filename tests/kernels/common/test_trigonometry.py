import numpy as np
import pytest

from lodbench.kernels.opencl.timeline import Timeline
from tests.tolerances import TURN

KERNEL = """// Needs common/trigonometry.cl, common/packed.cl
__kernel void turns(__global const float *restrict x, __global float *restrict sines,
    __global float *restrict cosines, __global float *restrict roots, const uint count)
{
    const uint i = get_global_id(0);
    if (8 * i >= count) return;
    float8 s, c;
    sine_cosine_of_turns(vload8(i, x), &s, &c);
    vstore8(s, i, sines);
    vstore8(c, i, cosines);
    vstore8(float8_rsqrt(vload8(i, x)), i, roots);
}
"""


@pytest.fixture(scope="module")
def evaluate(device, tmp_path_factory):
    file = tmp_path_factory.mktemp("kernels") / "turns.cl"
    file.write_text(KERNEL)
    program = device.build(file)

    def call(x):
        x = np.ascontiguousarray(x, np.float32)
        buffers = [device.allocate(name, len(x), np.float32) for name in ("s", "c", "r")]
        names = dict(zip(("sines", "cosines", "roots"), buffers, strict=True))
        program.launch(
            "turns", len(x) // 8, stage="test", x=device.upload("x", x), count=len(x), **names
        )(Timeline())
        return [device.read(b) for b in buffers]

    return call


@pytest.mark.parametrize("reach", [0.2, 3.0, 1000.0, 2.0**19])
def test_sine_cosine_of_turns_agree_with_numpy(evaluate, reach):
    x = np.random.default_rng(1).uniform(-reach, reach, 1 << 14).astype(np.float32)
    sines, cosines, _ = evaluate(x)
    angle = 2 * np.pi * np.mod(x.astype(np.float64), 1.0)
    assert np.abs(sines - np.sin(angle)).max() < TURN
    assert np.abs(cosines - np.cos(angle)).max() < TURN


def test_sine_cosine_of_whole_eighths_of_a_turn(evaluate):
    x = np.arange(-32, 32) / 8
    sines, cosines, _ = evaluate(x)
    assert np.abs(sines - np.sin(2 * np.pi * x)).max() < TURN
    assert np.abs(cosines - np.cos(2 * np.pi * x)).max() < TURN
    assert (sines[::4] == 0).all()  # whole and half turns are exact
    assert (np.abs(cosines[::4]) == 1).all()


def test_float8_rsqrt_is_good_to_two_units(evaluate):
    x = 10.0 ** np.random.default_rng(2).uniform(-29, 29, 1 << 14)
    x = x.astype(np.float32)
    *_, roots = evaluate(x)
    exact = 1 / np.sqrt(x.astype(np.float64))
    assert (np.abs(roots - exact) <= 2 * np.spacing(exact.astype(np.float32))).all()
