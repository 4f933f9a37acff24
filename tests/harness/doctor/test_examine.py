import io
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from lodbench.harness.doctor import examine as doctor
from lodbench.harness.doctor import opencl as doctor_opencl
from lodbench.harness.doctor.examine import Finding, diagnose, print_report
from lodbench.kernels.opencl import caches


def by_what(findings):
    return {finding.what: finding for finding in findings}


def told(findings):
    console = Console(file=io.StringIO(), width=100)
    code = print_report(findings, console)
    return code, console.file.getvalue()


@pytest.fixture
def no_path(monkeypatch, tmp_path):
    """An empty PATH, and caches that cannot hold a kernel linked before."""
    monkeypatch.setenv("PATH", str(tmp_path))
    for name in ("POCL_CACHE_DIR", "XDG_CACHE_HOME", "LODBENCH_CACHE"):
        monkeypatch.setenv(name, str(tmp_path / name))


@pytest.fixture
def blocked(tmp_path):
    """A folder that nobody can make, root included: its parent is a file."""
    (tmp_path / "file").write_text("")
    return tmp_path / "file" / "folder"


def test_doctor_finds_nothing_wrong_where_the_tests_run(tmp_path):
    findings = diagnose(tmp_path / "results")
    assert [f for f in findings if f.status == "fail"] == []
    found = by_what(findings)
    assert "right numbers" in found["a kernel"].detail
    assert "built-ins" not in found, "said only where they are forced"
    assert "run out of" in found["own kernels"].detail
    assert {"packages", "driver files", "PoCL cache", "OpenCL loader", "devices"} <= set(found)
    assert {"results folder", "data folder", "extra [report]", "quiet machine"} <= set(found)
    code, text = told(findings)
    assert code == 0
    assert "lodbench can run here" in text
    assert not (tmp_path / "results" / "x").exists()


@pytest.mark.usefixtures("pocl")
def test_doctor_names_binutils_where_there_is_no_linker(no_path):
    found = by_what(doctor_opencl.opencl())
    assert found["linker"].status == "fail"
    assert found["a kernel"].status == "fail"
    for what in ("linker", "a kernel"):
        mend = found[what].mend
        assert "binutils" in mend or mend.startswith("export PATH="), mend


@pytest.mark.usefixtures("pocl")
def test_doctor_survives_a_driver_that_aborts(no_path, monkeypatch):
    # past our own check for a linker, PoCL ends its process with SIGABRT
    script = (
        "import shutil, runpy, sys; shutil.which = lambda *a, **k: '/usr/bin/ld'; "
        "sys.argv = ['doctor_probe', 'kernel']; "
        "runpy.run_module('lodbench.harness.doctor.probe', run_name='__main__')"
    )
    real = subprocess.run
    monkeypatch.setattr(
        doctor_opencl.subprocess,
        "run",
        lambda command, **options: real([sys.executable, "-c", script], **options),
    )
    (finding,) = doctor_opencl.kernel()
    assert finding.status == "fail"
    assert "SIGABRT" in finding.detail


def test_doctor_tells_a_driver_that_hangs(monkeypatch):
    def run(command, timeout, **options):
        raise subprocess.TimeoutExpired(command, timeout)

    monkeypatch.setattr(doctor_opencl.subprocess, "run", run)
    (finding,) = doctor_opencl.kernel()
    assert "no answer within 120 s" in finding.detail


@pytest.mark.usefixtures("pocl")
@pytest.mark.parametrize(
    ("variable", "value"), [("OCL_ICD_VENDORS", "/no such folder"), ("POCL_DEVICES", "none")]
)
def test_doctor_says_which_variable_hides_every_device(monkeypatch, variable, value):
    monkeypatch.setenv(variable, value)
    found = by_what(doctor_opencl.opencl())
    assert found["devices"].status == "fail"
    assert found["devices"].mend == f"unset {variable}"
    assert "a kernel" not in found


