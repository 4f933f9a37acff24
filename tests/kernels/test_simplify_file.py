import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen import batches, catalogue, read
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import displaced_icosphere, terrain, torus
from lodbench.harness.baselines.simplify_file import peak_bytes
from lodbench.harness.cli.app import main
from lodbench.kernels import simplify_file
from lodbench.kernels.simplify_file import MINIMUM, memory_bytes
from tests.datasets_gen.test_batches import ply_of, scattered
from tests.kernels.cluster.meshes import cube, flat_lattice, single_triangle, tetrahedron

streaming = sys.modules[simplify_file.__module__]  # the function has its name
CLUSTERING = "quadric_clustering"  # what streams where no method is named


@pytest.fixture
def small(monkeypatch):
    """Any mesh is larger than the memory, and a batch has a hundred triangles, or as many as are put into the list."""
    monkeypatch.setattr(streaming, "fits", lambda source, allowed: False)
    whole, most = streaming.verbs.streaming, [100]

    def hundreds(method):
        return lambda device, source, spill, rows, told, **options: whole(method)(
            device, source, spill, most[0], told, **options
        )

    monkeypatch.setattr(streaming.verbs, "streaming", hundreds)
    return most


@pytest.fixture(scope="module")
def limited():
    return streaming.limited_device(MINIMUM)


def both(device, limited, source, **options):
    """The bytes of the file made in core and out of core."""
    outs = source.with_name("in.ply"), source.with_name("out.ply")
    whole = simplify_file(
        source, outs[0], device=device, attributes=False, **{"method": CLUSTERING, **options}
    )
    streamed = simplify_file(
        source, outs[1], memory=MINIMUM, device=limited, attributes=False, **options
    )
    assert (whole.streamed, streamed.streamed) == (False, True)
    assert streamed.triangles == whole.triangles and streamed.vertices == whole.vertices
    known = {k: v for k, v in streamed.counters.items() if k != "vertices_in"}
    if source.suffix != ".stl":
        known["vertices_in"] = streamed.counters["vertices_in"]
    assert known == {k: whole.counters[k] for k in known}
    return outs[0].read_bytes(), outs[1].read_bytes()


@pytest.mark.parametrize("suffix", [".ply", ".stl"])
@pytest.mark.parametrize(
    "options",
    [
        {"cells": 12},
        {"cells": (5, 7, 3), "accumulate": "private", "chunks": 3, "placement": "paper"},
        {"cells": 20.5, "accumulate": "fixed_point"},
        {"cells": 1},
        {"target_reduction": 0.8},
        {"target_count": 300, "accumulate": "fixed_point", "placement": "average"},
    ],
    ids=str,
)
def test_out_of_core_has_the_bytes_of_in_core(device, limited, small, tmp_path, options, suffix):
    read.write_mesh(tmp_path / f"a{suffix}", displaced_icosphere(8))
    whole, streamed = both(device, limited, tmp_path / f"a{suffix}", **options)
    assert whole == streamed


@pytest.mark.parametrize(
    "options",
    [{"cells": 12}, {"cells": (5, 7, 3), "chunks": 5}, {"target_reduction": 0.8}],
    ids=str,
)
@pytest.mark.parametrize("spread", [lambda mesh: mesh, scattered], ids=["", "scattered"])
def test_means_have_the_bytes_of_in_core(
    device, limited, small, tmp_path, options, spread, monkeypatch
):
    monkeypatch.setattr(batches, "VERTICES", 77)
    read.write_mesh(tmp_path / "a.ply", spread(displaced_icosphere(8)))
    whole, streamed = both(device, limited, tmp_path / "a.ply", method="vertex_average", **options)
    assert whole == streamed


def test_means_of_points_and_kept_ones_are_of_points_that_triangles_share(limited, small, tmp_path):
    read.write_mesh(tmp_path / "a.stl", displaced_icosphere(8))
    for options in ({"method": "vertex_average"}, {"border": "keep"}):
        with pytest.raises(ValueError, match="expected PLY out of core"):
            simplify_file(tmp_path / "a.stl", tmp_path / "b.ply", cells=9, memory=MINIMUM,
                          device=limited, **options)  # fmt: skip


