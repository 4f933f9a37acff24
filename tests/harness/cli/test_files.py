import io
import json
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from lodbench.datasets_gen.catalogue import load
from lodbench.datasets_gen.images import read_geometry_image
from lodbench.datasets_gen.read import mesh_bytes, parse_mesh, read_mesh, write_mesh
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, plane, torus
from lodbench.harness.cli.app import main
from lodbench.kernels import refine_mesh, simplify_mesh

TORUS = torus(24, 12)
MAP = np.array((4e5, 5e6, 100.0))


@pytest.fixture
def piped(monkeypatch, capfdbinary):
    """Runs a command with bytes on standard input; gives its exit code, standard output and error."""

    def run(data, *words):
        stdin = SimpleNamespace(buffer=io.BytesIO(data), isatty=lambda: False)
        monkeypatch.setattr(sys, "stdin", stdin)
        code = main([str(word) for word in words])
        captured = capfdbinary.readouterr()
        return code, captured.out, captured.err.decode()

    return run


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".stl", ".off", ".gltf", ".glb"])
def test_meshes_go_through_a_pipe(piped, tmp_path, suffix):
    words = ["refine", "-", "-", "--segments", "2", "--format", suffix[1:]]
    code, out, said = piped(mesh_bytes(TORUS, suffix), *words)
    assert code == 0, said
    refined = parse_mesh(out, tmp_path / f"out{suffix}")
    assert refined.triangle_count == 4 * TORUS.triangle_count
    assert "-: 576 -> 2,304 triangles" in said


def test_standard_output_is_ply_and_says_its_facts_beside_it(piped, tmp_path):
    words = ["simplify", "-", "-", "-r", "0.5", "--json"]
    code, out, said = piped(mesh_bytes(TORUS, ".ply"), *words)
    assert code == 0
    facts = json.loads(said)
    assert facts["triangles_out"] == parse_mesh(out, tmp_path / "out.ply").triangle_count
    assert (facts["carried"], facts["lost"]) == (["normals"], [])


def test_pictures_and_geometry_images_go_through_a_pipe(piped, tmp_path):
    code, out, _ = piped(mesh_bytes(TORUS, ".obj"), "render", "-", "-", "--size", "64x48")
    assert code == 0
    from PIL import Image

    assert Image.open(io.BytesIO(out)).size == (64, 48)
    ball = mesh_bytes(icosphere(1), ".off")
    code, out, _ = piped(ball, "geometry-image", "-", "-", "-n", "3", "--no-cache", "-q")
    assert code == 0
    assert read_geometry_image("image.npz", out).positions.shape == (9, 9, 3)
    code, out, said = piped(out, "simplify", "-", "-", "-n", "50", "-q")
    assert code == 0, said
    assert 0 < parse_mesh(out, tmp_path / "out.ply").triangle_count <= 50


def test_refine_does_what_its_options_say(tmp_path, device):
    coarse, out = tmp_path / "coarse.ply", tmp_path / "fine.ply"
    write_mesh(coarse, TORUS)
    for words, options in (
        (["--segments", "3"], {"segments": 3}),
        (["--no-weld"], {"weld": False}),
        (["--displace", "0.02"], {"amplitude": 0.02, "waves": 8.0}),
        (["--displace", "0.02,3"], {"amplitude": 0.02, "waves": 3.0}),
        (
            ["--displace", "perlin:0.03,5"],
            {"displacement": "perlin", "amplitude": 0.03, "waves": 5.0},
        ),
    ):
        assert main(["refine", str(coarse), str(out), "--quiet", *words]) == 0
        found, expected = read_mesh(out), refine_mesh(device, TORUS, **options).mesh
        assert np.array_equal(found.positions, expected.positions), words
        assert np.array_equal(found.triangles, expected.triangles), words


def test_a_dataset_is_written_to_standard_output(piped, tmp_path):
    code, out, said = piped(b"", "datasets", "make", "torus_500", "-")
    assert code == 0 and said.startswith("-: ")
    assert parse_mesh(out, tmp_path / "out.ply").triangle_count > 400


@pytest.mark.parametrize(
    ("data", "words", "text"),
    [
        (b"", ["simplify", "-", "-", "-n", "5"], "on standard input, got nothing"),
        (b"hello", ["refine", "-", "-"], "expected a mesh or NPZ on standard input, got b'hello'"),
        (b"ply\n", ["refine", "-", "-"], "<stdin>.ply: truncated"),
        (b"ply\n", ["refine", "-", "-", "--format", "fbx"], "format: expected one of ply, obj"),
        (b"", ["geometry-image", "-", "-", "--png"], "png: expected OUT to be a file"),
    ],
)
def test_what_is_wrong_with_a_pipe_is_one_line(piped, data, words, text):
    code, out, said = piped(data, *words)
    assert code == 2 and out == b""
    assert said.count("\n") == 1 and text in said


