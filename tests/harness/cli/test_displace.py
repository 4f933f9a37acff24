import numpy as np
import pytest

from lodbench.datasets_gen.read import read_mesh, write_mesh
from lodbench.datasets_gen.triangles import plane
from lodbench.harness.cli.app import main
from lodbench.harness.cli.displace import FORMS, displacement
from lodbench.kernels import refine_mesh
from lodbench.kernels.image import write_png

FUNCTION = """// a fold
float displace(float3 position, float3 normal, float2 uv, float time)
{
    return 0.1f * fabs(position.x);
}
"""


@pytest.fixture
def refined(tmp_path, capsys):
    """Runs `refine icosphere_1 --displace WORD` in a folder: exit code, the mesh if there is one, standard error."""

    def run(word, source="icosphere_1"):
        out = tmp_path / "out.ply"
        code = main(["refine", source, str(out), "--displace", word])
        return code, read_mesh(out) if out.exists() else None, capsys.readouterr().err

    return run


@pytest.mark.parametrize(
    ("word", "options"),
    [
        ("0.02", {"amplitude": 0.02}),
        ("0.02,3", {"amplitude": 0.02, "waves": 3.0}),
        ("perlin:0.03,5", {"displacement": "perlin", "amplitude": 0.03, "waves": 5.0}),
        (
            "a:b/c.PNG:-0.1,0.5",
            {
                "displacement": "height_map",
                "height_map": "a:b/c.PNG",
                "amplitude": -0.1,
                "map_bias": 0.5,
            },
        ),
        ("d.npy:1", {"displacement": "height_map", "height_map": "d.npy", "amplitude": 1.0}),
    ],
)
def test_words_become_options(word, options):
    assert displacement(word) == options


@pytest.mark.parametrize(
    "word", ["high", "perlin:", "perlin:0.1,2,3", "0.1,,", "a.png", "a.png:1,2,3"]
)
def test_displacement_that_is_none_is_said_in_one_line(word, refined):
    code, _, said = refined(word)
    assert code == 2
    assert f"displace: expected {FORMS}, got {word!r}" in said


def test_function_in_a_file_raises_the_surface(device, tmp_path, refined):
    (tmp_path / "fold.cl").write_text(FUNCTION)
    code, found, said = refined(str(tmp_path / "fold.cl"))
    assert code == 0, said
    expected = refine_mesh(device, _ball(), displacement="function", function=FUNCTION).mesh
    assert np.array_equal(found.positions, expected.positions)
    assert np.array_equal(found.normals, expected.normals)


def _ball():
    from lodbench.datasets_gen.catalogue import load

    return load("icosphere_1").surface


@pytest.mark.parametrize(
    ("code", "said"),
    [
        (FUNCTION.replace("fabs", "fabulous"), "function: expected OpenCL C that builds, line 4: "),
        ("float height(float3 p) { return 1; }", "function: expected float displace(float3 position, "),
        ("", "function: expected float displace(float3 position, "),
    ],
)  # fmt: skip
def test_function_that_is_none_is_said_in_one_line(code, said, tmp_path, refined):
    (tmp_path / "own.cl").write_text(code)
    found, _, errors = refined(str(tmp_path / "own.cl"))
    assert found == 2
    assert errors.startswith(f"error: {said}") and errors.count("\n") == 1


def test_function_that_cannot_be_read_is_named(tmp_path, refined):
    code, _, said = refined(str(tmp_path / "none.cl"))
    assert code == 2 and "none.cl: no such file" in said
    (tmp_path / "odd.cl").write_bytes(b"\xff\xfe")
    code, _, said = refined(str(tmp_path / "odd.cl"))
    assert code == 2 and "odd.cl: expected OpenCL C in UTF-8, got other bytes" in said


def test_picture_raises_a_surface_that_has_texture_coordinates(device, tmp_path, refined):
    picture = np.arange(256, dtype=np.uint8).reshape(16, 16)
    write_png(tmp_path / "bumps.png", picture)
    write_mesh(tmp_path / "plane.ply", plane(2))
    code, found, said = refined(f"{tmp_path / 'bumps.png'}:0.1,0.5", str(tmp_path / "plane.ply"))
    assert code == 0, said
    options = {"displacement": "height_map", "amplitude": 0.1, "map_bias": 0.5}
    expected = refine_mesh(device, plane(2), height_map=picture, **options).mesh
    assert np.array_equal(found.positions, expected.positions)
    code, _, said = refined(f"{tmp_path / 'bumps.png'}:0.1")
    assert code == 2
    assert "uvs: expected texture coordinates under a height map, got a mesh without" in said


def test_picture_that_is_none_is_said_in_one_line(tmp_path, refined):
    write_mesh(tmp_path / "plane.ply", plane(1))
    (tmp_path / "text.png").write_text("text")
    for name, reason in (("none.png", "no such file"), ("text.png", "not a readable .png file")):
        code, _, said = refined(f"{tmp_path / name}:0.1", str(tmp_path / "plane.ply"))
        assert code == 2 and f"{name}: {reason}" in said and said.count("\n") == 1
