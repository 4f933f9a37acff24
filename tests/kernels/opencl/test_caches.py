import io
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from lodbench.kernels.opencl import caches, driver
from lodbench.kernels.opencl.device import DeviceError
from lodbench.kernels.opencl.timeline import Timeline

KERNEL = "__kernel void ones(__global float *values) { values[get_global_id(0)] = 1.0f; }"
RUN_KERNEL = """
import sys
import numpy as np
from lodbench.kernels.opencl.device import Device, DeviceError
from lodbench.kernels.opencl.timeline import Timeline
try:
    device = Device.open()
    values = device.allocate("values", 64, np.float32)
    device.build(sys.argv[1]).launch("ones", 64, stage="s", values=values)(Timeline())
    print(device.read(values).sum())
except DeviceError as error:
    sys.exit(str(error))
"""
HOLD_MARK = """
import sys, time
from lodbench.kernels.opencl import caches
caches.mark.begin()
print("held", flush=True)
sys.stdin.read()
"""


@pytest.fixture
def folder(monkeypatch, tmp_path):
    """An empty PoCL cache for the processes started here."""
    path = tmp_path / "pocl"
    path.mkdir()
    monkeypatch.setenv("POCL_CACHE_DIR", str(path))
    monkeypatch.setenv("LODBENCH_PRELUDE", "0")
    return path


def marks(folder):
    return list(folder.glob(f"{caches.MARK}*"))


def run_kernel(tmp_path, **options):
    file = tmp_path / "ones.cl"
    file.write_text(KERNEL)
    return subprocess.run(
        [sys.executable, "-c", RUN_KERNEL, str(file)], capture_output=True, text=True, **options
    )


@pytest.fixture
def holder(folder):
    """A process that holds its mark until its standard input ends."""
    child = subprocess.Popen(
        [sys.executable, "-c", HOLD_MARK], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert child.stdout is not None
    assert child.stdout.readline() == "held\n"
    yield child
    child.kill()
    child.communicate()


def test_mark_of_a_living_process_is_left_alone(folder, holder, capsys):
    caches.settle()
    assert caches.pocl_folder() == folder
    assert len(marks(folder)) == 1
    assert capsys.readouterr().err == ""
    holder.communicate("")
    assert marks(folder) == [], "a process that ends in good order takes its mark away"


def test_ctrl_c_takes_the_mark_away(folder, holder):
    holder.send_signal(signal.SIGINT)
    holder.communicate()
    assert marks(folder) == []


def test_mark_of_a_dead_process_makes_the_next_start_use_a_clean_folder(
    folder, holder, monkeypatch, capsys
):
    holder.kill()
    holder.communicate()

    def start():
        monkeypatch.setenv("POCL_CACHE_DIR", str(folder))
        caches.settle()
        return caches.pocl_folder(), capsys.readouterr().err

    used, said = start()
    assert used == folder / f"{caches.CLEAN}1" and used.is_dir()
    assert len(said.splitlines()) == 1 and f"afresh in {used}" in said
    assert marks(folder) == []
    assert start() == (used, ""), "later starts take it without a word"
    (used / f"{caches.MARK}1").touch()  # and it happens again in there
    assert start()[0] == folder / f"{caches.CLEAN}2"


@pytest.mark.usefixtures("pocl")
def test_mark_lies_there_from_a_first_launch_to_the_wait_after_it(device, tmp_path, monkeypatch):
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path))
    file = tmp_path / "ones.cl"
    file.write_text(KERNEL)
    values = device.allocate("values", 64, np.float32)
    program = device.build(file)
    assert marks(tmp_path) == [], "a build is over when it returns"
    launch = program.launch("ones", 64, stage="s", values=values)
    launch(Timeline())
    assert len(marks(tmp_path)) == 1
    device.wait()
    assert marks(tmp_path) == []
    program.launch("ones", 64, stage="s", values=values)(Timeline())
    assert marks(tmp_path) == [], "what has run before is loaded"
    program.launch("ones", 64, stage="s", local=1, values=values)(Timeline())
    assert len(marks(tmp_path)) == 1, "another group size is another file of the driver's"
    device.read(values)
    assert marks(tmp_path) == []