@pytest.mark.usefixtures("pocl")
def test_doctor_mends_a_cache_that_hides_pocl_before_it_installs_anything(monkeypatch, blocked):
    monkeypatch.setenv("POCL_CACHE_DIR", str(blocked))
    found = by_what(doctor_opencl.opencl())
    assert found["devices"].status == "fail"
    assert found["devices"].mend == 'export POCL_CACHE_DIR="$(mktemp -d)"'


def test_doctor_sees_driver_files_that_lead_nowhere(monkeypatch, tmp_path):
    monkeypatch.setenv("OCL_ICD_VENDORS", str(tmp_path))
    (tmp_path / "gone.icd").write_text("/nowhere/libgone.so\n")
    (finding,) = doctor_opencl.icds()
    assert finding.status == "warn"
    assert "/nowhere/libgone.so, which is not there" in finding.detail
    monkeypatch.setenv("OCL_ICD_VENDORS", str(tmp_path / "missing"))
    (finding,) = doctor_opencl.icds()
    assert (finding.status, finding.mend) == ("fail", "unset OCL_ICD_VENDORS")


@pytest.mark.parametrize(
    ("variable", "what", "status"),
    [
        ("POCL_CACHE_DIR", "PoCL cache", "fail"),
        ("LODBENCH_CACHE", "lodbench cache", "warn"),
    ],
)
def test_doctor_moves_a_cache_that_cannot_be_written(monkeypatch, blocked, variable, what, status):
    monkeypatch.setenv(variable, str(blocked))
    found = by_what(doctor_opencl.caches())[what]
    assert found.status == status
    assert "cannot be written: Not a directory" in found.detail
    assert found.mend == f'export {variable}="$(mktemp -d)"'


def test_doctor_warns_of_a_full_disk(monkeypatch, tmp_path):
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(doctor_opencl, "LOW_SPACE", 1 << 62)
    found = by_what(doctor_opencl.caches())["PoCL cache"]
    assert found.status == "warn"
    assert "MB left" in found.detail


def test_doctor_names_kernels_that_are_cut_short(monkeypatch, tmp_path):
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path))
    whole = sorted(Path(np.__file__).parent.rglob("*.so"))[0].read_bytes()
    (tmp_path / "ones").mkdir()
    (tmp_path / "ones/ones.so").write_bytes(whole)
    assert by_what(doctor_opencl.caches())["PoCL cache"].status == "ok"
    for length in (len(whole) - 1, 100, 0):
        (tmp_path / "ones/ones.so").write_bytes(whole[:length])
        found = by_what(doctor_opencl.caches())["PoCL cache"]
        assert found.status == "fail"
        assert f"kernels cut short: 1, such as {tmp_path}/ones/ones.so" in found.detail
        assert found.mend == f'mv {tmp_path} "$(mktemp -d)"'


def test_doctor_passes_over_kernels_that_another_process_removes_meanwhile(monkeypatch, tmp_path):
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path))
    (tmp_path / "tempfile_gone.so").symlink_to(
        tmp_path / "renamed.so"
    )  # listed, and not to be read
    assert by_what(doctor_opencl.caches())["PoCL cache"].status == "ok"


def test_doctor_looks_into_the_clean_folder_that_is_used_after_a_crash(monkeypatch, tmp_path):
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path))
    for generation in (9, 10):
        (tmp_path / f"{caches.CLEAN}{generation}").mkdir()
    assert doctor_opencl.cache_folders()["PoCL"] == tmp_path / f"{caches.CLEAN}10"


def test_doctor_tells_broken_caches_from_a_broken_driver(monkeypatch):
    good = {
        "device": "d", "driver": "v", "ratio": 1.0, "prelude": False, "seconds": 0.1, "right": True,
    }  # fmt: skip
    monkeypatch.setattr(
        doctor_opencl,
        "_child",
        lambda step, fresh=None: (good, "") if fresh else (None, "ended by SIGSEGV"),
    )
    (finding,) = doctor_opencl.kernel()
    assert finding.status == "fail"
    assert "works with fresh caches" in finding.detail
    assert finding.mend.startswith('export POCL_CACHE_DIR="$(mktemp -d)"')
    (finding,) = doctor_opencl.own_kernels()
    assert finding.status == "fail"
    assert "some are damaged: ended by SIGSEGV" in finding.detail
    assert finding.mend.startswith(f"mv {doctor_opencl.cache_folders()['PoCL']} ")
    monkeypatch.setattr(
        doctor_opencl, "_child", lambda step, fresh=None: (None, "ended by SIGSEGV")
    )
    (finding,) = doctor_opencl.kernel()
    assert finding.detail == "ended by SIGSEGV"


