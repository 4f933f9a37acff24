from collections import OrderedDict

import numpy as np
import pytest

from lodbench.datasets_gen import catalogue, standard, triangles
from lodbench.datasets_gen.read import FileError, write_mesh
from lodbench.datasets_gen.surfaces import BezierPatches, NurbsModel, TriangleMesh
from tests.datasets_gen.topology import topology

CLASSES = {"triangles": TriangleMesh, "patches": BezierPatches, "nurbs": NurbsModel}


@pytest.fixture
def nowhere(tmp_path, monkeypatch):
    """No data folder and an empty cache; what is made there is found."""
    monkeypatch.delenv("LODBENCH_DATA", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "lodbench" / "data"


def small(facts):
    return (facts["triangles"] or 0) < 200_000


def test_every_generated_dataset_is_what_its_facts_say(nowhere):
    for name, facts in catalogue.describe().items():
        if not small(facts):
            continue
        entry = catalogue.load(name)
        assert (entry.name, entry.kind) == (name, facts["kind"])
        assert isinstance(entry.surface, CLASSES[entry.kind]), name
        if facts["triangles"] is not None:
            assert entry.surface.triangle_count == facts["triangles"], name
        assert facts["source"] == "generated" and facts["note"]


def test_sizes_are_near_those_of_the_names(nowhere):
    facts = catalogue.describe()
    assert facts["sphere_10"]["triangles"] == 10
    assert facts["displaced_icosphere_1310k"]["triangles"] == 1_310_720
    assert facts["displaced_icosphere_10m"]["triangles"] == pytest.approx(10_000_000, rel=0.01)
    for shape in standard.SHAPES:
        for wanted in (10_000, 54_321):
            count = catalogue.find(f"{shape}_{wanted}").triangles
            assert count is None or count == pytest.approx(wanted, rel=0.25), shape


def test_first_names_are_small_ones_of_each_kind(nowhere):
    first = [catalogue.find(name) for name in catalogue.names()[:3]]
    assert [entry.kind for entry in first] == ["triangles", "patches", "nurbs"]
    assert all(small({"triangles": entry.triangles}) for entry in first)


def test_names_can_be_asked_by_kind(nowhere):
    everything = catalogue.names()
    assert len(everything) == len(set(everything))
    assert sorted(everything) == sorted(n for kind in CLASSES for n in catalogue.names(kind))
    with pytest.raises(ValueError, match="kind: expected one of"):
        catalogue.names("voxels")


def test_any_size_of_a_shape_can_be_asked_for(nowhere):
    assert catalogue.load("torus_250").surface.triangle_count == 256
    assert catalogue.load("displaced_icosphere_2k").surface.triangle_count == 2000
    assert catalogue.find("terrain_3m").triangles == pytest.approx(3_000_000, rel=0.01)


def test_sorted_is_the_same_surface_under_its_own_name(nowhere):
    plain, by_place = (catalogue.load(f"displaced_icosphere_2k{s}") for s in ("", "_sorted"))
    assert by_place.name == "displaced_icosphere_2k_sorted"
    assert topology(by_place.surface).volume == pytest.approx(topology(plain.surface).volume)
    assert not np.array_equal(by_place.surface.triangles, plain.surface.triangles)
    write_mesh_into(nowhere, "real", triangles.torus(9, 5))
    assert catalogue.load("real_sorted").surface.triangle_count == 90


def write_mesh_into(folder, name, mesh):
    (folder / "meshes").mkdir(parents=True, exist_ok=True)
    write_mesh(folder / "meshes" / f"{name}.ply", mesh)


@pytest.mark.parametrize(
    "scan, euler, closed",
    [
        ("bunny_69k", 2 - 5, False),
        ("armadillo_86k", 2, True),
        ("dragon_100k", 0, True),
        ("buddha_100k", 2 - 12, True),
        ("mountain_od", 1, False),
        ("fandisk", 2, True),
    ],
)
def test_standin_is_of_like_size_and_topology(nowhere, scan, euler, closed):
    entry = catalogue.load(scan, standin_ok=True)
    assert entry.name == f"{scan}_standin" and entry.standin
    assert scan in entry.note
    found = topology(entry.surface)
    assert (found.euler, found.border == 0, found.repeated) == (euler, closed, 0)
    published = {
        "bunny_69k": 69_451,
        "armadillo_86k": 86_482,
        "mountain_od": 50_562,
        "fandisk": 12_946,
    }
    expected = published.get(scan, 100_000)
    assert entry.surface.triangle_count == pytest.approx(expected, rel=0.06)


def test_scan_that_is_there_is_no_standin(nowhere):
    with pytest.raises(
        ValueError, match=r"bunny_69k is not in the data folder.*fetch.*standin"
    ) as caught:
        catalogue.load("bunny_69k")
    assert "\n" not in str(caught.value)
    write_mesh_into(nowhere, "bunny_69k", triangles.torus(9, 5))
    entry = catalogue.load("bunny_69k", standin_ok=True)
    assert (entry.name, entry.standin, entry.triangles) == ("bunny_69k", False, 90)
    assert entry.surface.triangle_count == 90
    assert {"bunny_69k", "bunny_69k_standin"} <= set(catalogue.names("triangles"))
    assert catalogue.load("bunny_69k_standin").standin


def test_data_folder_goes_before_the_cache(nowhere, tmp_path, monkeypatch):
    write_mesh_into(nowhere, "same", triangles.torus(9, 5))
    write_mesh_into(tmp_path / "given", "same", triangles.torus(4, 4))
    assert catalogue.load("same").surface.triangle_count == 90
    monkeypatch.setenv("LODBENCH_DATA", str(tmp_path / "given"))
    assert catalogue.load("same").surface.triangle_count == 32
    monkeypatch.setenv("LODBENCH_DATA", str(tmp_path / "not there"))
    assert catalogue.load("same").surface.triangle_count == 90


def test_broken_file_is_listed_and_its_loading_says_why(nowhere):
    (nowhere / "meshes").mkdir(parents=True)
    (nowhere / "meshes" / "broken.ply").write_bytes(b"ply\n")
    assert catalogue.describe()["broken"]["triangles"] is None
    with pytest.raises(FileError, match="truncated"):
        catalogue.load("broken")


@pytest.mark.parametrize(
    "name, close", [("bunny_68k_standin", "bunny_69k_standin"), ("tours_20k", "torus_20k")]
)
def test_unknown_name_is_refused_with_the_closest(nowhere, name, close):
    with pytest.raises(ValueError, match=f"dataset: expected .* got '{name}'; closest: .*{close}"):
        catalogue.load(name)


@pytest.mark.parametrize("name", ["", "x", "torus", "torus_0", "torus_20g", "icosphere_11", "cube_20k",
                                  "pot_32_sorted", "x_standin", "torus_900m", "../torus_20k"])  # fmt: skip
def test_names_that_say_nothing_are_refused(nowhere, name):
    with pytest.raises(ValueError, match=r"^dataset: expected"):
        catalogue.find(name)


def test_loading_again_gives_the_same_object_until_memory_is_short(nowhere, monkeypatch):
    monkeypatch.setattr(catalogue, "_kept", OrderedDict())
    first = catalogue.load("torus_20k").surface
    assert catalogue.load("torus_20k").surface is first
    monkeypatch.setattr(catalogue, "_KEPT_BYTES", 1)
    catalogue.load("sphere_10")
    assert catalogue.load("torus_20k").surface is not first


def test_real_models_are_found_by_name(data_folder):
    facts = catalogue.describe()
    assert facts["bunny_69k"]["triangles"] == 69_451
    assert (facts["teapot"]["kind"], facts["killeroo"]["kind"]) == ("patches", "nurbs")
    for name in ("bunny_69k", "teapot", "killeroo", "soup"):
        assert isinstance(catalogue.load(name).surface, CLASSES[facts[name]["kind"]])
