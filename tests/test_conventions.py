"""The mechanical part of the conventions: names, headers, mirrors, direction of imports, sizes."""

import ast
import re
from pathlib import Path

import pytest

from lodbench.harness.plan.registry import systems
from lodbench.kernels.opencl.source import kernel_parameters

ROOT = Path(__file__).parents[1]
KERNEL_FILES = sorted(
    path for folder in ("kernels", "harness") for path in (ROOT / folder).rglob("*.cl")
)
PYTHON_FILES = sorted(
    path
    for folder in ("datasets_gen", "kernels", "harness")
    for path in (ROOT / folder).rglob("*.py")
)
SYSTEM_FOLDERS = sorted(
    path.parent
    for path in (ROOT / "kernels").glob("*/*/host.py")
    if (path.parent / "__init__.py").exists()
)
MIRRORED = sorted(
    path
    for pattern in ("kernels/*.py", "kernels/opencl/*.py", "kernels/common/*.cl", "harness/*/*.py")
    for path in ROOT.glob(pattern)
    if path.name != "__init__.py"
)
TESTED_BY = {  # what has no mirror by its own name: the tests that stand for it, from `tests/`
    # data alone
    "kernels/result.py": "kernels/test_api.py",
    "kernels/opencl/facts.py": "kernels/opencl/test_device.py",
    # through those who call it
    "kernels/function_text.py": "kernels/refine/test_function.py",
    "kernels/launching.py": "kernels/refine/test_pattern.py",
    "kernels/common/probe.cl": "harness/doctor/test_examine.py",
    "kernels/common/displacement.cl": "kernels/refine/test_displacement.py",
    "kernels/common/function.cl": "kernels/refine/test_function.py",
    "kernels/common/height_map.cl": "kernels/refine/test_height_map.py",
    "kernels/common/noise.cl": "kernels/refine/test_displacement.py",
    "kernels/common/normals.cl": "kernels/bezier/test_vst.py",
    "kernels/common/output.cl": "kernels/bezier/test_vst.py",
    "kernels/common/sine.cl": "kernels/refine/test_pattern.py",
    "kernels/common/lattice_walk.cl": "kernels/refine/test_pattern.py",
    "harness/baselines/host.py": "test_every_system.py",
    "harness/baselines/igl_mesh.py": "harness/baselines/test_subdivision.py",
    "harness/baselines/nurbs.py": "harness/baselines/test_numpy_nurbs.py",
    "harness/baselines/simplifier.py": "harness/baselines/test_peers.py",
    "harness/baselines/vtk_mesh.py": "harness/baselines/test_peers.py",
    **{
        f"harness/claims/{name}.py": "harness/report/test_claims.py"
        for name in ("boubekeur", "concheiro", "decoro", "model", "wang")
    },
    "harness/report/evidence.py": "harness/report/test_claims.py",
    "harness/doctor/opencl.py": "harness/doctor/test_examine.py",
    "harness/doctor/probe.py": "harness/doctor/test_examine.py",
    "harness/measure/alike.py": "harness/measure/test_spread.py",
    "harness/measure/cluster.py": "harness/measure/test_spread.py",
    "harness/measure/figure.py": "harness/measure/test_exact.py",
    "harness/measure/identity.py": "harness/measure/test_run.py",
    "harness/measure/remote.py": "harness/measure/test_spread.py",
    "harness/measure/trial.py": "harness/measure/test_frames.py",
    "harness/record/folder.py": "harness/measure/test_run.py",
    "harness/record/samples.py": "harness/record/test_record.py",
    "harness/report/table_view.py": "harness/report/test_page.py",
    # commands, through the shell
    "harness/cli/datasets.py": "harness/cli/test_app.py",
    "harness/cli/guard.py": "harness/report/test_guard.py",
    "harness/cli/lists.py": "harness/cli/test_app.py",
    "harness/cli/measure.py": "harness/cli/test_app.py",
    "harness/cli/mesh.py": "harness/cli/test_files.py",
    "harness/cli/options.py": "harness/cli/test_app.py",
    "harness/cli/records.py": "harness/cli/test_app.py",
    "harness/cli/reproduce.py": "harness/cli/test_app.py",
    "harness/cli/sweep.py": "harness/cli/test_app.py",
    # one test per source
    "harness/tables/borders.py": "harness/tables/test_dt07.py",
    "harness/tables/dt07_grids.py": "harness/tables/test_dt07.py",
    "harness/tables/dt07_chain.py": "harness/tables/test_dt07.py",
    "harness/tables/dt07_timing.py": "harness/tables/test_dt07.py",
    "harness/tables/dt07_warps.py": "harness/tables/test_dt07.py",
    "harness/tables/gmr05_figure4.py": "harness/tables/test_gmr05.py",
    "harness/tables/gmr05_figure7.py": "harness/tables/test_gmr05.py",
    "harness/tables/gems3_adaptive.py": "harness/tables/test_gems3.py",
    "harness/tables/gems3_pool.py": "harness/tables/test_gems3.py",
    "harness/tables/gmr05_path.py": "harness/tables/test_gmr05.py",
    "harness/tables/gmr05_st_mesh.py": "harness/tables/test_gmr05.py",
    "harness/tables/gmr05_pn.py": "harness/tables/test_gmr05.py",
    "harness/tables/nurbs_basis.py": "harness/tables/test_nurbs.py",
    "harness/tables/nurbs_exactness.py": "harness/tables/test_nurbs.py",
    "harness/tables/nurbs_grids.py": "harness/tables/test_nurbs.py",
    "harness/tables/rc13_6_2.py": "harness/tables/test_nurbs.py",
    "harness/tables/rc13_6_3_to_6_6.py": "harness/tables/test_nurbs.py",
    "harness/tables/rc13_6_7_to_6_10.py": "harness/tables/test_nurbs.py",
    "harness/tables/rc13_6_11_to_6_14.py": "harness/tables/test_nurbs.py",
    "harness/tables/rc13_6_15.py": "harness/tables/test_nurbs.py",
    "harness/tables/rc13_2_1.py": "harness/tables/test_rc13.py",
    "harness/tables/rc13_exactness.py": "harness/tables/test_rc13.py",
    "harness/tables/rc13_3_1.py": "harness/tables/test_rc13.py",
    "harness/tables/rc13_3_18_3_19.py": "harness/tables/test_rc13.py",
    "harness/tables/rc13_4_1_4_2.py": "harness/tables/test_rc13.py",
    "harness/tables/rc13_4_6_to_4_8.py": "harness/tables/test_rc13.py",
    "harness/tables/rc13_5_13_to_5_18.py": "harness/tables/test_rc13.py",
    "harness/tables/rc13_5_1_to_5_3.py": "harness/tables/test_rc13.py",
    "harness/tables/rc13_figures_2_10_to_2_13.py": "harness/tables/test_rc13.py",
    "harness/tables/w14_parameterisation.py": "harness/tables/test_w14.py",
    "harness/tables/w14_scale.py": "harness/tables/test_w14.py",
    "harness/tables/w14_table1.py": "harness/tables/test_w14.py",
}
UPSTREAM = {
    "datasets_gen": ("lodbench.kernels", "lodbench.harness"),
    "kernels": ("lodbench.harness",),
}


