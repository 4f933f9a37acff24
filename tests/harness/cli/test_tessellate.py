import io
import json

import numpy as np
import pytest
import trimesh

from lodbench.datasets_gen import nurbs, patches
from lodbench.datasets_gen.read import read_mesh
from lodbench.harness.cli.app import main
from tests.datasets_gen.test_nurbs_files import step


@pytest.fixture
def cup(tmp_path):
    path = tmp_path / "cup.npz"
    np.savez(path, patches=patches.cup().points)
    return path


def bpt(path, points, degree="3 3"):
    rows = "".join(
        f"{degree}\n" + "".join(f"{p[0]!r} {p[1]!r} {p[2]!r}\n" for p in s.reshape(-1, 3).tolist())
        for s in points
    )
    path.write_text(f"{len(points)}\n{rows}")
    return path


def test_tessellate_writes_normals_and_says_what_it_made(cup, tmp_path, capsys):
    out = tmp_path / "cup.glb"
    assert main(["tessellate", str(cup), str(out), "--level", "3", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["patches"], facts["carried"]) == (26, ["normals"])
    mesh = read_mesh(out)
    assert mesh.triangle_count == facts["triangles_out"] == 26 * 128 - 4 * 8
    assert mesh.normals is not None


def test_tessellate_without_welding_or_normals(cup, tmp_path, capsys):
    out = tmp_path / "cup.ply"
    words = [
        "tessellate",
        str(cup),
        str(out),
        "-n",
        "1",
        "--no-weld",
        "-m",
        "vst",
        "-s",
        "normals=false",
    ]
    assert main(words) == 0
    assert "26 patches -> 208 triangles, 234 points" in capsys.readouterr().out
    assert read_mesh(out).normals is None


def test_tessellate_reads_bpt_and_datasets(tmp_path, capsys):
    file = bpt(tmp_path / "pot.bpt", patches.pot(8).points)
    made = []
    for k, name in enumerate((str(file), "pot_32")):
        made.append(tmp_path / f"{k}.ply")
        assert main(["tessellate", name, str(made[-1]), "--level", "2"]) == 0
    assert made[0].read_bytes() == made[1].read_bytes()


@pytest.mark.parametrize("kind", ["bpt", "npz"])
def test_tessellate_reads_standard_input(cup, tmp_path, capsys, monkeypatch, kind):
    out, expected = tmp_path / "a.ply", tmp_path / "b.ply"
    file = cup if kind == "npz" else bpt(tmp_path / "cup.bpt", patches.cup().points)
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(file.read_bytes())))
    assert main(["tessellate", "-", str(out), "-n", "2"]) == 0
    assert main(["tessellate", str(cup), str(expected), "-n", "2"]) == 0
    assert out.read_bytes() == expected.read_bytes()


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "<stdin>: expected a number of patches, got none"),
        (b"2\n3 3\n1 2 3\n", "<stdin>: expected 2 bicubic patches"),
        (b"1\n2 2\n" + b"1 2 3\n" * 9, "<stdin>: expected patches of degree 3 3, got 2 2"),
        (b"1\n3 3\n" + b"nan 2 3\n" * 16, "<stdin>: points: expected"),
        (b"PK\x03\x04 cut", "<stdin>: "),
    ],
)
def test_tessellate_says_in_one_line_what_is_wrong_with_standard_input(
    data, said, tmp_path, capsys, monkeypatch
):
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(data)))
    assert main(["tessellate", "-", str(tmp_path / "out.ply")]) == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1
    assert not (tmp_path / "out.ply").exists()


def test_tessellate_by_a_view_leaves_out_what_is_not_seen_so_large(cup, tmp_path, capsys):
    counts = []
    for words in ([], ["--view", "30,20", "-s", "pixels=40"], ["--view", "90,90,90"]):
        out = tmp_path / "out.ply"
        assert main(["tessellate", str(cup), str(out), "-n", "5", "--json", *words]) == 0
        counts.append(json.loads(capsys.readouterr().out)["triangles_out"])
    assert counts[0] > counts[1] > counts[2] > 0
    assert main(["tessellate", str(cup), str(tmp_path / "out.ply"), "--view", "30"]) == 2
    assert "view: expected AZIMUTH,ELEVATION or X,Y,Z of the eye" in capsys.readouterr().err


def test_tessellate_says_in_one_line_what_is_wrong(cup, tmp_path, capsys):
    points = patches.cup().points
    cut = tmp_path / "cut.bpt"
    cut.write_text("\n".join(bpt(tmp_path / "whole.bpt", points).read_text().split("\n")[:40]))
    bad = tmp_path / "bad.npz"
    np.savez(bad, patches=np.full((1, 4, 4, 3), np.nan))
    none = tmp_path / "none.npz"
    np.savez(none, patches=np.zeros((0, 4, 4, 3)))
    (tmp_path / "empty.bpt").write_text("0\n")
    (tmp_path / "words.bpt").write_text("nan nan nan\n")
    half = tmp_path / "half.npz"
    half.write_bytes(cup.read_bytes()[:700])
    cases = {
        str(cut): "expected 26 bicubic patches",
        str(bpt(tmp_path / "degree.bpt", points[:, :3, :3], "2 2")): "of degree 3 3, got 2 2",
        str(bad): "expected finite",
        str(none): "expected at least one, got none",
        str(tmp_path / "empty.bpt"): "expected a number of patches",
        str(tmp_path / "words.bpt"): "",
        str(half): "",
        str(tmp_path / "missing.bpt"): "no such file",
        "torus_20k": "expected Bezier patches or NURBS surfaces, got TriangleMesh",
        "no_such_thing": "expected a name",
    }
    for source, expected in cases.items():
        assert main(["tessellate", source, str(tmp_path / "out.ply")]) == 2, source
        said = capsys.readouterr().err
        assert expected in said and said.count("\n") == 1, said
    for words in (["--level", "30"], ["--level", "-1"], ["-m", "nothing"], ["-s", "lvl=2"]):
        assert main(["tessellate", str(cup), str(tmp_path / "out.ply"), *words]) == 2
        assert capsys.readouterr().err.count("\n") == 1
    assert not (tmp_path / "out.ply").exists()


