"""The prelude's functions and the driver's own built-ins against numpy, through the same kernels."""

import re

import numpy as np
import pytest

from lodbench.kernels.opencl.device import Device
from lodbench.kernels.opencl.source import KERNELS, PRELUDE
from lodbench.kernels.opencl.timeline import Timeline
from tests.tolerances import ROUNDING32

WIDTHS = (1, 2, 3, 4, 8, 16)
COUNT = 48 * 21  # a whole number of vectors of every width

PRELUDE_TEXT = (KERNELS / PRELUDE).read_text()
SHADOWED = re.findall(r"^#define (\w+)(?:\(.*?\))? ", PRELUDE_TEXT.split("the names that")[1], re.M)


def opened(prelude):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LODBENCH_PRELUDE", prelude)
        return Device.open()


@pytest.fixture(scope="module", params=["0", "1"], ids=["built-in", "prelude"])
def either(request):
    """A device that uses the driver's own built-ins, and one that uses the prelude."""
    made = opened(request.param)
    assert made.facts.prelude == (request.param == "1")
    return made


@pytest.fixture(scope="module")
def sound(either, device):
    """The same, but built-ins only where they are used: a driver that cannot inline them may not even compile them."""
    if device.facts.prelude and not either.facts.prelude:
        pytest.skip(
            "this driver's own built-ins are not used here: some builds cannot compile them"
        )
    return either


def fma(a, b, c):
    # exact product of two float32 in float64; the values below keep the sum exact as well
    return np.float32(a.astype(np.float64) * b + c)


def clamp(a, b, c):
    return np.minimum(np.maximum(a, b), c)


def mix(a, b, c):
    return a + (b - a) * c


# name: (numpy, arguments, type, tolerance relative to the operands, forms with a scalar in place of a vector)
LANEWISE = {
    "mad": (lambda a, b, c: a * b + c, 3, "float", ROUNDING32, ""),
    "fma": (fma, 3, "float", 0, ""),
    "mix": (mix, 3, "float", ROUNDING32, "vvs"),
    "fabs": (np.abs, 1, "float", 0, ""),
    "floor": (np.floor, 1, "float", 0, ""),
    "ceil": (np.ceil, 1, "float", 0, ""),
    "trunc": (np.trunc, 1, "float", 0, ""),
    "fmin": (np.minimum, 2, "float", 0, "vs"),
    "fmax": (np.maximum, 2, "float", 0, "vs"),
    "native_divide": (np.divide, 2, "float", ROUNDING32, ""),
    "native_recip": (np.reciprocal, 1, "float", ROUNDING32, ""),
} | {
    name: (lambda a: np.sqrt(np.abs(a)), 1, "float", ROUNDING32, "")
    for name in ("sqrt", "native_sqrt", "half_sqrt")
} | {
    name: (lambda a: 1 / np.sqrt(np.abs(a)), 1, "float", ROUNDING32, "")
    for name in ("rsqrt", "native_rsqrt", "half_rsqrt")
}  # fmt: skip
# the half_ and native_ forms are allowed 8192 units in the last place, or any error; numpy's root is of |a|
LOOSE = {"half_sqrt": 2e-3, "half_rsqrt": 2e-3, "native_sqrt": 2e-3, "native_rsqrt": 2e-3}
NEEDS_POSITIVE = {"sqrt", "native_sqrt", "half_sqrt", "rsqrt", "native_rsqrt", "half_rsqrt"}
ORDERING = {"min": np.minimum, "max": np.maximum, "clamp": clamp}
GEOMETRIC = {
    "dot", "cross", "length", "distance", "normalize", "fast_length", "fast_normalize",
}  # fmt: skip
BITS = {"popcount", "clz"}
MEMORY = {f"v{verb}{width}" for verb in ("load", "store") for width in WIDTHS[1:]}


def test_every_shadowed_name_is_tested_below():
    no_result = {
        "prefetch"
    }  # a hint: nothing to compare, and every kernel that uses it is built below
    assert set(SHADOWED) - no_result == set(LANEWISE) | set(ORDERING) | GEOMETRIC | BITS | MEMORY


def vector(kind, width):
    return kind if width == 1 else f"{kind}{width}"


def read(width, array, index="i"):
    return f"{array}[{index}]" if width == 1 else f"vload{width}({index}, {array})"


def store(width, value, array):
    return f"{array}[i] = {value};" if width == 1 else f"vstore{width}({value}, i, {array});"


def call_kernel(name, kind, arity, forms):
    """A kernel that applies `name` at every width, and in its mixed forms, one block of output each."""
    lines, blocks = [], 0
    for form in ["v" * arity, *filter(None, forms.split(","))]:
        for width in WIDTHS:
            if width == 1 and "s" in form:
                continue
            arguments = [
                read(width if place == "v" else 1, array)
                for place, array in zip(form, "abc", strict=False)
            ]
            value = f"{name}({', '.join(arguments)})"
            out = f"(out + {blocks} * count)"
            lines.append(f"for (uint i = 0; i < count / {width}; ++i) {store(width, value, out)}")
            blocks += 1
    pointers = ", ".join(f"__global const {kind} *restrict {x}" for x in "abc"[:arity])
    body = "\n    ".join(lines)
    return blocks, (
        f"__kernel void check_{name}_{kind}({pointers}, __global {kind} *restrict out, const uint count)\n"
        f"{{\n    if (get_global_id(0) > 0) return;\n    {body}\n}}\n"
    )