def header(source: str) -> list[str]:
    lines = []
    for line in source.splitlines():
        if not line.startswith("//"):
            break
        lines.append(line)
    return lines


def short(path: Path) -> str:
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("path", KERNEL_FILES, ids=short)
def test_kernel_file_header_names_source_work_and_real_arguments(path):
    source = path.read_text()
    lines = header(source)
    assert lines, "a kernel file opens with its header"
    keys = [match[1] for line in lines if (match := re.match(r"// (\w+) {2,}\S", line))]
    for key in ("Source", "Work", "Reads", "Writes"):
        assert key in keys, f"header line {key} is missing"
    parameters = {p.name for kernel in kernel_parameters(source).values() for p in kernel}
    if not parameters:
        return
    section = None
    for line in lines:
        if match := re.match(r"// (\w+) {2,}\S", line):
            section = match[1]
        named = re.match(r"// (?:\w+)? {2,}(\w+) {2,}\w+ *\[", line)
        if section in ("Reads", "Writes") and named:
            assert named[1] in parameters, f"{named[1]} is no argument of a kernel in this file"


@pytest.mark.parametrize("path", KERNEL_FILES, ids=short)
def test_kernel_file_says_where_its_readable_form_stands(path):
    named = re.findall(r"^// Plain {2,}(.+)$", path.read_text("utf-8"), re.M)
    for file in named:
        assert (ROOT / "kernels" / file).is_file(), file
    if (path.parent / "reference.py").exists() and kernel_parameters(path.read_text("utf-8")):
        assert named, (
            "a system's kernels have a readable form: `// Plain     family/system/reference.py`"
        )


