import numpy as np
import pytest

from lodbench.datasets_gen.read import read_mesh
from lodbench.datasets_gen.surfaces import GeometryImage
from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.cli.app import main
from lodbench.harness.cli.warp import warping
from lodbench.kernels import simplify_mesh

FUNCTION = "float warp(const float t, const int axis)\n{\n    return axis == 1 ? t * t : t;\n}\n"
WORDS = (
    ["--region", "1,0,0,0.2,8"],
    ["--view", "30,20"],
    ["--view", "2,0.5,0"],
    ["--warp", "w.cl"],
)


@pytest.fixture
def simplified(tmp_path, monkeypatch, capsys):
    """Runs `simplify icosphere_4 -n 1000` with more words in a folder: exit code, the mesh, standard error."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "w.cl").write_text(FUNCTION)
    (tmp_path / "bad.cl").write_text(FUNCTION.replace("t * t", "t * s"))

    def run(words):
        out = tmp_path / "out.ply"
        code = main(["simplify", "icosphere_4", str(out), "-n", "1000", *words])
        return code, read_mesh(out) if out.exists() else None, capsys.readouterr().err

    return run


def test_words_become_options():
    ball = icosphere(1)
    assert warping(None, None, None, ball) == {}
    assert warping(["1,2,3,.5,6", "-1,0,0,1e-1,2"], None, None, ball) == {
        "regions": ((1, 2, 3, 0.5, 6), (-1, 0, 0, 0.1, 2))
    }
    assert warping(None, "0,2,5", None, ball)["view"].eye == pytest.approx((0, 2, 5))
    turned = warping(None, "90,0", None, ball)["view"].eye
    assert turned / np.linalg.norm(turned) == pytest.approx((1, 0, 0), abs=1e-2)


@pytest.mark.parametrize("words", WORDS)
def test_mesh_is_simplified_under_a_warp(simplified, words):
    code, mesh, _ = simplified(words)
    assert code == 0
    assert 0 < mesh.triangle_count <= 1000
    even = simplify_mesh(None, icosphere(4), target_count=1000).mesh
    assert not np.array_equal(mesh.triangles, even.triangles)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--region", "1,2"], "region: expected X,Y,Z,RADIUS,WEIGHT, got '1,2'"),
        (["--region", "0,0,0,1,0"], "regions: expected"),
        (["--view", "front"], "view: expected AZIMUTH,ELEVATION or X,Y,Z of the eye, got 'front'"),
        (["--view", "0,0,0"], "view: expected an eye other than the middle of the mesh"),
        (["--view", "nan,0,0"], "view: expected"),
        (["--warp", "none.cl"], "none.cl: no such file"),
        (["--warp", "bad.cl"], "warp: expected OpenCL C that builds, line 3: use of undeclared"),
        (["--warp", "w.cl", "--view", "0,0"], "expected one of them, got view and warp"),
    ],
)
def test_warp_that_is_none_is_said_in_one_line(simplified, words, told):
    code, mesh, said = simplified(words)
    assert code == 2
    assert mesh is None
    assert f"error: {told}" in said or told in said


def test_view_needs_a_mesh_to_look_at():
    points = np.zeros((3, 3, 3))
    with pytest.raises(ValueError, match="view: expected a mesh to look at, got a GeometryImage"):
        warping(None, "0,0", None, GeometryImage(points, points))