WAYS = {
    "private": {"accumulate": "private", "chunks": 3},
    "fixed_point": {"accumulate": "fixed_point"},
    "target": {"cells": None, "target_reduction": 0.9},
    "none": {"border": "none"},
}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("suffix", [".ply", ".stl"])
def test_border_edges_hold_their_cells_out_of_core_too(
    device, limited, small, tmp_path, suffix, way
):
    read.write_mesh(tmp_path / f"a{suffix}", terrain(24))
    options = {"cells": 6} | WAYS[way]
    whole, streamed = both(device, limited, tmp_path / f"a{suffix}", **options)
    assert whole == streamed


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("spread", [lambda mesh: mesh, scattered], ids=["", "scattered"])
def test_kept_border_vertices_stay_out_of_core_too(device, limited, small, tmp_path, way, spread):
    read.write_mesh(tmp_path / "a.ply", spread(terrain(24)))
    options = {"cells": 6, **WAYS[way], "border": "keep"}
    whole, streamed = both(device, limited, tmp_path / "a.ply", **options)
    assert whole == streamed


@pytest.mark.parametrize("method", ["quadric_clustering", "vertex_average"])
@pytest.mark.parametrize("spread", [False, True], ids=["", "scattered"])
def test_normals_and_colours_become_means(device, limited, small, tmp_path, method, spread):
    mesh = displaced_icosphere(24)
    order = np.random.default_rng(0).permutation(mesh.vertex_count) if spread else slice(None)
    number = np.argsort(order) if spread else np.arange(mesh.vertex_count)
    mesh = replace(
        mesh,
        positions=mesh.positions[order],
        triangles=number[mesh.triangles].astype(np.uint32),
        normals=mesh.positions[order] * 3,
        colours=np.clip(0.5 + 0.3 * mesh.positions[order], 0, 1),
        uvs=mesh.positions[order, :2],
    )
    read.write_mesh(tmp_path / "a.ply", mesh)
    options = {"cells": 14, "method": method}
    whole = simplify_file(
        tmp_path / "a.ply", tmp_path / "in.ply", device=device, **{"method": CLUSTERING, **options}
    )
    assert whole.counters["split_vertices"] == 0
    done = simplify_file(
        tmp_path / "a.ply", tmp_path / "out.ply", memory=MINIMUM, device=limited, **options
    )
    assert done.extras == ("uvs",)
    expected, found = (read.read_mesh(tmp_path / f"{name}.ply") for name in ("in", "out"))
    assert found.positions.tobytes() == expected.positions.tobytes()
    assert found.triangles.tobytes() == expected.triangles.tobytes()
    assert np.abs(found.normals - expected.normals).max() < 1e-4
    assert np.abs(found.colours - expected.colours).max() < 1.5 / 255


@pytest.mark.parametrize("order", ["little", "big"])
@pytest.mark.parametrize("kind", ["float", "double"])
def test_scattered_and_far_files_too(device, limited, small, tmp_path, kind, order):
    mesh = scattered(torus(40, 24))
    far = TriangleMesh(mesh.positions + np.array([4e5, 3.0, 0.0]), mesh.triangles)
    (tmp_path / "a.ply").write_bytes(ply_of(far, order, kind, more=("flag", "red")))
    whole, streamed = both(device, limited, tmp_path / "a.ply", cells=16)
    assert whole == streamed
    assert (b"double" in whole) == (kind == "double")


NASTY = {
    "one": single_triangle(), "tetrahedron": tetrahedron(), "flat": flat_lattice(9), "cube": cube(),
    "point": TriangleMesh(np.ones((3, 3)), [[0, 1, 2]]),
    "twice": TriangleMesh(tetrahedron().positions, np.tile(tetrahedron().triangles, (40, 1))),
    "tiny": TriangleMesh(tetrahedron().positions * np.float32(1e-30), tetrahedron().triangles),
    "huge": TriangleMesh(tetrahedron().positions * np.float32(1e30), tetrahedron().triangles),
    "unused": TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [9, 9, 9]], [[0, 1, 2]]),
    "folded": TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 1], [0, 1, 2], [2, 2, 2]]),
    "minus": TriangleMesh([[-0.0, 0, 0], [1, -0.0, 0], [0.0, 1, 0]], [[0, 1, 2]]),
}  # fmt: skip


