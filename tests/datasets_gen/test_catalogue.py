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
    monkeypatch.delenv("LODBENCH_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "lodbench" / "data"


def small(facts):
    return (facts["triangles"] or 0) < 200_000


def test_scene_is_so_many_copies_of_patches():
    one, five = (catalogue.load(name) for name in ("cup_26", "cup_26_x5"))
    assert (five.name, five.kind) == ("cup_26_x5", "patches")
    assert len(five.surface.points) == 5 * len(one.surface.points)
    assert catalogue.find("teapot_x2_standin").standin
    for name in ("torus_20k_x2", "cup_26_x0", "nothing_x2"):
        with pytest.raises(ValueError, match="expected a name"):
            catalogue.find(name)


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
    standins = [catalogue.find(f"bunny_69k_standin{s}").standin for s in ("", "_sorted")]
    assert standins == [True, True] and not by_place.standin, "sorted, it is a stand-in still"
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


@pytest.fixture
def own_file(tmp_path, monkeypatch):
    """Writes a mesh to a file of one's own; the names given to files do not outlive the test."""
    monkeypatch.setattr(catalogue, "_own", {})

    def write(name, mesh):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        write_mesh(path, mesh)
        return path

    return write


@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("Torso 2.PLY", "torso_2"),
        ("deep/er/mesh.obj", "mesh"),
        ("x/é.stl", "mesh"),
        ("A--b__C.off", "a_b_c"),
    ],
)
def test_file_of_ones_own_gets_a_safe_name(own_file, file, name):
    found = catalogue.adopt(own_file(file, triangles.icosphere(0)))
    assert found.name == name
    assert catalogue.find(name) == found
    assert found.surface.triangle_count == 20
    assert len(found.content) == 16


def test_files_of_one_name_keep_apart_by_their_content(own_file):
    ball = catalogue.adopt(own_file("a/mesh.ply", triangles.icosphere(0)))
    same = catalogue.adopt(own_file("b/mesh.ply", triangles.icosphere(0)))
    other = catalogue.adopt(own_file("c/mesh.ply", triangles.icosphere(1)))
    assert ball.name == same.name == "mesh"
    assert other.name == f"mesh_{other.content[:8]}"
    assert catalogue.find("mesh").surface.triangle_count == 20
    assert other.surface.triangle_count == 80


def test_file_does_not_take_the_name_of_a_dataset(own_file):
    found = catalogue.adopt(own_file("torus_20k.ply", triangles.icosphere(0)))
    assert found.name == f"torus_20k_{found.content[:8]}"
    assert catalogue.find("torus_20k").triangles == 20_164


def test_file_that_changed_is_another(own_file):
    before = catalogue.adopt(own_file("mesh.ply", triangles.icosphere(0)))
    after = catalogue.adopt(own_file("mesh.ply", triangles.icosphere(1)))
    assert after.name != before.name
    assert after.surface.triangle_count == 80


def test_file_of_ones_own_is_sorted_on_demand(own_file):
    path = own_file("ball.ply", triangles.icosphere(2))
    found = catalogue.adopt(f"{path}_sorted")
    assert found.name == "ball_sorted"
    assert found.content == catalogue.adopt(path).content
    assert found.surface.triangle_count == 320


@pytest.mark.parametrize(
    ("name", "is_file"),
    [
        ("torus_20k", False), ("torus_20k_sorted", False), ("scan.ply", True), ("./scan", True),
        ("scan.OBJ_sorted", True), ("a/b", True), ("odd.name", False),
    ],
)  # fmt: skip
def test_files_are_told_from_names(name, is_file):
    assert catalogue.is_file(name) == is_file


def test_file_that_is_not_there_or_no_mesh_is_refused(own_file, tmp_path):
    with pytest.raises(FileError, match="no such file"):
        catalogue.adopt(tmp_path / "nothing.ply")
    with pytest.raises(FileError, match="expected a suffix of"):
        catalogue.adopt(tmp_path / "nothing.txt")


def test_few_triangles_are_asked_about():
    assert catalogue.hint("torus_20") == "torus_20 has 36 triangles; was torus_20k meant?"
    assert catalogue.hint("terrain_2") == "terrain_2 has 2 triangles; was terrain_2k meant?"
    for name in (
        "torus_20k",
        "torus_500",
        "sphere_10",
        "icosphere_5",
        "torus_1m",
        "nothing_20",
        "spot",
    ):
        assert catalogue.hint(name) == ""


def test_unknown_name_brings_those_that_hold_it(nowhere):
    with pytest.raises(ValueError, match=r"closest: .*bunny_69k_standin"):
        catalogue.find("bunny")


def test_coarse_version_has_at_most_so_many_triangles_and_its_own_name(nowhere):
    for name in ("torus_20k_to_1k", "bunny_69k_to_500_standin"):
        found = catalogue.find(name)
        assert found.name == name
        assert found.standin == name.endswith("_standin")
        assert 0.9 < found.surface.triangle_count / (1000 if "1k" in name else 500) <= 1
    assert catalogue.find("icosphere_0_to_1k").surface.triangle_count == 20
    with pytest.raises(ValueError, match="dataset"):
        catalogue.find("nothing_to_1k")
