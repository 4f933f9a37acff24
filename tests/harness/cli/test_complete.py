import os
import subprocess
import sys
from typing import get_args, get_type_hints

import pytest

from lodbench.datasets_gen import catalogue, names, standard
from lodbench.harness.cli import complete
from lodbench.harness.cli.app import main
from lodbench.harness.plan import registry
from lodbench.harness.plan.table import tables
from lodbench.kernels.geometry_image.parameterisation import MODES
from lodbench.kernels.refine.params import RefineParams
from lodbench.kernels.render import COLOURS
from lodbench.kernels.stages.paths import CameraPath


@pytest.fixture
def offered(monkeypatch, capfd):
    """What the tab key offers after these words in bash."""

    def ask(*words):
        monkeypatch.setenv("_LODBENCH_COMPLETE", "complete_bash")
        monkeypatch.setenv("COMP_WORDS", " ".join(["lodbench", *words]))
        monkeypatch.setenv("COMP_CWORD", str(len(words)))
        with pytest.raises(SystemExit) as end:
            main([])
        assert end.value.code == 0
        return capfd.readouterr().out.split()

    return ask


@pytest.mark.parametrize(
    ("words", "name"),
    [
        (["run", "quadric"], "quadric_clustering"),
        (["run", "pattern", "-a", "static"], "static_vbo"),
        (["run", "pattern", "-d", "torus_2"], "torus_20k"),
        (["run", "pattern", "--case", "flat_1"], "flat_16"),
        (["run", "pattern", "--set", "seg"], "segments="),
        (["reproduce", "gmr"], "gmr05_figure7"),
        (["simplify", "icosphere_"], "icosphere_5"),
        (["simplify", "a.ply", "b.ply", "--method", "qua"], "quadric_clustering"),
        (["refine", "a.ply", "b.ply", "-m", "p"], "pattern"),
        (["tessellate", "a.bpt", "b.ply", "-m", "v"], "vst"),
        (["render", "a.ply", "b.png", "--colour", "wire"], "wireframe"),
        (["geometry-image", "a.ply", "b.npz", "--mode", "c"], "cmcf"),
        (["datasets", "make", "plane_2"], "plane_2k"),
        (["datasets", "fetch", "bun"], "bunny_69k"),
        (["simplify", "-", "-", "--format", "g"], "glb"),
    ],
)
def test_tab_key_offers_names(offered, words, name):
    found = offered(*words)
    assert name in found
    assert all(each.startswith(words[-1]) for each in found)


def test_tab_key_offers_devices(offered, device):
    assert device.facts.name.split()[0] in offered("run", "pattern", "--device", "")


def test_tab_key_offers_mesh_files_beside_datasets(offered, monkeypatch, tmp_path):
    (tmp_path / "torn.ply").touch()
    (tmp_path / "torn.txt").touch()
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("LODBENCH_DATA", raising=False)  # which may hold another torus
    assert offered("run", "pattern", "-d", "tor") == ["torus_1m", "torus_20k", "torn.ply"]


def test_unknown_system_has_no_cases_and_says_nothing(offered):
    assert offered("run", "nothing", "--case", "") == []


def test_names_are_those_of_the_registry_and_the_tables():
    found = registry.registry()
    assert sorted(complete.systems()) == sorted([*found.systems, *found.missing])
    assert set(complete.tables()) == set(tables())
    assert set(complete.colours()) == set(COLOURS)
    assert set(complete.modes()) == set(MODES)
    assert complete.paths() == get_args(get_type_hints(CameraPath)["kind"])
    kinds = get_type_hints(RefineParams)["displacement"]
    assert set(get_args(kinds)) - set(complete.DISPLACEMENTS) == {
        "height_map",
        "function",
    }  # by their files


def test_displacements_are_kinds_and_files(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    for name in ("bumps.cl", "bumps.png", "ball.ply"):
        (tmp_path / name).touch()
    assert complete.displacements() == ("sine:", "perlin:", "turbulence:", "bumps.cl", "bumps.png:")


def test_dataset_names_are_those_of_the_catalogue(monkeypatch, tmp_path):
    for path in ("meshes/one.ply", "meshes/two.txt", "nurbs/three.json", "bezier/four.bpt"):
        (tmp_path / path).parent.mkdir(exist_ok=True)
        (tmp_path / path).touch()
    monkeypatch.setenv("LODBENCH_DATA", str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "none"))
    assert names.standard_names() == sorted(catalogue.names())
    assert {"one", "three", "four"} <= set(names.standard_names())
    for listed, table in (
        (names.SCANS, standard.SCANS), (names.PATCHES, standard.PATCHES), (names.NURBS, standard.NURBS),
    ):  # fmt: skip
        assert listed == tuple(table)


@pytest.mark.parametrize("words", ["run q", "run pattern -d t", "reproduce d", "refine a b -m p"])
def test_tab_key_imports_nothing_heavy(words):
    environment = {
        **os.environ, "_LODBENCH_COMPLETE": "complete_bash", "COMP_WORDS": f"lodbench {words}",
        "COMP_CWORD": str(len(words.split())),
    }  # fmt: skip
    script = (
        "import sys, atexit\n"
        "atexit.register(lambda: print(*sorted(set(sys.modules) & {'numpy', 'trimesh', 'scipy', "
        "'pyopencl', 'matplotlib', 'rich.table'}), file=sys.stderr))\n"
        "from lodbench.harness.__main__ import main\nsys.exit(main())"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True
    )
    assert done.stdout.split()
    assert done.stderr.split() == []