@pytest.mark.parametrize("name", NASTY)
@pytest.mark.parametrize("accumulate", ["private", "fixed_point"])
@pytest.mark.parametrize("border", ["quadrics", "keep"])
def test_nasty_meshes_pass_through(device, limited, small, tmp_path, name, accumulate, border):
    read.write_mesh(tmp_path / "a.ply", NASTY[name])
    options = {"cells": 7, "accumulate": accumulate, "border": border}
    whole, streamed = both(device, limited, tmp_path / "a.ply", **options)
    assert whole == streamed


@settings(
    max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    st.integers(1, 60),
    st.integers(1, 400),
    st.integers(0, 99),
    st.integers(1, 4),
    st.floats(1, 30),
    st.integers(20, 500),
    st.sampled_from(["quadrics", "none", "keep"]),
)
def test_any_soup_has_the_bytes_of_in_core(
    device, limited, small, tmp_path, points, triangles, seed, chunks, cells, rows, border
):
    small[0] = rows
    random = np.random.default_rng(seed)
    mesh = TriangleMesh(
        random.normal(size=(points, 3)).astype(np.float32),
        random.integers(0, points, (triangles, 3)),
    )
    read.write_mesh(tmp_path / "a.ply", mesh)
    whole, streamed = both(
        device, limited, tmp_path / "a.ply", cells=cells, chunks=chunks, accumulate="private",
        border=border,
    )  # fmt: skip
    assert whole == streamed


def test_an_empty_file_and_no_triangles(device, small, tmp_path):
    (tmp_path / "a.ply").write_bytes(ply_of(TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int))))
    done = simplify_file(tmp_path / "a.ply", tmp_path / "b.ply", cells=4, memory="64M")
    assert (done.vertices, done.triangles) == (0, 0)
    assert read.read_mesh(tmp_path / "b.ply").triangle_count == 0
    (tmp_path / "a.ply").write_bytes(ply_of(TriangleMesh(np.ones((9, 3)), np.zeros((0, 3), int))))
    with pytest.raises(ValueError, match="faces: expected triangles, got 9 points and none"):
        simplify_file(tmp_path / "a.ply", tmp_path / "b.ply", cells=4, memory="64M")


@pytest.mark.parametrize(
    ("text", "count"),
    [("512M", 512 << 20), ("2G", 2 << 30), ("1.5GiB", 3 << 29), (1 << 30, 1 << 30), ("70000 kb", 70000 << 10)],
)  # fmt: skip
def test_memory_is_read_as_people_write_it(text, count):
    assert memory_bytes(text) == count


@pytest.mark.parametrize("text", ["", "lots", "-2G", "2X", "63M", 1024, "0", "1e9", "2GG"])
def test_other_memory_is_refused(text):
    with pytest.raises(ValueError, match="memory: expected") as error:
        memory_bytes(text)
    assert "\n" not in str(error.value)


def test_options_that_need_the_whole_mesh_are_refused_out_of_core(small, limited, tmp_path):
    read.write_mesh(tmp_path / "a.ply", torus(20, 10))

    def attempt(out="b.ply", **options):
        given = {"cells": 9} | options
        simplify_file(tmp_path / "a.ply", tmp_path / out, memory="64M", device=limited, **given)

    for problem, options in {
        "remove_duplicates: expected False": {"remove_duplicates": True},
        "remove_flipped: expected False": {"remove_flipped": True},
        "manifold: expected False": {"manifold": True},
        "method: expected quadric_clustering, vertex_average": {"method": "octree"},
        "regions, view, warp: expected none": {"regions": ((0.0, 0.0, 0.0, 1.0, 2.0),)},
        "expected a name that ends in .ply": {"out": "b.obj"},
        "target_count: expected a grid": {"cells": None, "target_reduction": 0.0},
        "memory: expected enough for the grid's cells, got 64M": {"cells": 700},
        "option: expected": {"placment": "robust"},
    }.items():
        with pytest.raises((ValueError, TypeError), match=problem) as error:
            attempt(**options)
        assert "\n" not in str(error.value)
    assert sorted(os.listdir(tmp_path)) == ["a.ply"]