def test_doctor_fails_a_kernel_that_gives_wrong_numbers(monkeypatch):
    bad = {
        "device": "d", "driver": "v", "seconds": 0.1, "right": False,
    }  # fmt: skip
    monkeypatch.setattr(doctor_opencl, "_child", lambda step, fresh=None: (bad, ""))
    monkeypatch.setenv("LODBENCH_PRELUDE", "0")
    kernel, built_ins = doctor_opencl.kernel()
    assert kernel.status == "fail" and "WRONG" in kernel.detail
    assert (built_ins.status, built_ins.mend) == ("warn", "unset LODBENCH_PRELUDE")


def test_doctor_says_that_a_device_is_not_there(monkeypatch):
    monkeypatch.setenv("LODBENCH_DEVICE", "no such device")
    (finding,) = doctor_opencl.kernel()
    assert finding.status == "fail"
    assert finding.mend == "unset LODBENCH_DEVICE"


def test_doctor_names_what_pip_has_to_install(monkeypatch):
    monkeypatch.setattr(doctor.importlib.util, "find_spec", lambda name: None)
    (packages,) = doctor._packages()
    assert packages.status == "fail"
    assert '-m pip install "pyopencl[pocl]" numpy' in packages.mend
    assert "fast-simplification" in packages.mend
    extras = by_what(doctor._extras())
    assert extras["extra [report]"].mend.endswith("-m pip install libigl jinja2")
    assert {finding.status for finding in extras.values()} == {"warn"}


def test_doctor_fails_on_a_results_folder_that_cannot_be_written(blocked):
    results, _ = doctor._folders(blocked)
    assert results.status == "fail"
    assert "--out" in results.mend


def test_doctor_warns_of_a_data_folder_that_is_none(monkeypatch, tmp_path):
    monkeypatch.setenv("LODBENCH_DATA", str(tmp_path / "missing"))
    assert [finding.status for finding in doctor._folders(tmp_path)] == ["ok", "warn"]
    monkeypatch.delenv("LODBENCH_DATA")
    assert [finding.status for finding in doctor._folders(tmp_path)] == ["ok", "ok"]


def test_doctor_goes_on_where_a_check_itself_breaks(monkeypatch, tmp_path):
    def broken():
        raise RuntimeError("no home folder")
        yield

    monkeypatch.setattr(doctor_opencl, "caches", broken)
    monkeypatch.setattr(doctor_opencl, "opencl", lambda: iter(()))
    found = by_what(diagnose(tmp_path))
    assert found["caches"].status == "fail"
    assert "no home folder" in found["caches"].detail
    assert found["results folder"].status == "ok"


def test_report_shows_each_line_whole_and_fails_with_1():
    line = "export POCL_CACHE_DIR=" + "x" * 200
    code, text = told(
        [
            Finding("extra [gl]", "warn", "without [moderngl]", "pip"),
            Finding("cache", "fail", "full", line),
        ]
    )
    assert code == 1
    assert line in text
    assert "extra [gl]" in text and "without [moderngl]" in text
    assert "failed: cache" in text


@pytest.mark.usefixtures("pocl")
def test_doctor_as_a_program_prints_json_and_ends_with_1_without_a_device(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", "import sys; from lodbench.harness.doctor.examine import main; sys.exit(main(True))"],
        env={**os.environ, "POCL_DEVICES": "none"}, capture_output=True, text=True, cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert by_what(Finding(**row) for row in json.loads(done.stdout))["devices"].status == "fail"
