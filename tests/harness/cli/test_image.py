import json

import numpy as np
import pytest

from lodbench.datasets_gen.images import read_geometry_image
from lodbench.datasets_gen.read import write_mesh
from lodbench.datasets_gen.triangles import icosphere, torus
from lodbench.harness.cli.app import main


@pytest.fixture(autouse=True)
def own_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("LODBENCH_CACHE", str(tmp_path / "cache"))


@pytest.fixture
def mesh(tmp_path):
    path = tmp_path / "sphere.ply"
    write_mesh(path, icosphere(2))
    return path


def test_geometry_image_is_written_with_its_pictures(mesh, tmp_path, capsys):
    out = tmp_path / "sphere.npz"
    assert main(["geometry-image", str(mesh), str(out), "--level", "4", "--png", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["side"], facts["triangles_in"], facts["flipped"]) == (17, 320, 0)
    image = read_geometry_image(out)
    assert np.allclose(np.linalg.norm(image.positions, axis=-1), 1, atol=0.05)
    from PIL import Image

    assert Image.open(tmp_path / "sphere.png").size == (17, 17)
    assert Image.open(tmp_path / "sphere_normals.png").size == (17, 17)


def test_geometry_image_is_simplified_and_drawn_from_its_file(mesh, tmp_path, capsys):
    image = tmp_path / "sphere.npz"
    assert main(["geometry-image", str(mesh), str(image), "-n", "4", "--quiet"]) == 0
    out = tmp_path / "small.ply"
    assert main(["simplify", str(image), str(out), "-n", "100", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["triangles_in"], facts["vertices_in"]) == (512, 258)
    assert 8 <= facts["triangles_out"] <= 100
    assert main(["render", str(image), str(tmp_path / "a.png"), "--size", "64x64", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["triangles_in"] == 512
    words = ["simplify", str(image), str(out), "-n", "100", "-m", "quadric_clustering"]
    assert main(words) == 2
    assert "expected quadtree_lod for a GeometryImage" in capsys.readouterr().err


def test_geometry_image_says_what_it_does_and_uses_its_cache(mesh, tmp_path, capsys):
    words = ["geometry-image", str(mesh), str(tmp_path / "a.npz"), "-n", "3"]
    assert main(words) == 0
    first = capsys.readouterr()
    assert "parameterisation" in first.err
    assert "320 triangles as 9 x 9 samples" in first.out
    assert main(words) == 0
    assert "sphere from cache" in capsys.readouterr().out


def test_geometry_image_without_a_cache_neither_leaves_nor_takes_one(mesh, tmp_path, capsys):
    words = ["geometry-image", str(mesh), str(tmp_path / "a.npz"), "-n", "3", "--json"]
    assert main([*words, "--no-cache"]) == 0
    assert not list((tmp_path / "cache").rglob("*.npz"))
    assert main(words) == 0
    assert list((tmp_path / "cache").rglob("*.npz"))
    capsys.readouterr()
    assert main([*words, "--no-cache"]) == 0
    assert not json.loads(capsys.readouterr().out)["from_cache"]


def test_geometry_image_refuses_a_torus_with_one_line(tmp_path, capsys):
    path = tmp_path / "torus.ply"
    write_mesh(path, torus(12, 8))
    assert main(["geometry-image", str(path), str(tmp_path / "a.npz"), "--quiet"]) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert "Euler number 0" in line
    assert not (tmp_path / "a.npz").exists()


def test_geometry_image_refuses_another_kind_of_file(mesh, tmp_path, capsys):
    assert main(["geometry-image", str(mesh), str(tmp_path / "a.png")]) == 2
    assert "ends in .npz" in capsys.readouterr().err