def test_a_mesh_that_fits_is_done_in_core(device, tmp_path):
    read.write_mesh(tmp_path / "a.obj", torus(20, 10))
    done = simplify_file(
        tmp_path / "a.obj", tmp_path / "b.stl", cells=9, memory="64M", device=device
    )
    assert not done.streamed
    assert streaming.fits(tmp_path / "a.obj", MINIMUM)
    with pytest.raises(read.FileError, match="out of core: expected a whole binary file"):
        streaming.fits(tmp_path / "a.obj", 1000)


PASSES = ("box", "borders", "search", "cells", "triangles", "write")


def attempt(folder, device, at=None, action=None, **options):
    """Simplify a.ply of the folder to b.ply, and do something as a pass begins."""

    def told(what, share):
        nonlocal at
        if what == at:
            at = None
            action()

    given = {"cells": None, "target_count": 60} | options
    simplify_file(
        folder / "a.ply", folder / "b.ply", memory="64M", device=device, told=told, **given
    )


def interrupt():
    raise KeyboardInterrupt


@pytest.fixture(params=[lambda mesh: mesh, scattered], ids=["", "scattered"])
def folder(tmp_path, request):
    """With a mesh, and what was there before."""
    read.write_mesh(tmp_path / "a.ply", request.param(terrain(12)))
    (tmp_path / "b.ply").write_bytes(b"old")
    yield tmp_path
    assert (tmp_path / "b.ply").read_bytes() == b"old"
    assert {"b.ply"} <= set(os.listdir(tmp_path)) <= {"a.ply", "b.ply"}


@pytest.mark.parametrize("at", PASSES)
def test_an_interrupt_leaves_what_was_there(small, limited, folder, at):
    with pytest.raises(KeyboardInterrupt):
        attempt(folder, limited, at, interrupt)


CHANGES = {
    "cut": lambda path: os.truncate(path, path.stat().st_size // 2),
    "gone": lambda path: path.unlink(),
    "written": lambda path: os.utime(path, ns=(1, 1)),  # a clock may be too coarse to tell
    "replaced": lambda path: read.write_mesh(path, terrain(12)),
}


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("at", PASSES[:-2])
def test_a_file_that_changes_is_noticed(small, limited, folder, at, change):
    with pytest.raises(read.FileError, match=r"a.ply: (changed|truncated|no such|cannot)") as error:
        attempt(folder, limited, at, lambda: CHANGES[change](folder / "a.ply"))
    assert "\n" not in str(error.value)


@pytest.mark.skipif(sys.platform == "win32", reason="limits of a process")
@pytest.mark.parametrize("most", [0, 300, 1000], ids=["nothing", "left", "output"])
def test_a_full_disk_leaves_what_was_there(small, limited, folder, most):
    import resource

    before = resource.getrlimit(resource.RLIMIT_FSIZE)

    def fill():
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, before[1]))

    attempt(
        folder, limited, "cells", lambda: None
    )  # kernels are compiled before they cannot be kept
    (folder / "b.ply").write_bytes(b"old")
    try:
        with pytest.raises(read.FileError, match=r"b.ply: cannot be written: File too large"):
            attempt(folder, limited, "cells", fill)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_shares_of_the_work_rise_from_nothing_to_all(small, limited, tmp_path):
    read.write_mesh(tmp_path / "a.ply", terrain(24))
    said = []
    simplify_file(
        tmp_path / "a.ply", tmp_path / "b.ply", target_count=200, memory="64M", device=limited,
        told=lambda what, share: said.append((what, share)),
    )  # fmt: skip
    shares = [share for _, share in said]
    assert shares == sorted(shares) and (shares[0], shares[-1]) == (0, 1)
    assert tuple(dict.fromkeys(what for what, _ in said)) == PASSES