def test_tessellate_takes_nurbs_and_names_its_parts(tmp_path, capsys):
    file, out = tmp_path / "model.json", tmp_path / "model.glb"
    surfaces = [
        {
            "name": f"part {k}",
            "degree_u": s.degree_u,
            "degree_v": s.degree_v,
            "knots_u": s.knots_u.tolist(),
            "knots_v": s.knots_v.tolist(),
            "control_points": s.points.tolist(),
        }
        for k, s in enumerate(nurbs.quilt(1, 3, 2).surfaces)
    ]
    file.write_text(json.dumps({"surfaces": surfaces}))
    assert main(["tessellate", str(file), str(out), "--level", "3"]) == 0
    assert "3 surfaces -> 384 triangles, 225 points" in capsys.readouterr().out
    scene = trimesh.load_scene(out, process=False)
    assert sorted(scene.geometry) == ["part 0", "part 1", "part 2"]
    assert all(len(shape.faces) == 128 for shape in scene.geometry.values())
    mesh = read_mesh(out)
    assert (mesh.triangle_count, mesh.vertex_count) == (384, 243) and mesh.normals is not None
    assert main(["tessellate", str(file), str(tmp_path / "a.ply"), "-n", "3", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["surfaces"], facts["vertices_out"]) == (3, 225)
    assert read_mesh(tmp_path / "a.ply").vertex_count == 225


def test_tessellate_says_what_a_file_has_that_is_left_out(tmp_path, capsys):
    file = tmp_path / "model.stp"
    file.write_text(step(nurbs.ball()))
    assert main(["tessellate", str(file), str(tmp_path / "a.ply"), "-s", "per=span"]) == 0
    assert f"note: {file}: trims of 1 faces are left out" in capsys.readouterr().err


def test_broken_nurbs_are_one_line(tmp_path, capsys):
    for name, text in (
        ("a.json", "{}"),
        ("a.igs", "x" * 80),
        ("a.stp", "ISO-10303-21;"),
        ("a.3dm", ""),
    ):
        file = tmp_path / name
        file.write_text(text)
        assert main(["tessellate", str(file), str(tmp_path / "out.ply")]) == 2
        said = capsys.readouterr().err
        assert said.count("\n") == 1 and said.startswith("error: ")


def test_tessellate_keeps_to_a_tolerance(tmp_path, capsys):
    out = tmp_path / "ball.ply"
    assert main(["tessellate", "rational_ball", str(out), "--tolerance", "0.001", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["counters"]["largest_distance"] <= 0.001
    corners = read_mesh(out).positions[read_mesh(out).triangles].astype(np.float64)
    centres = np.linalg.norm(corners.mean(axis=1), axis=1)
    assert 0 < (1 - centres).max() <= 0.001 * np.sqrt(12)
    assert main(["tessellate", "pot_32", str(out), "--tolerance", "0.001"]) == 2
    assert "option: expected one" in capsys.readouterr().err


def test_tessellate_cuts_nurbs_by_pixels_and_by_a_view(tmp_path, capsys):
    out, counts = tmp_path / "out.glb", []
    near = ("--view", "0,0,3")
    for words in (
        ["--pixel-area", "64"], ["--pixel-area", "64", *near], ["--view", "30,20"],
        ["--pixel-area", "64", "-n", "2"], ["--pixel-area", "64", "-s", "edges=tolerant"],
    ):  # fmt: skip
        assert main(["tessellate", "rational_torus", str(out), "--json", *words]) == 0
        counts.append(json.loads(capsys.readouterr().out)["triangles_out"])
    whole, close, finer, coarse, tolerant = counts
    assert whole < close and whole < finer and whole < tolerant
    assert coarse == 16 * 2 * 16  # 4 segments to a span at the most
    mesh = read_mesh(out)
    assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-5)
    wrong = (
        (["--pixel-area", "0"], "pixel_area: expected 0.01 to"),
        (["--view", "30,20", "-m", "uniform_nurbs"], "view: expected a method that adapts to it"),
        (["--view", "30"], "view: expected AZIMUTH,ELEVATION"),
        (["--pixel-area", "8", "--tolerance", "0.1"], "option: expected one"),
    )
    for words, said in wrong:
        assert main(["tessellate", "rational_torus", str(out), *words]) == 2
        error = capsys.readouterr().err
        assert said in error and error.count("\n") == 1