def test_terminals_are_refused(monkeypatch, capsys):
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(isatty=lambda: True))
    assert main(["render", "-", "out.png"]) == 2
    assert "got a terminal" in capsys.readouterr().err


def test_a_real_pipe_between_two_commands(tmp_path):
    lodbench = [sys.executable, "-m", "lodbench.harness"]
    made = subprocess.run(
        [*lodbench, "datasets", "make", "torus_500", "-"], capture_output=True, check=True
    )
    out = tmp_path / "out.obj"
    subprocess.run(
        [*lodbench, "datasets", "make", "torus_500", str(out)], check=True, capture_output=True
    )
    piped_mesh, written = parse_mesh(made.stdout, tmp_path / "a.ply"), read_mesh(out)
    assert np.array_equal(piped_mesh.positions, written.positions)


def test_format_says_what_the_suffix_does_not(tmp_path, capsys):
    write_mesh(tmp_path / "in.ply", TORUS)
    words = ["simplify", str(tmp_path / "in.ply"), str(tmp_path / "out"), "-r", "0.5"]
    assert main(words) == 2
    assert main([*words, "--format", "OFF"]) == 0
    assert (tmp_path / "out").read_bytes().startswith(b"OFF")


def test_what_the_output_lacks_is_named(tmp_path, capsys):
    colours = np.abs(TORUS.positions % 1)
    painted = TriangleMesh(TORUS.positions, TORUS.triangles, TORUS.normals, colours=colours)
    write_mesh(tmp_path / "in.ply", painted)

    def said(verb, out, *words):
        assert main([verb, str(tmp_path / "in.ply"), str(tmp_path / out), *words]) == 0
        return capsys.readouterr().err

    expected = f"note: {tmp_path / 'a.ply'} lacks what the input has: normals, colours\n"
    assert said("simplify", "a.ply", "-r", "0.5", "-q", "-s", "attributes=false") == expected
    assert said("simplify", "a.ply", "-r", "0.5", "-q") == ""
    assert said("refine", "a.ply", "--segments", "1") == ""
    assert said("refine", "a.obj", "--segments", "1") == ""
    assert said("refine", "a.stl", "--segments", "1").endswith(": normals, colours\n")


def test_what_a_mesh_does_not_take_is_named_too(tmp_path, capsys):
    text = "mtllib a.mtl\no a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl b\nf 1/1 2/1 3/1\n"
    (tmp_path / "a.obj").write_text(text)
    words = ["refine", str(tmp_path / "a.obj"), str(tmp_path / "out.ply"), "--json"]
    assert main(words) == 0
    captured = capsys.readouterr()
    assert json.loads(captured.out)["carried"] == ["normals", "uvs"]
    assert json.loads(captured.out)["lost"] == ["materials", "groups"]
    assert captured.err.endswith("lacks what the input has: materials, groups\n")


@pytest.mark.parametrize("form", ["ply", "obj", "glb", "gltf"])
def test_simplify_carries_attributes_from_file_to_file(tmp_path, capsys, form):
    sheet = plane(20)
    painted = TriangleMesh(
        sheet.positions, sheet.triangles, sheet.normals, sheet.uvs, sheet.positions * 0.6
    )
    write_mesh(tmp_path / "in.obj", painted)
    source, out = str(tmp_path / "in.obj"), str(tmp_path / f"out.{form}")
    assert main(["simplify", source, out, "-n", "60", "--json"]) == 0
    captured = capsys.readouterr()
    facts = json.loads(captured.out)
    assert facts["carried"] == ["normals", "uvs", "colours"]
    assert facts["lost"] == [] and captured.err == ""
    assert facts["counters"]["split_vertices"] == 0
    result = read_mesh(out)
    assert np.abs(result.normals - (0, 0, 1)).max() < 1e-6
    inner = (
        np.abs(result.positions[:, :2] - 0.5).max(axis=1) < 0.4
    )  # the rest of a cell is cut away
    assert np.abs(result.uvs - result.positions[:, :2])[inner].max() < 0.1
    assert np.abs(result.colours - result.uvs @ (np.eye(2, 3) * 0.6)).max() < 3 / 255


def test_map_coordinates_go_through_the_shell(tmp_path, capsys):
    far = TriangleMesh(TORUS.positions + MAP, TORUS.triangles)
    for suffix in (".ply", ".obj", ".stl", ".off", ".gltf", ".glb"):
        source, out = tmp_path / f"in{suffix}", tmp_path / f"out{suffix}"
        write_mesh(source, far)
        assert main(["refine", str(source), str(out), "--segments", "1", "-q"]) == 0
        result = read_mesh(out)
        assert result.triangle_count == far.triangle_count
        centres = (result.points[result.triangles] - MAP).mean(axis=1)  # triangles may be turned
        expected = TORUS.positions[TORUS.triangles].mean(axis=1)
        assert np.abs(centres - expected).max() < 1e-6, suffix


