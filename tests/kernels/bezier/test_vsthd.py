import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen import patches
from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels import tessellate
from lodbench.kernels.bezier.vst import Params as VstParams
from lodbench.kernels.bezier.vst import Vst
from lodbench.kernels.bezier.vsthd import Params, Vsthd
from lodbench.kernels.bezier.vsthd.reference import draws, map_bytes, uniform_vectors
from lodbench.kernels.opencl import Unsupported
from lodbench.kernels.system import run
from tests.kernels.bezier.patches import NASTY, sheets

MEMORIES = ("uniform", "texture", "global")


def as_bytes(device, prepared):
    run(device, prepared)
    assert prepared.check().passed
    (mesh,) = prepared.result()
    normals = b"" if mesh.normals is None else mesh.normals.tobytes()
    return mesh.positions.tobytes(), mesh.triangles.tobytes(), normals


@settings(max_examples=10, deadline=None)
@given(sheets, st.integers(0, 4), st.integers(1, 5), st.booleans())
def test_vsthd_in_any_memory_gives_the_bytes_of_vst(device, surface, level, each, normals):
    expected = as_bytes(device, Vst(device, surface, VstParams(level, normals)))
    for memory in MEMORIES:
        params = Params(level, normals, memory, each)
        assert as_bytes(device, Vsthd(device, surface, params)) == expected


@pytest.mark.parametrize("memory", MEMORIES)
@pytest.mark.parametrize("name", NASTY)
def test_vsthd_bears_nasty_patches(device, name, memory):
    as_bytes(device, Vsthd(device, BezierPatches(NASTY[name]), Params(2, memory=memory)))


@pytest.mark.parametrize(
    ("patch_count", "each", "expected"), [(160, 7, 23), (160, 15, 11), (640, 7, 92), (7, 7, 1)]
)
def test_draws_are_as_many_as_uniforms_ask_for(patch_count, each, expected):
    assert draws(patch_count, each) == expected
    assert uniform_vectors(each) <= (128 if each == 7 else 256)


def test_vsthd_counts_its_draws(device):
    counters = Vsthd(device, patches.copies(patches.pot(8), 5), Params(3)).counters()
    assert (counters["draws"], counters["map_bytes"]) == (23, map_bytes(3, 7)) == (23, 7 * 81 * 12)


def test_vsthd_needs_constant_memory(device):
    most = device.handle.max_constant_buffer_size // 256
    if most >= 4096:
        pytest.skip("device has constant memory for any draw")
    with pytest.raises(Unsupported, match=r"surfaces_per_draw: needs .* of constant memory"):
        Vsthd(device, patches.cup(), Params(surfaces_per_draw=most + 1))


def test_vsthd_from_python():
    points, faces = tessellate(patches.cup(), level=2, method="vsthd", memory="texture")
    expected = tessellate(patches.cup(), level=2)
    assert np.array_equal(points, expected[0]) and np.array_equal(faces, expected[1])
    with pytest.raises(ValueError, match="memory: expected one of uniform, texture, global"):
        tessellate(patches.cup(), method="vsthd", memory="local")
