import os
import shutil
import signal
import subprocess
import sys
import textwrap
import time

import pytest

LD = shutil.which("ld")
SCRIPT = """
import atexit, os, runpy, signal, sys, time

def press():
    os.kill(os.getpid(), signal.SIGINT)

class PressAtImport:
    # presses Ctrl-C as the module of this name is looked for, as far inside the imports as can be
    def find_spec(self, name, *others):
        if name == "{module}":
            press()
        return None

sys.meta_path.insert(0, PressAtImport())
sys.argv = ["lodbench", *{words}]
{first}
runpy.run_module("lodbench.harness", run_name="__main__")
"""
SWALLOWS = """
import os, signal, time
try:
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(0.01)
except:
    pass
"""
COMMAND = """
from lodbench.harness.cli import app as cli
@cli.app.command()
def wait():
    {body}
    time.sleep(60)
"""


def ended(script, **options):
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=60, **options
    )
    return done.returncode, done.stderr.splitlines()


def script(*words, module="", first=""):
    return SCRIPT.format(words=list(words), module=module, first=textwrap.dedent(first))


@pytest.mark.parametrize(
    "module", ["typer", "lodbench.harness.cli.mesh", "lodbench.kernels", "numpy"]
)
def test_ctrl_c_during_an_import_ends_the_command(module):
    words = ["list", "devices"]
    assert ended(script(*words, module=module)) == (130, ["stopped: interrupted"])


@pytest.mark.parametrize(
    "body",
    [
        "press()",
        "import swallows",
        "type('Freed', (), {'__del__': lambda self: press()})()",
        "\n    try: press()\n    except BaseException: pass",
        "\n    try: press()\n    finally: time.sleep(0.2)",
    ],
    ids=["at once", "in an import that catches all", "while freeing", "caught", "with a finally"],
)
def test_ctrl_c_in_a_command_is_never_lost(tmp_path, body):
    (tmp_path / "swallows.py").write_text(SWALLOWS)
    first = COMMAND.format(body=body)
    code, lines = ended(
        script("wait", first=first), env={**os.environ, "PYTHONPATH": str(tmp_path)}
    )
    assert (code, lines) == (130, ["stopped: interrupted"])


def test_ctrl_c_after_the_command_ends_the_process():
    first = COMMAND.format(body="return atexit.register(press) and None")
    assert ended(script("wait", first=first)) == (130, ["stopped: interrupted"])


def test_ctrl_c_that_is_ignored_stays_ignored():
    first = "signal.signal(signal.SIGINT, signal.SIG_IGN)"
    assert ended(script("--help", module="typer", first=first)) == (0, [])


@pytest.mark.usefixtures("pocl")
def test_ctrl_c_while_the_driver_links_reaches_the_command_and_not_the_linker(tmp_path):
    """The whole foreground group gets the signal on a terminal, programs that the driver starts included."""
    (tmp_path / "in.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    linker = tmp_path / "ld"  # the real one, late
    linker.write_text(
        f"#!{sys.executable} -IS\nimport os, sys, time\nopen('linking', 'w').close()\ntime.sleep(0.3)\n"
        f"os.execv({LD!r}, [{LD!r}, *sys.argv[1:]])\n"
    )
    linker.chmod(0o755)
    pocl = tmp_path / "pocl"
    with subprocess.Popen(
        [sys.executable, "-m", "lodbench.harness", "refine", "in.off", "out.off"],
        cwd=tmp_path, stderr=subprocess.PIPE, text=True, start_new_session=True,
        env={**os.environ, "POCL_CACHE_DIR": str(pocl), "PATH": f"{tmp_path}:{os.environ['PATH']}"},
    ) as child:  # fmt: skip
        while child.poll() is None and not (tmp_path / "linking").exists():
            time.sleep(0.001)
        os.killpg(child.pid, signal.SIGINT)
        assert child.stderr is not None
        lines = child.stderr.read().splitlines()
    assert (child.returncode, lines) == (130, ["stopped: interrupted"])
    assert (tmp_path / "linking").exists()
    assert not list(pocl.glob("lodbench-loading-*"))