def expected_blocks(function, arrays, forms):
    for form in ["v" * len(arrays), *filter(None, forms.split(","))]:
        for width in WIDTHS:
            if width == 1 and "s" in form:
                continue
            yield function(
                *[
                    array if place == "v" else np.repeat(array[: COUNT // width], width)
                    for place, array in zip(form, arrays, strict=True)
                ]
            )


def launch(device, folder, source, name, out, **arguments):
    folder = folder / "a folder with spaces"
    folder.mkdir(exist_ok=True)
    file = folder / f"{name}.cl"
    file.write_text(source)
    buffers = {
        key: device.upload(key, value) if isinstance(value, np.ndarray) else value
        for key, value in arguments.items()
    }
    target = device.upload("out", out)
    program = device.build(file)
    program.launch(name, 1, stage="test", local=1, out=target, **buffers)(Timeline())
    return device.read(target)


def floats(seed):
    """Values of both signs, halves and whole numbers among them."""
    random = np.random.default_rng(seed)
    values = random.normal(0, 4, COUNT).astype(np.float32)
    values[::7] = np.round(values[::7])
    values[3::7] = np.round(values[3::7]) + np.float32(0.5)
    return values


@pytest.mark.parametrize("name", LANEWISE)
def test_lanewise_function_equals_numpy_at_every_width(sound, tmp_path, name):
    function, arity, kind, tolerance, forms = LANEWISE[name]
    tolerance = LOOSE.get(name, tolerance)
    arrays = [floats(seed) for seed in range(arity)]
    if name in NEEDS_POSITIVE:
        arrays = [np.abs(a) + np.float32(0.01) for a in arrays]
    if name in ("native_recip", "native_divide"):
        arrays[-1] = np.abs(arrays[-1]) + np.float32(0.01)
    if name == "fma":
        # c cancels the rounded product: what is left is the rounding that a multiply and an add would lose
        arrays[2] = -(arrays[0] * arrays[1])
    blocks, source = call_kernel(name, kind, arity, forms)
    out = np.full((blocks, COUNT), np.nan, np.float32)
    got = launch(
        sound, tmp_path, source, f"check_{name}_{kind}", out,
        **dict(zip("abc", arrays, strict=False)), count=COUNT,
    )  # fmt: skip
    scale = sum(np.abs(a.astype(np.float64)) for a in arrays) ** (2 if arity == 3 else 1) + 1
    for block, wanted in zip(got, expected_blocks(function, arrays, forms), strict=True):
        if tolerance:
            assert (np.abs(block - wanted) <= tolerance * (scale + np.abs(wanted))).all()
        else:
            np.testing.assert_array_equal(block, wanted)


@pytest.mark.parametrize("kind", ["float", "int", "uint", "long", "ulong"])
@pytest.mark.parametrize("name", ORDERING)
def test_ordering_function_equals_numpy_at_every_width(sound, tmp_path, name, kind):
    dtype = np.dtype({"float": "f4", "int": "i4", "uint": "u4", "long": "i8", "ulong": "u8"}[kind])
    arity = 3 if name == "clamp" else 2
    if kind == "float":
        arrays = [floats(seed) for seed in range(arity)]
    else:
        # the whole range, so that a comparison of the wrong signedness or width shows
        bits = np.random.default_rng(5).integers(0, 2**63, (arity, COUNT), dtype=np.uint64) * 2
        arrays = [b.view(np.uint8).view(dtype)[:COUNT] for b in bits]
    forms = "vs"
    if name == "clamp":
        # the bounds in order; vector bounds of the scalar form repeat one pair per vector
        low, high = np.minimum(arrays[1], arrays[2]), np.maximum(arrays[1], arrays[2])
        arrays, forms = [arrays[0], low, high], "vss"
    blocks, source = call_kernel(name, kind, arity, forms)
    got = launch(
        sound, tmp_path, source, f"check_{name}_{kind}", np.zeros((blocks, COUNT), dtype),
        **dict(zip("abc", arrays, strict=False)), count=COUNT,
    )  # fmt: skip
    for block, wanted in zip(got, expected_blocks(ORDERING[name], arrays, forms), strict=True):
        np.testing.assert_array_equal(block, wanted)


GEOMETRY = {
    "dot": (lambda a, b: (a * b).sum(1), 2, False),
    "length": (lambda a: np.linalg.norm(a, axis=1), 1, False),
    "fast_length": (lambda a: np.linalg.norm(a, axis=1), 1, False),
    "distance": (lambda a, b: np.linalg.norm(a - b, axis=1), 2, False),
    "normalize": (lambda a: a / np.maximum(np.linalg.norm(a, axis=1), 1e-30)[:, None], 1, True),
    "fast_normalize": (
        lambda a: a / np.maximum(np.linalg.norm(a, axis=1), 1e-30)[:, None], 1, True,
    ),
    "cross": (lambda a, b: np.cross(a, b), 2, True),
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "width"),
    [(name, width) for name in GEOMETRY for width in (2, 3, 4) if name != "cross" or width == 3],
)
def test_geometric_function_equals_numpy(sound, tmp_path, name, width):
    function, arity, is_vector = GEOMETRY[name]
    arrays = [floats(seed) for seed in range(arity)]
    rows = COUNT // width
    arrays[0][:width] = 0.0  # a vector without a direction stays as it is
    call = f"{name}({', '.join(read(width, array) for array in 'abc'[:arity])})"
    value = store(width, call, "out") if is_vector else f"out[i] = {call};"
    pointers = ", ".join(f"__global const float *restrict {x}" for x in "abc"[:arity])
    source = (
        f"__kernel void geometry({pointers}, __global float *restrict out, const uint count)\n"
        f"{{\n    for (uint i = 0; i < count; ++i) {value}\n}}\n"
    )
    wanted = function(*[a.astype(np.float64).reshape(rows, width) for a in arrays])
    got = launch(
        sound, tmp_path, source, "geometry", np.full(wanted.shape, np.nan, np.float32),
        **dict(zip("abc", arrays, strict=False)), count=rows,
    )  # fmt: skip
    tolerance = 2e-3 if name.startswith("fast_") else ROUNDING32
    scale = 1 + max(float(np.abs(a).max()) for a in arrays) ** 2
    np.testing.assert_allclose(got, wanted, atol=tolerance * scale)
    if is_vector:
        assert (got.reshape(-1)[:width] == 0).all()


@pytest.mark.parametrize("kind", ["uint", "ulong"])
def test_bit_functions_equal_counting(sound, tmp_path, kind):
    bits = 32 if kind == "uint" else 64
    values = [0, 1, 2, 3, 2 ** (bits - 1), 2**bits - 1, 0x12345678, 2 ** (bits // 2)]
    source = (
        f"__kernel void bits(__global const {kind} *restrict a, __global {kind} *restrict out)\n"
        "{\n    for (uint i = 0; i < 8; ++i) {\n        out[i] = popcount(a[i]);\n"
        "        out[i + 8] = clz(a[i]);\n    }\n}\n"
    )
    dtype = np.dtype(f"u{bits // 8}")
    got = launch(
        sound, tmp_path, source, "bits", np.zeros((2, 8), dtype), a=np.array(values, dtype)
    )
    assert got[0].tolist() == [bin(value).count("1") for value in values]
    assert got[1].tolist() == [bits - value.bit_length() for value in values]


@pytest.mark.parametrize("kind", ["float", "int", "uint", "long", "ulong", "uchar"])
def test_vector_memory_moves_unaligned_vectors_in_every_address_space(sound, tmp_path, kind):
    # one element past the buffer's start: a vector move that assumes alignment would fault or shift
    dtype = np.dtype(
        {"float": "f4", "int": "i4", "uint": "u4", "long": "i8", "ulong": "u8", "uchar": "u1"}[kind]
    )
    loops = "".join(
        f"""
    for (uint i = 0; i < {COUNT} / {w}; ++i) {{
        {kind} own[{w + 1}];
        vstore{w}(vload{w}(i, a + 1), 0, own + 1);
        vstore{w}(vload{w}(0, own + 1), i, shared + 1);
        vstore{w}(vload{w}(i, shared + 1), i, out + {2 * block} * {COUNT} + 1);
        vstore{w}(vload{w}(i, b + 1), i, out + {2 * block + 1} * {COUNT} + 1);
    }}"""
        for block, w in enumerate(WIDTHS[1:])
    )
    source = (
        f"__kernel void memory(__global const {kind} *restrict a, __constant {kind} *restrict b,\n"
        f"    __global {kind} *restrict out, __local {kind} *shared)\n{{{loops}\n}}\n"
    )
    values = (np.random.default_rng(0).integers(0, 200, COUNT + 1)).astype(dtype)
    blocks = 2 * len(WIDTHS[1:])
    got = launch(
        sound, tmp_path, source, "memory", np.zeros(blocks * COUNT + 1, dtype),
        a=values, b=values, shared=(COUNT + 1) * dtype.itemsize,
    )  # fmt: skip
    np.testing.assert_array_equal(got[1:].reshape(blocks, COUNT), np.tile(values[1:], (blocks, 1)))


@pytest.mark.parametrize(
    "file",
    [
        str(path.relative_to(KERNELS))
        for path in sorted(KERNELS.rglob("*.cl"))
        if not re.search(r"^// Defines", path.read_text(), re.M) and path.name != "prelude.cl"
    ],
)
def test_kernel_file_builds_with_and_without_the_prelude(sound, file):
    assert sound.build(file) is not None