@pytest.mark.usefixtures("pocl")
def test_kernel_cut_short_ends_one_process_and_not_the_next(folder, tmp_path):
    assert run_kernel(tmp_path).stdout == "64.0\n"
    (kernel,) = folder.rglob("ones.so")
    os.truncate(kernel, kernel.stat().st_size // 3)
    assert run_kernel(tmp_path).returncode < 0
    again = run_kernel(tmp_path)
    assert again.stdout == "64.0\n"
    assert again.stderr.startswith(
        f"lodbench: a process died while it loaded kernels from {folder}"
    )


@pytest.mark.usefixtures("pocl")
def test_program_cut_short_is_an_error_that_names_the_folder(folder, tmp_path):
    assert run_kernel(tmp_path).stdout == "64.0\n"
    (program,) = folder.rglob("program.bc")
    os.truncate(program, program.stat().st_size // 3)
    assert f"PoCL's cache folder {folder} is damaged" in run_kernel(tmp_path).stderr
    assert run_kernel(tmp_path).stdout == "64.0\n"


def test_unwritable_cache_is_one_line_that_names_it(monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path / "file" / "kcache"))
    monkeypatch.setattr(driver, "list_devices", lambda: [])
    with pytest.raises(DeviceError) as error:
        driver.choose_device("")
    assert f"{tmp_path}/file/kcache: cannot be written: Not a directory" in str(error.value)
    assert "POCL_CACHE_DIR" in str(error.value)


@pytest.mark.usefixtures("pocl")
def test_full_cache_is_an_error_and_not_an_abort(folder, tmp_path):
    resource = pytest.importorskip("resource")

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 16, 1 << 16))

    done = run_kernel(tmp_path, preexec_fn=limit)
    assert done.returncode == 1
    (line,) = done.stderr.splitlines()
    assert f"PoCL's cache folder {folder}: cannot be written: File too large" in line


def test_disk_that_is_nearly_full_is_named(monkeypatch, tmp_path):
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path))
    assert caches.why_no_pocl() == ""
    monkeypatch.setattr(caches, "LOW_SPACE", 1 << 62)
    assert f"PoCL's cache folder {tmp_path}" in caches.why_no_pocl()
    assert "MB left; make room" in caches.why_no_pocl()


def test_own_cache_that_cannot_be_written_is_named_once(monkeypatch, tmp_path, capsys):
    from lodbench.kernels.geometry_image.parameterisation.cache import cache_path, write_arrays

    (tmp_path / "file").touch()
    monkeypatch.setenv("LODBENCH_CACHE", str(tmp_path / "file" / "cache"))
    write_arrays(cache_path("a"), a=np.zeros(1))
    write_arrays(cache_path("b"), b=np.zeros(1))
    (line,) = capsys.readouterr().err.splitlines()
    assert f"{tmp_path}/file/cache: cannot be written" in line and "LODBENCH_CACHE" in line


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")
def test_call_after_fork_is_an_error_that_says_spawn(device):
    buffer = device.upload("values", np.zeros(4, np.float32))

    def refused():
        for call in (
            lambda: device.read(buffer),
            lambda: device.allocate("more", 4, np.float32),
            device.wait,
            driver.list_devices,
        ):
            try:
                call()
            except DeviceError as error:
                if "spawn" in str(error):
                    continue
            return 1
        return 0

    pid = os.fork()
    if pid == 0:
        os._exit(refused())
    deadline = time.monotonic() + 20
    while not (ended := os.waitpid(pid, os.WNOHANG))[0]:
        if time.monotonic() > deadline:
            os.kill(pid, signal.SIGKILL)
        time.sleep(0.01)
    assert os.waitstatus_to_exitcode(ended[1]) == 0


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="threads are not listed here")
@pytest.mark.usefixtures("pocl")
def test_ctrl_c_does_not_reach_the_threads_that_start_the_linker(device):
    blocked = 0
    for task in Path("/proc/self/task").iterdir():
        masks = dict(
            line.split(":\t")
            for line in (task / "status").read_text().splitlines()
            if ":\t" in line
        )
        blocked += bool(int(masks["SigBlk"], 16) >> (signal.SIGINT - 1) & 1)
    assert blocked >= device.facts.compute_units
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())


def test_long_compiling_is_announced_once_and_on_a_terminal_only(monkeypatch, tmp_path):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(caches, "SLOW_S", 0.01)
    for stream, lines in ((io.StringIO(), 0), (Terminal(), 1)):
        monkeypatch.setattr(sys, "stderr", stream)
        monkeypatch.setattr(caches, "_announced", False)
        for _ in range(2):
            with caches.loading():
                time.sleep(0.1)
        assert stream.getvalue().count("compiling kernels for this device, once") == lines
