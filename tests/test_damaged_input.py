"""Whatever a user throws at the command line ends in a valid mesh or in one line and exit code 2."""

from pathlib import Path

import numpy as np
import pytest

from lodbench.datasets_gen.read import read_mesh
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.cli.app import main
from lodbench.kernels import refine_mesh, simplify_mesh


def command(capsys, *words):
    """Exit code, and what was said on standard error."""
    code = main([str(word) for word in words])
    return code, capsys.readouterr().err


def assert_one_line(code, said):
    assert code == 2, said
    assert said.count("\n") == 1 and said.startswith("error: "), said


def assert_valid(mesh):
    assert np.isfinite(mesh.positions).all()
    assert mesh.triangles.size == 0 or int(mesh.triangles.max()) < mesh.vertex_count


def files(folder):
    return sorted(
        path for path in Path(folder).rglob("*") if path.suffix in (".ply", ".obj", ".stl")
    )


def test_damaged_files_give_a_mesh_or_one_line(data_folder, capsys, tmp_path):
    for path in files(data_folder / "nasty"):
        for verb, option, out in (
            ("simplify", ("--target-reduction", "0.5"), tmp_path / "simplified.ply"),
            ("simplify", ("--cells", "3"), tmp_path / "clustered.obj"),
            ("refine", ("--segments", "2"), tmp_path / "refined.stl"),
        ):
            out.unlink(missing_ok=True)
            code, said = command(capsys, verb, path, out, *option)
            if code == 0:
                assert_valid(read_mesh(out))
            else:
                assert_one_line(code, said)
                assert not out.exists()


def test_damaged_arrays_give_a_mesh_or_an_error_by_name(data_folder, device):
    arrays = np.load(data_folder / "nasty/synthetic.npz")
    for name in sorted({key.rsplit("__", 1)[0] for key in arrays}):
        points, faces = arrays[f"{name}__V"], arrays[f"{name}__F"]
        try:
            mesh = TriangleMesh(points, faces)
        except ValueError as error:
            assert str(error).startswith(("points: ", "faces: ")), name
            continue
        if mesh.vertex_count and not mesh.triangle_count:
            with pytest.raises(ValueError, match="faces: expected triangles, got"):
                simplify_mesh(device, mesh, cells=5)
            continue
        for placement in ("robust", "paper", "average"):
            assert_valid(simplify_mesh(device, mesh, cells=5, placement=placement).mesh)
        assert_valid(simplify_mesh(device, mesh, target_reduction=0.7).mesh)
        assert_valid(refine_mesh(device, mesh, segments=3).mesh)


@pytest.fixture
def tetrahedron(tmp_path):
    path = tmp_path / "tetrahedron.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
    return path


@pytest.mark.parametrize(
    "options",
    [
        ("--cells", "0"),
        ("--cells", "one"),
        ("--cells", "100000"),
        ("--target-reduction", "1.5"),
        ("--target-count", "0"),
        ("--cells", "4", "--target-count", "2"),
        (),
        ("--cells", "4", "--method", "magic"),
        ("--cells", "4", "--device", "no such device"),
    ],
)
def test_wrong_options_are_one_line(capsys, tmp_path, tetrahedron, options):
    out = tmp_path / "out.ply"
    assert_one_line(*command(capsys, "simplify", tetrahedron, out, *options))
    assert not out.exists()


def test_wrong_places_are_one_line(capsys, tmp_path, tetrahedron):
    truncated = tmp_path / "truncated.ply"
    truncated.write_bytes(
        b"ply\nformat binary_little_endian 1.0\nelement vertex 9\nproperty float x\n"
    )
    kept = tmp_path / "kept.ply"
    kept.write_text("not to be lost")
    for source, out in (
        (tmp_path, tmp_path / "out.ply"),
        (tmp_path / "absent.ply", tmp_path / "out.ply"),
        (truncated, kept),
        (tetrahedron, tetrahedron / "out.ply"),
        (tetrahedron, tmp_path),
        (tetrahedron, tmp_path / "out.unknown"),
    ):
        assert_one_line(*command(capsys, "simplify", source, out, "--cells", "2"))
    assert kept.read_text() == "not to be lost"
