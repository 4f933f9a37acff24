"""Every device subject under the Oclgrind simulator: no invalid access, no data race, no misuse of the API.

Oclgrind leaves out races in which all items write the same value, which kernels here may do where they say so. Its
check for uninitialised values is not used: it stops at `freeze`, an instruction that its LLVM gives to any kernel;
`restrict` is defined away and the optimiser kept low, since both leave intrinsics that Oclgrind does not know.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from lodbench.datasets_gen.files import write_file
from lodbench.harness.plan.registry import systems
from lodbench.kernels.opencl.source import kernel_parameters

ROOT = Path(__file__).parents[1]
SUBJECTS = ["stages", *(name for name, system in systems().items() if system.runs_on == "device")]
TIMEOUT_S = 300

# kernels that no small input reaches on the simulator, each with its reason
NOT_LAUNCHED = {
    "probe": "the doctor's own",
}

# pyopencl asks any device for what only some have
QUERIES = {"clGetDeviceInfo", "clGetKernelWorkGroupInfo", "clGetPlatformInfo"}

pytestmark = pytest.mark.skipif(shutil.which("oclgrind") is None, reason="oclgrind is not on PATH")


@pytest.fixture(scope="session")
def shared_folder(tmp_path_factory):
    """One folder for all processes of a test run."""
    own = tmp_path_factory.getbasetemp()
    return own.parent if "PYTEST_XDIST_WORKER" in os.environ else own


def under_oclgrind(subject, folder):
    """(what the subject said, Oclgrind's reports); each subject runs once in a test run, whichever process begins."""
    answer, begun = folder / f"{subject}.json", folder / f"{subject}.begun"
    try:
        begun.touch(exist_ok=False)
    except FileExistsError:
        until = time.monotonic() + TIMEOUT_S
        while not answer.exists() and time.monotonic() < until:
            time.sleep(0.1)
    else:
        write_file(answer, json.dumps(run_under_oclgrind(subject)))
    returncode, said, errors = json.loads(answer.read_text())
    assert returncode == 0, errors[-4000:]
    return json.loads(said.splitlines()[-1]), reports(errors)


def run_under_oclgrind(subject, timeout_s=TIMEOUT_S):
    command = [
        "oclgrind", "--data-races", "--check-api", "--max-errors", "20",
        "--global-mem-size", str(1 << 30), "--num-threads", "1", "--build-options", "-O1 -Drestrict=",
        sys.executable, "-m", "tests.oclgrind_subject", subject,
    ]  # fmt: skip
    done = subprocess.run(
        command, capture_output=True, text=True, errors="replace", cwd=ROOT, timeout=timeout_s,
        env=os.environ | {"LODBENCH_PRELUDE": "0", "PYOPENCL_NO_CACHE": "1", "LODBENCH_CACHE": os.devnull},
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


def reports(text):
    """Oclgrind's own blocks in what a run wrote to standard error, less the queries that any device may refuse."""
    found = []
    for block in re.split(r"\n\s*\n(?=\S)", text):
        function = re.search(r"Function: (\w+)", block)
        if "Oclgrind - OpenCL runtime error" in block:
            if function and function[1] not in QUERIES:
                found.append(block.strip())
        elif re.search(r"^\tKernel: \w+", block, re.M) or "OCLGRIND" in block:
            found.append(block.strip())
    return found


def written_kernels():
    """The names of all kernels in the repository."""
    files = (ROOT / "kernels").rglob("*.cl")
    return {name for path in files for name in kernel_parameters(path.read_text())}


@pytest.mark.parametrize("subject", SUBJECTS)
def test_subject_is_clean_under_oclgrind(subject, shared_folder):
    said, found = under_oclgrind(subject, shared_folder)
    assert not found, f"{len(found)} reports, the first:\n" + "\n\n".join(found[:3])
    assert said["failed"] == []


def test_every_kernel_was_launched_under_oclgrind(shared_folder):
    said = [under_oclgrind(subject, shared_folder)[0] for subject in SUBJECTS]
    launched = {name for one in said for name in one["launched"]}
    assert sorted(written_kernels() - launched - set(NOT_LAUNCHED)) == []


def test_reports_are_found_and_queries_left_out():
    text = """
Oclgrind - OpenCL runtime error detected
\tFunction: clGetDeviceInfo
\tError:    CL_INVALID_VALUE

Invalid write of size 4 at global memory address 0x1000000000028
\tKernel: stages_scan_write
\tEntity: Global(10,0,0) Local(10,0,0) Group(0,0,0)

Oclgrind - OpenCL runtime error detected
\tFunction: clEnqueueNDRangeKernel
\tError:    CL_INVALID_WORK_GROUP_SIZE

Write-write data race at global memory address 0x1000000000000
\tKernel: stages_compact_rows
"""
    kinds = [report.splitlines()[0].split(" at ")[0] for report in reports(text)]
    assert kinds == [
        "Invalid write of size 4",
        "Oclgrind - OpenCL runtime error detected",
        "Write-write data race",
    ]
    assert reports("a warning of numpy's\n\nanother line") == []


def test_a_kernel_with_a_race_and_a_stray_write_is_reported(tmp_path):
    # the judge itself: a kernel that is wrong on purpose has to be caught
    file = tmp_path / "wrong.cl"
    file.write_text(
        "__kernel void wrong(__global int *n) { n[0] = get_global_id(0); n[get_global_id(0)] = 1; }"
    )
    script = (
        "import numpy as np\n"
        "from lodbench.kernels.opencl.device import Device\n"
        "from lodbench.kernels.opencl.timeline import Timeline\n"
        "d = Device.open('oclgrind')\n"
        "n = d.upload('n', np.zeros(3, np.int32))\n"
        f"d.build({str(file)!r}).launch('wrong', 4, stage='s', local=4, n=n)(Timeline())\n"
        "d.wait()\n"
    )
    done = subprocess.run(
        ["oclgrind", "--data-races", sys.executable, "-c", script],
        capture_output=True, text=True, cwd=ROOT, env=os.environ | {"LODBENCH_PRELUDE": "0"},
    )  # fmt: skip
    text = "\n".join(reports(done.stderr))
    assert "data race" in text
    assert "Invalid write" in text
