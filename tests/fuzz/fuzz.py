"""Targets tried one after the other, each in its own process with a time limit per input; losses are written down."""

import json
import queue
import subprocess
import sys
import threading
import time
from pathlib import Path

import psutil

ROOT = Path(__file__).parents[2]
LIMIT_S = 60.0  # of processor time for one input; the first builds kernels
PATIENCE = 10  # limits of wall time, for what waits without working, or on a machine that is busy with something else
MOST_LOSSES = 20  # of a target: what comes after has been said
PART = 500  # inputs between two looks at what came of them


def _lines(process, found):
    for line in process.stdout:
        found.put(line.rstrip("\n"))
    found.put(None)


def fuzz(
    name,
    count,
    seed=0,
    limit_s=LIMIT_S,
    say=lambda text: None,
    patience=PATIENCE,
    before=None,
    keep=lambda result: None,
):
    """What came of `count` inputs of a target, with those that an earlier run had tried: its result is `before`.

    `keep` gets the result so far now and then. Each process draws other inputs, by the number of those before it.

    Returns:
        `tries`, `ok`, `refused`, `seconds`, and `losses`, each with its `kind` (crash, hang, wrong, fault), what was
        `said`, and the `input`.
    """
    result = {"tries": 0, "ok": 0, "refused": 0, "losses": [], "seconds": 0.0, **(before or {})}
    start = time.monotonic() - result["seconds"]

    def so_far():
        result["seconds"] = round(time.monotonic() - start, 1)
        keep(result)

    while result["tries"] < count and len(result["losses"]) < MOST_LOSSES:
        words = [
            sys.executable,
            "-m",
            "tests.fuzz.worker",
            name,
            str(count - result["tries"]),
            str(seed + result["tries"]),
        ]
        process = subprocess.Popen(
            words, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        found = queue.Queue()
        reader = threading.Thread(target=_lines, args=(process, found), daemon=True)
        reader.start()
        ended = _follow(process, result, found, limit_s, patience, so_far)
        process.kill()
        error = (process.communicate()[1] or "").strip().splitlines()
        if ended == "end" or ended is None:
            break
        if not result["losses"] or result["losses"][-1].get("open") is None:
            raise RuntimeError(f"{name}: the worker did not begin: {error[-1:] or ended}")
        loss = result["losses"][-1]
        del loss["open"]
        if loss["kind"] == "crash":
            loss["said"] = f"exit {process.returncode} {' '.join(error[-1:])}".strip()
        say(f"{name}: {loss['kind']} {loss['said']}")
    so_far()
    return result


def _cpu_s(process):
    """Processor seconds of a process so far; those of one that has ended are not known."""
    try:
        return sum(psutil.Process(process.pid).cpu_times()[:2])
    except psutil.Error:
        return 0.0


def _follow(process, result, found, limit_s, patience, so_far):
    """Count what a worker says until it ends; "end" where it came to its end, else the last loss is left open."""
    given, ready = None, False
    worked, waited = 0.0, 0
    while True:
        try:
            line = found.get(timeout=limit_s)
            worked, waited = _cpu_s(process), 0
        except queue.Empty:
            waited += 1
            if waited < patience and _cpu_s(process) - worked < limit_s:
                continue
            if not ready:
                return "no beginning"
            result["losses"].append(
                {"kind": "hang", "said": f"over {limit_s:g} s", "input": given, "open": True}
            )
            return "hang"
        if line is None:
            if given is not None:
                result["losses"].append({"kind": "crash", "said": "", "input": given, "open": True})
            return "crash" if given is not None or not ready else "end"
        word, _, rest = line.partition(" ")
        if word == "ready":
            ready = True
        elif word == "try":
            given = json.loads(rest)
            result["tries"] += 1
        elif word == "did":
            if rest in ("ok", "refused"):
                result[rest] += 1
            else:
                kind, _, said = rest.partition(" ")
                result["losses"].append({"kind": kind, "said": said, "input": given})
            given = None
            if result["tries"] % PART == 0:
                so_far()
        elif word == "end":
            return "end"
