"""Runs that are killed, interrupted, or find no room: what was written stays, and resuming completes it.

Each returns `tries` and `losses`, of which there should be none.
"""

import collections
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from contextlib import contextmanager
from pathlib import Path

from lodbench.harness.__main__ import main
from lodbench.harness.cli import interrupt, reproduce
from lodbench.harness.record.record import read_rows
from lodbench.harness.record.samples import rows_file
from tests.harness.fake import install

ROOT = Path(__file__).parents[2]
SECONDS = "0.002"  # of a fake frame
TIMED = ("wall_s", "ratio_to_", "status", "reason")  # columns that depend on time
LIMIT_S = 900  # of a run of seconds: the machine may be busy with something else
FROM_THE_START = 5  # of so many runs that are killed, one begins with Python; the others are forks


def lodbench(*words):
    """The command with fake subjects, in a process of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", "tests.harness.fake_main", SECONDS, *map(str, words)],
        cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


IMPORTED = reproduce  # before the forks are made


class Forked:
    """The same command in a fork of this process, which has imported everything: most of a short run is imports."""

    def __init__(self, *words):
        self.returncode, self.said = None, tempfile.TemporaryFile()
        self.pid = os.fork()
        if not self.pid:
            _command(words, self.said.fileno())

    def poll(self):
        if self.returncode is None:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                self.returncode = os.waitstatus_to_exitcode(status)
        return self.returncode

    def send_signal(self, number):
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self):
        self.send_signal(signal.SIGKILL)

    def communicate(self, timeout=LIMIT_S):
        until = time.monotonic() + timeout
        while self.poll() is None:
            if time.monotonic() > until:
                raise subprocess.TimeoutExpired("lodbench", timeout)
            time.sleep(0.01)
        self.said.seek(0)
        return "", self.said.read().decode(errors="replace")


def _command(words, said):
    """What the fork does, to its end."""
    code = 1
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        os.dup2(said, 2)
        sys.stdout, sys.stderr = open(1, "w"), open(2, "w", buffering=1)
        interrupt.install()
        install(seconds=float(SECONDS))
        sys.argv[1:] = map(str, words)
        code = main()
    except SystemExit as end:
        code = end.code
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(int(code or 0))


def ended(process):
    """What a process said on standard error, once it is over; one that hangs is killed, and says so."""
    try:
        return process.communicate(timeout=LIMIT_S)[1].strip()
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        return f"no end within {LIMIT_S} s\nkilled"


def measure(folder, *words, begin=lodbench):
    return begin("reproduce", "--samples", "3", "--quiet", "--out", folder, *words)


def rows(folder):
    """The rows of a run; none where it did not begin."""
    path = rows_file(folder)
    return read_rows(path) if path.exists() else []


def table(folder):
    """The table without what depends on time."""
    made = json.loads((folder / "tables/fake_table.json").read_text())
    return [
        {key: value for key, value in row.items() if not key.startswith(TIMED)}
        for row in made["rows"]
    ]


def doubled(found):
    """Rows of one sample, setup, result or end that are there more than once."""
    keys = collections.Counter(
        tuple(row.get(key) for key in ("kind", "group", "attempt", "subject", "turn"))
        for row in found if row["kind"] not in ("limits", "superseded")
    )  # fmt: skip
    ends = collections.Counter(row["group"] for row in found if row["kind"] == "end")
    return [key for key, count in (*keys.items(), *ends.items()) if count > 1]


def resumed(folder, before, whole, begin=lodbench):
    """What is wrong with a run that is resumed to its end; "" if nothing is."""
    more = ["--resume"] if (folder / "run.json").exists() else []
    process = measure(folder, *more, begin=begin)
    error = ended(process)
    if process.returncode:
        return f"resume ended with {process.returncode}: {error}"
    after = rows(folder)
    if after[: len(before)] != before:
        return "rows that were written are lost"
    if found := doubled(after):
        return f"rows are doubled: {found[:2]}"
    return "" if table(folder) == whole else "the table is another"


def stopped(tries, number, seed=0):
    """Runs that get signal `number` at random moments, then are resumed; some of them had ended already."""
    rng = random.Random(seed)
    losses = []
    with tempfile.TemporaryDirectory() as parent:
        seconds, in_time = {}, 0
        for begin in (lodbench, Forked):
            start, folder = time.monotonic(), Path(parent, begin.__name__)
            measure(folder, begin=begin).communicate(timeout=LIMIT_S)
            seconds[begin], whole = time.monotonic() - start, table(folder)
        for number_of in range(tries):
            folder = Path(parent, str(number_of))
            whole_process = number == signal.SIGKILL and number_of % FROM_THE_START == 0
            begin = lodbench if whole_process else Forked
            process = measure(folder, begin=begin)
            start, moment = time.monotonic(), rng.uniform(0, 1.05 * seconds[begin])
            while process.poll() is None and time.monotonic() - start < moment:
                time.sleep(0.002)
            if process.poll() is not None:  # the first was measured while the machine was busier
                seconds[begin] = min(seconds[begin], time.monotonic() - start)
            in_time += process.poll() is None
            process.send_signal(number)
            error = ended(process)
            wrong = ""
            if number == signal.SIGINT and process.returncode not in (0, 130, -signal.SIGINT):
                wrong = f"ended with {process.returncode}: {error[:300]}"
            elif number == signal.SIGINT and len(error.splitlines()) > 1:
                wrong = f"said more than a line: {error[:300]}"
            if wrong := wrong or resumed(folder, rows(folder), whole, Forked):
                losses.append(wrong)
            shutil.rmtree(folder, ignore_errors=True)
    return {"tries": tries, "while_running": in_time, "losses": losses}


@contextmanager
def small_disk(size):
    """A folder on a disk of `size` bytes of its own; None where this process may not make one."""
    with tempfile.TemporaryDirectory() as folder:
        options = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder]
        done = os.geteuid() == 0 and not subprocess.run(options, capture_output=True).returncode
        try:
            yield Path(folder) if done else None
        finally:
            if done:
                subprocess.run(["umount", "-l", folder], check=True)


def _mounted_anew(folder, option):
    subprocess.run(["mount", "-o", f"remount,{option}", folder], check=True)


def full_disk(sizes=(4096, 8192, 12288, 16384, 20480, 24576, 32768)):
    """Runs on disks that are too small by more or less, then given room."""
    losses, tries = [], 0
    with tempfile.TemporaryDirectory() as parent:
        measure(Path(parent, "whole")).communicate(timeout=LIMIT_S)
        whole = table(Path(parent, "whole"))
    for size in sizes:
        with small_disk(size) as disk:
            if disk is None:
                return {"tries": 0, "losses": [], "skipped": "needs root, to mount a small disk"}
            tries += 1
            process = measure(disk / "run")
            error = ended(process)
            if process.returncode not in (0, 2) or len(error.splitlines()) > 1:
                losses.append(f"{size} bytes: ended with {process.returncode}: {error[:300]}")
            before = rows(disk / "run")
            _mounted_anew(disk, "size=8m")
            if wrong := resumed(disk / "run", before, whole):
                losses.append(f"{size} bytes: {wrong}")
    return {"tries": tries, "losses": losses}


def read_only():
    """A run whose folder, or the one around it, may not be written."""
    losses, tries = [], 0
    with small_disk(1 << 20) as disk:
        if disk is None:
            return {"tries": 0, "losses": [], "skipped": "needs root, to mount a disk"}
        measure(disk / "done").communicate(timeout=LIMIT_S)
        before = rows(disk / "done")
        _mounted_anew(disk, "ro")
        for words in (
            ["reproduce", "-q", "--out", disk / "new"],
            ["reproduce", "-q", "--resume", "--out", disk / "done"],
            ["report", disk / "done"],
        ):
            tries += 1
            process = lodbench(*words)
            error = ended(process)
            if process.returncode != 2 or len(error.splitlines()) != 1:
                losses.append(f"{words[0]}: ended with {process.returncode}: {error[:300]}")
        if rows(disk / "done") != before:
            losses.append("rows are lost")
    return {"tries": tries, "losses": losses}


FAULTY = """
import os, signal, time
def simplify(points, faces, **given):
    if {hangs}: time.sleep(600)
    os.kill(os.getpid(), signal.{signal})
