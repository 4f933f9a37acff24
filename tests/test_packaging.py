"""The wheel holds what the tree holds: a stale or forgotten file would ship otherwise."""

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SHIPPED = {
    ".py",
    ".cl",
    ".html",
    ".css",
    ".js",
    ".json",
    ".toml",
    ".vert",
    ".frag",
    ".geom",
    ".tesc",
    ".tese",
}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    copy = folder / "tree"
    files = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, capture_output=True, text=True
    )
    if files.returncode:
        pytest.skip("not a git checkout: no list of files to compare with")
    for name in files.stdout.splitlines():
        source = ROOT / name
        if source.is_file() and not name.startswith((".types", "results")):
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            (copy / name).write_bytes(source.read_bytes())
    build = [
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "--no-deps",
        "--quiet",
        "-w",
        str(folder),
        str(copy),
    ]
    done = subprocess.run(build, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return zipfile.ZipFile(next(folder.glob("*.whl"))), copy


def test_wheel_members_are_the_tree(wheel):
    archive, copy = wheel
    members = {name for name in archive.namelist() if ".dist-info/" not in name}
    expected = {
        f"lodbench/{path.relative_to(copy)}"
        for folder in ("datasets_gen", "kernels", "harness")
        for path in (copy / folder).rglob("*")
        if path.suffix in SHIPPED or path.name == "py.typed"
    }
    assert members == expected


def test_wheel_declares_the_command(wheel):
    archive, _ = wheel
    entry = next(name for name in archive.namelist() if name.endswith("entry_points.txt"))
    assert "lodbench = lodbench.harness.__main__:main" in archive.read(entry).decode()


def test_wheel_runs_from_its_own_folder(wheel, tmp_path):
    archive, _ = wheel
    archive.extractall(tmp_path)
    code = "from lodbench.kernels.opencl.source import KERNELS; print(KERNELS); import lodbench.kernels"
    done = subprocess.run(
        [sys.executable, "-I", "-c", f"import sys; sys.path.insert(0, {str(tmp_path)!r}); "
         "sys.meta_path = [f for f in sys.meta_path if 'editable' not in repr(f).lower()]; " + code],
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert str(tmp_path) in done.stdout


def test_root_holds_no_package_that_would_collide():
    assert not (ROOT / "lodbench").exists()