@pytest.mark.parametrize("path", KERNEL_FILES, ids=short)
def test_kernel_names_start_with_system_and_stage(path):
    folder = path.parent.name
    for name in kernel_parameters(path.read_text()):
        if folder == "common":
            assert path.name == "probe.cl", "common/ holds device functions, no kernels"
        elif folder == "stages":
            assert name.startswith(f"stages_{path.stem}"), (
                f"expected stages_{path.stem}[_step], got {name}"
            )
        else:
            assert name.startswith(f"{folder}_{path.stem}"), (
                f"expected {folder}_{path.stem}[_step], got {name}"
            )


def test_kernel_names_are_unique():
    names = [name for path in KERNEL_FILES for name in kernel_parameters(path.read_text())]
    assert len(names) == len(set(names))


def test_every_system_folder_is_registered_under_its_own_name():
    registered = systems()
    for folder in SYSTEM_FOLDERS:
        assert folder.name in registered, f"{folder.name} has a host.py but no SYSTEM"
        assert registered[folder.name].family == folder.parent.name
        assert registered[folder.name].cases, "at least one named case"
        assert registered[folder.name].source, "paper and section"


def test_registry_finds_no_system_without_a_folder():
    folders = {path.parent.name for path in (ROOT / "kernels").glob("*/*/__init__.py")}
    folders |= {path.parent.name for path in (ROOT / "harness/baselines").rglob("__init__.py")}
    assert set(systems()) <= folders


@pytest.mark.parametrize("folder", SYSTEM_FOLDERS, ids=short)
def test_system_folder_has_its_files_and_its_mirror_test(folder):
    assert (folder / "reference.py").exists()
    family = folder.parent.name
    assert (ROOT / "tests/kernels" / family / f"test_{folder.name}.py").exists()


@pytest.mark.parametrize("path", MIRRORED, ids=short)
def test_module_has_its_mirror_or_says_what_tests_it(path):
    mirror = path.relative_to(ROOT).parent / f"test_{path.stem}.py"
    has_mirror = (ROOT / "tests" / mirror).exists()
    if short(path) in TESTED_BY:
        assert not has_mirror, f"tests/{mirror} is there: strike it from TESTED_BY"
        mirror = TESTED_BY[short(path)]
    assert (ROOT / "tests" / mirror).exists(), f"tests/{mirror} is missing"


def test_exceptions_from_the_mirror_exist():
    assert set(TESTED_BY) <= {short(path) for path in MIRRORED}


@pytest.mark.parametrize("path", PYTHON_FILES, ids=short)
def test_imports_go_one_way(path):
    forbidden = UPSTREAM.get(path.relative_to(ROOT).parts[0], ())
    tree = ast.parse(path.read_text())
    for node in ast.walk(tree):
        names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, "absolute imports everywhere"
            names = [node.module or ""]
        for name in names:
            assert not name.startswith(forbidden), f"{short(path)} imports upstream {name}"
            assert name.split(".")[0] not in UPSTREAM | {"harness": ()}, (
                f"import lodbench.{name}, not {name}"
            )


@pytest.mark.parametrize("path", PYTHON_FILES + KERNEL_FILES, ids=short)
def test_file_is_short_or_gives_its_reason(path):
    text = path.read_text()
    limit = 300 if path.suffix == ".py" else 200
    if len(text.splitlines()) > limit:
        assert re.search(r"(?i)long because", "\n".join(text.splitlines()[:12])), (
            f"over {limit} lines: split it, or say `long because ...` at the top"
        )


@pytest.mark.parametrize("path", PYTHON_FILES, ids=short)
def test_text_is_read_as_utf_8_on_every_machine(path):
    assert "read_text()" not in path.read_text("utf-8")


def test_dataset_makers_use_no_opencl():
    for path in (ROOT / "datasets_gen").rglob("*.py"):
        assert "pyopencl" not in path.read_text()


def test_only_the_device_layer_imports_pyopencl():
    allowed = {"kernels/opencl/driver.py", "harness/doctor/probe.py"}
    users = {
        short(path)
        for path in PYTHON_FILES
        if re.search(r"^\s*(import|from) pyopencl", path.read_text(), re.M)
    }
    assert users <= allowed


@pytest.mark.parametrize("folder", ["kernels", "harness/baselines"])
def test_families_and_systems_have_an_init(folder):
    for path in (ROOT / folder).rglob("*.py"):
        assert (path.parent / "__init__.py").exists(), (
            f"a walk skips {short(path.parent)}: no __init__.py"
        )