def test_a_file_may_be_replaced_by_its_own_result(small, limited, tmp_path):
    read.write_mesh(tmp_path / "a.ply", terrain(12))
    attempt(tmp_path, limited)
    simplify_file(
        tmp_path / "a.ply", tmp_path / "a.ply", target_count=60, memory="64M", device=limited
    )
    assert (tmp_path / "a.ply").read_bytes() == (tmp_path / "b.ply").read_bytes()


KILLED = """
import importlib, os, signal, sys
streaming = importlib.import_module("lodbench.kernels.cluster.streaming")
importlib.import_module("lodbench.kernels.simplify_file").fits = lambda source, allowed: False
tell = streaming._Shares.__call__
def told(self, name, share):
    if name == "{at}":
        os.kill(os.getpid(), signal.{name})
    tell(self, name, share)
streaming._Shares.__call__ = told
sys.argv = ["lodbench", "simplify", "a.ply", "b.ply", "-c", "9", "--memory", "64M"]
import runpy
runpy.run_module("lodbench.harness", run_name="__main__")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
@pytest.mark.parametrize(
    ("name", "at", "code", "word"),
    [("SIGINT", "triangles", 130, "interrupted"), ("SIGTERM", "borders", 143, "terminated")],
)
def test_a_signal_ends_the_command_with_one_line(tmp_path, name, at, code, word):
    read.write_mesh(tmp_path / "a.ply", terrain(12))
    (tmp_path / "b.ply").write_bytes(b"old")
    done = subprocess.run(
        [sys.executable, "-c", KILLED.format(at=at, name=name)], cwd=tmp_path, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr.splitlines()[-1]) == (code, f"stopped: {word}")
    assert "Traceback" not in done.stderr
    assert (tmp_path / "b.ply").read_bytes() == b"old"
    assert sorted(os.listdir(tmp_path)) == ["a.ply", "b.ply"]


@pytest.mark.skipif(sys.platform != "linux", reason="the peak is read from /proc")
@pytest.mark.parametrize("make", [torus, lambda *sizes: scattered(torus(*sizes))], ids=["", "far"])
def test_peak_memory_stays_below_the_limit(tmp_path, make):
    source = tmp_path / "a.ply"
    mesh = make(800, 500)
    read.write_mesh(
        source, replace(mesh, normals=mesh.positions, colours=np.abs(mesh.positions) / 4)
    )
    assert not streaming.fits(source, MINIMUM)
    rise = peak_bytes(source, tmp_path / "b.ply", "64M", {"cells": 90})
    assert 1 << 20 < rise < MINIMUM
    assert read.read_mesh(tmp_path / "b.ply").triangle_count > 1000


def test_the_command_streams_and_says_so(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(streaming, "fits", lambda source, allowed: False)
    read.write_mesh(tmp_path / "a.ply", catalogue.load("torus_2k").surface)
    words = [
        "simplify",
        str(tmp_path / "a.ply"),
        str(tmp_path / "b.ply"),
        "--cells",
        "9",
        "-s",
        "attributes=false",
    ]
    assert main([*words, "--memory", "64M"]) == 0
    said = capsys.readouterr()
    assert said.err.splitlines() == [
        f"note: {tmp_path / 'b.ply'} lacks what the input has: normals"
    ]
    streamed = (tmp_path / "b.ply").read_bytes()
    assert main([*words, "-q"]) == 0
    assert (tmp_path / "b.ply").read_bytes() == streamed
    assert main([*words, "--memory", "1M"]) == 2
    assert capsys.readouterr().err.splitlines()[-1].endswith("expected at least 64M, got '1M'")
    assert main(["simplify", "-", str(tmp_path / "b.ply"), "-c", "9", "--memory", "64M"]) == 2
    assert "IN: expected a file with --memory" in capsys.readouterr().err
