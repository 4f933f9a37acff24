import re

import numpy as np
import pytest

from lodbench.kernels.opencl import source
from lodbench.kernels.opencl.source import KERNELS, PRELUDE, kernel_parameters, texts_of

FILES = sorted(str(path.relative_to(KERNELS)) for path in KERNELS.rglob("*.cl"))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """In place of `kernels/`: d needs b and c, which both need a."""
    monkeypatch.setattr(source, "KERNELS", tmp_path)
    (tmp_path / "common").mkdir()
    for file, needed in {
        PRELUDE: "",
        "a.cl": "",
        "b.cl": "// Needs     a.cl\n",
        "c.cl": f"// Work      one\n// Needs     {PRELUDE}, a.cl\n",
        "d.cl": "// Needs b.cl c.cl\n",
    }.items():
        (tmp_path / file).write_text(f"{needed}// the text of {file}\n")
    return tmp_path


@pytest.mark.parametrize(
    ("files", "joined"),
    [
        (["a.cl"], ["a.cl"]),
        (["b.cl"], ["a.cl", "b.cl"]),
        (["c.cl"], [PRELUDE, "a.cl", "c.cl"]),
        (["d.cl"], ["a.cl", "b.cl", PRELUDE, "c.cl", "d.cl"]),
        (["b.cl", "a.cl", "b.cl"], ["a.cl", "b.cl"]),
        (["c.cl", "b.cl"], [PRELUDE, "a.cl", "c.cl", "b.cl"]),
    ],
)
def test_needed_files_are_joined_once_and_before_those_that_need_them(folder, files, joined):
    texts = texts_of(files)
    assert list(texts) == joined
    assert all(text.endswith(f"// the text of {file}\n") for file, text in texts.items())


@pytest.mark.parametrize("files", [["a.cl"], ["d.cl"], [PRELUDE]])
def test_prelude_comes_first_and_once(folder, files):
    assert [*texts_of(files, prelude=True)] == [
        PRELUDE,
        *(file for file in texts_of(files) if file != PRELUDE),
    ]


def test_file_outside_the_folder_is_taken_by_its_path(folder, tmp_path_factory):
    own = tmp_path_factory.mktemp("elsewhere") / "own.cl"
    own.write_text("// Needs b.cl\n")
    assert list(texts_of([own])) == ["a.cl", "b.cl", str(own)]


@pytest.mark.parametrize("file", FILES)
def test_every_file_of_the_kernels_stands_after_those_that_it_needs(file):
    order = list(texts_of([file], prelude=True))
    assert (order[0], order[-1]) == (PRELUDE, file if file != PRELUDE else PRELUDE)
    for place, name in enumerate(order):
        for line in re.findall(r"(?m)^// Needs +(.*)$", (KERNELS / name).read_text("utf-8")):
            assert set(re.split(r"[,\s]+", line.strip())) <= set(order[:place])


def test_kernel_parameters_are_read_from_the_source():
    source = """
        /* __kernel void not_this(int a) */
        __kernel __attribute__((reqd_work_group_size(64, 1, 1)))
        void first(__global const float4 *restrict positions, // (a comment, with a comma)
                   __constant uint *table, __local ulong *scratch,
                   const uint2 size, const int sign, __global uchar *flags)
        {
        }
        // __kernel void nor_this(int a)
        __kernel void second(const double value) {}
    """
    found = kernel_parameters(source)
    assert list(found) == ["first", "second"]
    described = [(p.name, p.space, p.scalar.name, p.lanes) for p in found["first"]]
    assert described == [
        ("positions", "global", "float32", 4),
        ("table", "constant", "uint32", 1),
        ("scratch", "local", "uint64", 1),
        ("size", "", "uint32", 2),
        ("sign", "", "int32", 1),
        ("flags", "global", "uint8", 1),
    ]
    assert [(p.space, p.scalar.name) for p in found["second"]] == [("", "float64")]


def test_kernel_parameters_refuse_a_type_of_one_s_own():
    with pytest.raises(ValueError, match="odd: expected a built-in scalar or vector type"):
        kernel_parameters("__kernel void odd(__global struct node *nodes) {}")


def test_kernel_parameters_of_functions_that_are_no_kernels_are_left_out():
    found = kernel_parameters("static void helper(int a) {}\n__kernel void none() {}\n")
    assert found == {"none": ()}


@pytest.mark.parametrize("lanes", [1, 2, 3, 4, 8, 16])
@pytest.mark.parametrize(
    "name", ["char", "uchar", "short", "ushort", "int", "uint", "long", "ulong"]
)
def test_kernel_parameter_has_the_lanes_and_the_type_of_its_text(name, lanes):
    text = f"{name}{lanes if lanes > 1 else ''}"
    ((parameter,),) = kernel_parameters(f"__kernel void k(const {text} value) {{}}").values()
    kind = np.dtype(("u" if name[0] == "u" else "") + {"char": "int8", "short": "int16",
                    "int": "int32", "long": "int64"}[name.removeprefix("u")])  # fmt: skip
    assert (parameter.scalar, parameter.lanes, parameter.space) == (kind, lanes, "")