def test_vertex_colours_are_drawn_or_asked_for(tmp_path, capsys):
    write_mesh(tmp_path / "plain.ply", TORUS)
    out = tmp_path / "out.png"
    words = ["--colour", "vertex", "--size", "64x48"]
    assert main(["render", str(tmp_path / "plain.ply"), str(out), *words]) == 2
    assert "colour: expected a mesh with vertex colours" in capsys.readouterr().err
    assert not out.exists()
    red = np.tile((1.0, 0.0, 0.0), (TORUS.vertex_count, 1))
    write_mesh(tmp_path / "red.ply", TriangleMesh(TORUS.positions, TORUS.triangles, colours=red))
    assert main(["render", str(tmp_path / "red.ply"), str(out), *words]) == 0
    from PIL import Image

    image = np.asarray(Image.open(out)).astype(int)
    assert ((image[..., 0] - image[..., 1]) > 60).mean() > 0.05


def test_refine_says_where_cracks_open(tmp_path, capsys):
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0.5], [0, 1, 0]]
    write_mesh(tmp_path / "hinge.ply", TriangleMesh(points, [[0, 1, 2], [3, 4, 5]]))
    source, out = str(tmp_path / "hinge.ply"), str(tmp_path / "out.ply")
    for method, said in (("pn_triangles", True), ("pattern", False)):
        assert main(["refine", source, out, "--method", method]) == 0
        assert ("normals are split along 1 edges" in capsys.readouterr().err) == said


def chain_words(out, *more):
    return [
        "simplify",
        "torus_2k",
        str(out),
        "-c",
        "20",
        "-m",
        "level_chain",
        "-s",
        "levels=3",
        *more,
    ]


def test_levels_are_written_as_numbered_files(tmp_path, capsys, device):
    assert main(chain_words(tmp_path / "out.ply")) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"out_{k}.ply" for k in range(3)]
    said = capsys.readouterr().out
    expected = simplify_mesh(
        device, load("torus_2k").surface, cells=20, method="level_chain", levels=3
    )
    for number, level in enumerate(expected.levels):
        found = read_mesh(tmp_path / f"out_{number}.ply")
        assert np.array_equal(found.triangles, level.triangles)
        assert np.array_equal(found.positions, level.positions)
        assert f"out_{number}.ply: " in said
    main(chain_words(tmp_path / "one.ply", "-s", "levels=1"))
    assert (tmp_path / "one.ply").is_file()


def test_levels_are_one_file_of_gltf_and_glb(tmp_path, capsys):
    for suffix in (".glb", ".gltf"):
        path = tmp_path / f"out{suffix}"
        assert main(chain_words(path, "--json")) == 0
        facts = json.loads(capsys.readouterr().out)
        counts = [level["triangles"] for level in facts["levels"]]
        assert {level["out"] for level in facts["levels"]} == {str(path)}
        assert facts["triangles_out"] == counts[0] > counts[1] > counts[2]
        assert read_mesh(path).triangle_count == counts[0], "readers see the finest"


def test_levels_leave_nothing_where_one_cannot_be_written(piped, tmp_path):
    (tmp_path / "out_2.ply").mkdir()
    code, _, said = piped(b"", *chain_words(tmp_path / "out.ply"))
    assert code != 0
    assert "out_2.ply: expected a file to write" in said
    assert [path.name for path in tmp_path.iterdir()] == ["out_2.ply"]
    code, out, said = piped(b"", *chain_words("-"))
    assert (code != 0, out) == (True, b"")
    assert "OUT: expected a file's name, or --format glb, for 3 levels, got -" in said
    code, out, _ = piped(b"", *chain_words("-", "--format", "glb"))
    assert code == 0
    assert out[:4] == b"glTF"


def test_the_largest_distance_is_asked_for_in_the_shell(tmp_path, capsys):
    given, out = tmp_path / "ball.ply", tmp_path / "near.ply"
    write_mesh(given, icosphere(3))
    words = [
        "simplify",
        str(given),
        str(out),
        "-m",
        "edge_collapse",
        "--max-error",
        "0.01",
        "--json",
    ]
    assert main(words) == 0
    assert json.loads(capsys.readouterr().out)["triangles_out"] < 900
    assert main([*words, "-n", "1000"]) == 0
    assert json.loads(capsys.readouterr().out)["triangles_out"] == 1000