"""


def peers(signals=("SIGSEGV", "SIGABRT", "SIGKILL", "SIGFPE", "hang")):
    """Runs in which a peer crashes or hangs: a failed row that says how, and the others measured."""
    losses = []
    for name in signals:
        hangs = name == "hang"
        with tempfile.TemporaryDirectory() as folder:
            text = FAULTY.format(hangs=hangs, signal="SIGKILL" if hangs else name)
            Path(folder, "fast_simplification.py").write_text(text)
            out = Path(folder, "run")
            words = ["run", "quadric_clustering", "-d", "icosphere_2", "--samples", "3", "-q"]
            process = subprocess.Popen(
                [sys.executable, "-m", "lodbench.harness", *words, "-a", "fast_simplification", "--out", out],
                cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                env={**os.environ, "LODBENCH_PEER_LIMIT": "20",
                     "PYTHONPATH": os.pathsep.join([folder, os.environ.get("PYTHONPATH", "")])},
            )  # fmt: skip
            error = ended(process)
            if process.returncode:
                losses.append(f"{name}: ended with {process.returncode}: {error[:300]}")
                continue
            said = {r["subject"]: r for r in rows(out) if r["kind"] == "subject"}
            wanted = "did not return" if hangs else name
            if (
                said["fast_simplification"]["status"] != "failed"
                or wanted not in said["fast_simplification"]["reason"]
            ):
                losses.append(f"{name}: {said['fast_simplification']}")
            if said["quadric_clustering"]["status"] != "ok":
                losses.append(f"{name}: {said['quadric_clustering']}")
    return {"tries": len(signals), "losses": losses}
