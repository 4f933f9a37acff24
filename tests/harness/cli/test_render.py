import json

import numpy as np
import pytest

from lodbench.datasets_gen import patches
from lodbench.datasets_gen.read import write_mesh
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.cli.app import main
from lodbench.kernels.render import render


@pytest.fixture
def mesh(tmp_path):
    path = tmp_path / "sphere.ply"
    write_mesh(path, icosphere(2))
    return path


def test_render_writes_a_picture(mesh, tmp_path, capsys):
    out = tmp_path / "sphere.png"
    words = ["--size", "64x48", "--camera", "200,-10", "--color", "triangle", "--wireframe"]
    assert main(["render", str(mesh), str(out), *words, "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["width"], facts["height"], facts["triangles_in"]) == (64, 48, 320)
    from PIL import Image

    assert Image.open(out).size == (64, 48)


@pytest.mark.parametrize(
    ("words", "options"),
    [
        ([], {}),
        (["--cull"], {"cull": True}),
        (["--wireframe"], {"wireframe": True}),
        (["--up", "z"], {"up": "z"}),
        (["--colour", "flat"], {"colour": "flat"}),
        (["--camera", "70,-40"], {"camera": (70.0, -40.0)}),
    ],
)
def test_render_draws_what_its_options_say(tmp_path, device, words, options):
    from PIL import Image

    bowl = TriangleMesh(icosphere(2).positions, icosphere(2).triangles[::2])
    write_mesh(tmp_path / "bowl.ply", bowl)
    out = tmp_path / "bowl.png"
    size = ["--size", "64x48", "--quiet"]
    assert main(["render", str(tmp_path / "bowl.ply"), str(out), *size, *words]) == 0
    expected = render(bowl, size=(64, 48), device=device, **options)
    assert np.array_equal(np.asarray(Image.open(out)), expected)
    assert not options or not np.array_equal(expected, render(bowl, size=(64, 48), device=device))


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["--size", "64"], "size: expected AxB, got '64'"),
        (["--size", "0x4"], "size: expected 1 to 16384"),
        (["--camera", "up"], "camera: expected A,B, got 'up'"),
        (["--colour", "blue"], "colour: expected one of smooth"),
        (["--up", "w"], "up: expected one of x, y, z"),
    ],
)
def test_render_refuses_wrong_words_with_one_line(mesh, tmp_path, capsys, words, text):
    assert main(["render", str(mesh), str(tmp_path / "out.png"), *words]) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert text in line
    assert not (tmp_path / "out.png").exists()


def test_gif_shows_a_full_turn(mesh, tmp_path, capsys):
    from PIL import Image

    for name, words, frames in (("a.gif", ["--turntable", "5"], 5), ("b.gif", [], 36)):
        out = tmp_path / name
        assert main(["render", str(mesh), str(out), "--size", "48x32", *words]) == 0
        with Image.open(out) as picture:
            assert (picture.size, picture.n_frames) == ((48, 32), frames)
            assert picture.info["loop"] == 0
    assert main(["render", str(mesh), str(tmp_path / "c.png"), "--turntable", "5"]) == 2
    assert "ends in .gif" in capsys.readouterr().err


def test_render_refuses_another_kind_of_file(mesh, tmp_path, capsys):
    assert main(["render", str(mesh), str(tmp_path / "out.jpg")]) == 2
    assert "ends in .png" in capsys.readouterr().err


def test_turntable_into_a_folder_is_a_file_for_each_picture(mesh, tmp_path, capsys):
    from PIL import Image

    out = tmp_path / "pictures" / "turn"
    words = ["--turntable", "3", "--size", "48x32", "--path", "fly_through"]
    assert main(["render", str(mesh), str(out), *words]) == 0
    assert sorted(path.name for path in out.iterdir()) == ["0000.png", "0001.png", "0002.png"]
    assert Image.open(out / "0001.png").size == (48, 32)
    assert main(["render", str(mesh), str(mesh / "turn"), *words]) == 2
    assert "OUT: expected a folder or a place for one" in capsys.readouterr().err


def test_render_refines_anew_for_each_picture(mesh, tmp_path, capsys):
    from PIL import Image

    out = tmp_path / "lod.gif"
    words = ["--path", "orbit", "--refine", "adaptive_patterns", "-s", "by=screen"]
    assert main(["render", str(mesh), str(out), "--turntable", "4", "--size", "48x32", *words]) == 0
    with Image.open(out) as picture:
        assert picture.n_frames == 4
    assert main(["render", str(mesh), str(out), "-s", "by=screen"]) == 2
    assert "by: expected with refine" in capsys.readouterr().err


def test_render_tessellates_patches_anew_for_each_picture(tmp_path, capsys):
    from PIL import Image

    out, small = tmp_path / "pot.gif", ["--size", "48x32", "--turntable", "3"]
    words = ["--path", "orbit", "--level", "4", "-s", "by=screen"]
    assert main(["render", "pot_32", str(out), *small, *words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["patches"] == 32
    with Image.open(out) as picture:
        assert picture.n_frames == 3
    assert main(["render", "rational_ball", str(tmp_path / "ball.png"), "--size", "48x32"]) == 0
    assert "1 surfaces" in capsys.readouterr().out


def test_render_reads_patches_from_files(tmp_path, device):
    from PIL import Image

    np.savez(tmp_path / "pot.npz", patches=patches.pot(8).points)
    for words, options in (
        ([], {"level": 3}),
        (["--refine", "dabt", "-s", "test=mean"], {"level": 3, "refine": "dabt", "test": "mean"}),
    ):
        out = tmp_path / "pot.png"
        own = ["--level", "3", "--size", "64x48", "--up", "z", "--quiet", *words]
        assert main(["render", str(tmp_path / "pot.npz"), str(out), *own]) == 0
        expected = render(patches.pot(8), size=(64, 48), up="z", device=device, **options)
        assert np.array_equal(np.asarray(Image.open(out)), expected)


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (
            ["icosphere_2", "--level", "3"],
            "--level: expected patches or NURBS surfaces, got a mesh",
        ),
        (["pot_32", "--level", "30"], "level: expected 0 to 10, got 30"),
        (["pot_32", "--refine", "pattern"], "method: expected one of"),
        (["pot_32", "-s", "segments=3"], "segments"),
        (["pot_32", "--colour", "vertex"], "colour: expected a mesh with vertex colours"),
        (["none.bpt"], "none.bpt: no such file"),
    ],
)
def test_render_of_patches_refuses_with_one_line(tmp_path, capsys, words, text):
    source, *options = words
    assert main(["render", source, str(tmp_path / "out.png"), *options]) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert text in line
