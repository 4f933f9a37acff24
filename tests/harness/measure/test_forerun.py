"""A peer that crashes or hangs, in a run that goes on: real peers' names, with what they call replaced."""

import json
import os
import sys
import time

import pytest

from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.cli.app import main
from lodbench.harness.measure import forerun
from lodbench.harness.measure.forerun import Forerunner, PeerFault, is_peer
from lodbench.harness.plan.registry import system

PEER = "fast_simplification"
FAULTY = """
import os, signal, sys, time
def simplify(points, faces, **given):
    n = len(faces)
    if n == 20: os.kill(os.getpid(), signal.SIGSEGV)
    if n == 80: time.sleep(600)
    if n == 320: raise ValueError("not with me")
    print("a word that nobody asked for")
    return points, faces
"""


@pytest.fixture
def forerunner(monkeypatch, tmp_path):
    """One whose fast-simplification crashes with 20 triangles, hangs with 80 and raises with 320."""
    (tmp_path / "fast_simplification.py").write_text(FAULTY)
    paths = [str(tmp_path), *filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(paths))
    made = Forerunner()
    yield made
    made.close()


def tried(forerunner, device, level):
    owner = system(PEER)
    forerunner.try_out(owner, device, icosphere(level), next(iter(owner.cases.values())))


def test_crash_and_hang_are_said_and_the_next_call_is_answered(forerunner, device, monkeypatch):
    tried(forerunner, device, 3)
    tried(forerunner, device, 2)  # an error of Python's is met again where it is measured
    with pytest.raises(
        PeerFault, match="crashed where it was tried, in a process of its own: SIGSEGV"
    ):
        tried(forerunner, device, 0)
    monkeypatch.setenv("LODBENCH_PEER_LIMIT", "1.5")
    start = time.monotonic()
    with pytest.raises(PeerFault, match=r"did not return within 1\.5 s"):
        forerunner._begin()
        tried(forerunner, device, 1)
    assert time.monotonic() - start < 60
    monkeypatch.delenv("LODBENCH_PEER_LIMIT")
    tried(forerunner, device, 3)


def test_peer_that_crashes_is_a_failed_row_and_the_run_goes_on(forerunner, tmp_path, capsys):
    words = [
        "run",
        "quadric_clustering",
        "-a",
        PEER,
        "-d",
        "icosphere_0",
        "--samples",
        "3",
        "-q",
        "--json",
    ]
    assert main([*words, "--out", str(tmp_path / "run")]) == 0
    (made,) = json.loads(capsys.readouterr().out)
    status = {row["system"]: (row["status"], row["reason"]) for row in made["rows"]}
    assert status["quadric_clustering"][0] != "failed"
    assert status[PEER][0] == "failed" and "SIGSEGV" in status[PEER][1]


def test_what_is_no_peer_is_not_tried(device, monkeypatch):
    monkeypatch.setattr(forerun.subprocess, "Popen", lambda *words, **more: pytest.fail("started"))
    owner = system("numpy_quadric_clustering")
    assert not is_peer(owner) and is_peer(system(PEER))
    Forerunner().try_out(owner, device, icosphere(0), None)


def test_process_that_does_not_come_up_leaves_peers_untried(device, monkeypatch):
    monkeypatch.setattr(forerun, "__name__", "no_such_module")
    made = Forerunner()
    tried(made, device, 1)
    made.close()
    assert "no_such_module" not in sys.modules
