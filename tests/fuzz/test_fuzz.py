"""A few inputs of everything that `make fuzz` tries by the thousand, in this process; and the fuzzer itself."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings

from lodbench.datasets_gen.surfaces import TriangleMesh
from tests.fuzz import devices, faults, fuzz, inputs, targets

SYSTEMS, READERS = targets.names()


@pytest.mark.parametrize("name", SYSTEMS + READERS)
def test_few_inputs_end_in_a_result_or_a_refusal(name):
    found = targets.target(name)

    @settings(max_examples=4 if name in SYSTEMS else 10, deadline=None, phases=[Phase.generate],
              suppress_health_check=list(HealthCheck))  # fmt: skip
    @given(found.strategy)
    def tried(description):
        assert targets.outcome(found, description) in ("ok", "refused"), inputs.written(description)

    tried()


@pytest.mark.parametrize("name", READERS)
def test_undamaged_files_are_read(name):
    found = targets.target(name)
    for whole in range(4):
        assert targets.outcome(found, {"whole": whole, "edits": []}) == "ok"


def test_description_makes_the_same_input_again():
    shape = {"kind": "soup", "seed": 3, "triangles": 9, "vertices": 5, "exponent": -30, "offset": 1.0,
             "damages": ["odd", "collapsed"]}  # fmt: skip
    first, second = inputs.mesh(shape), inputs.mesh(json.loads(inputs.written(shape)))
    assert first.positions.tobytes() == second.positions.tobytes()
    assert first.triangles.tobytes() == second.triangles.tobytes()
    edits = [["flip", 5, 3], ["number", 0, 2], ["end", 30, 0]]
    assert inputs.damaged(b"1 2 3 and more text, 4 5 6 and the end of it", edits) != b""


def test_result_that_no_caller_should_get_is_a_loss():
    class Mesh:
        positions, triangles = np.array([[0, np.nan, 0]]), np.zeros((0, 3), int)
        triangle_count, vertex_count = 0, 1

    def call(description):
        targets.check_mesh(Mesh if description == "nan" else {}[description])

    found = targets.Target("x", None, call)
    assert targets.outcome(found, "nan") == "wrong a point that is not finite"
    assert targets.outcome(found, "gone") == "fault KeyError: 'gone'"
    Mesh.positions, Mesh.triangle_count, Mesh.triangles = np.zeros((1, 3)), 1, np.ones((1, 3), int)
    assert targets.outcome(found, "nan") == "wrong an index out of range"
    plain = targets.Target("x", None, lambda given: TriangleMesh(np.zeros((1, 3)), [[0, 0, given]]))
    assert targets.outcome(plain, 9) == "refused"


WORKER = """
import os, sys, time
for number in range(int(sys.argv[2])):
    print("ready" if not number else "", f'try {{"n": {number}}}', sep="\\n" if not number else "", flush=True)
    if sys.argv[1] == "hang" and number == 2: time.sleep(60)
    if sys.argv[1] == "crash" and number == 2: os.abort()
    print("did", "wrong a" if sys.argv[1] == "wrong" and number == 1 else "ok", flush=True)
print("end", flush=True)
"""


@pytest.mark.parametrize(
    ("name", "kind", "tries", "ok"), [("fine", None, 4, 4), ("wrong", "wrong", 4, 3)]
)
def test_outcomes_are_counted(monkeypatch, name, kind, tries, ok):
    result = _fuzzed(monkeypatch, name)
    assert (result["tries"], result["ok"]) == (tries, ok)
    assert [loss["kind"] for loss in result["losses"]] == ([kind] if kind else [])


@pytest.mark.parametrize("name", ["hang", "crash"])
def test_worker_that_hangs_or_crashes_is_a_loss_and_the_next_goes_on(monkeypatch, name):
    result = _fuzzed(monkeypatch, name)
    # the third of the first worker; the second has but one left
    assert (result["tries"], result["ok"]) == (4, 3)
    (loss,) = result["losses"]
    assert (loss["kind"], loss["input"]) == (name, {"n": 2})


def test_tries_of_an_earlier_run_count_and_results_are_kept_meanwhile(monkeypatch):
    before, kept = {"tries": 3, "ok": 2, "refused": 1, "losses": [], "seconds": 5.0}, []
    monkeypatch.setattr(fuzz, "PART", 2)
    result = _fuzzed(monkeypatch, "fine", before=before, keep=lambda now: kept.append(now["tries"]))
    assert (result["tries"], result["ok"], result["refused"]) == (4, 3, 1)
    assert kept == [4, 4]
    assert result["seconds"] >= 5


def test_command_in_a_fork_ends_as_the_command_does(tmp_path):
    done = faults.measure(tmp_path / "run", "--no-such-option", begin=faults.Forked)
    assert len(faults.ended(done).splitlines()) == 1
    assert done.returncode == 2


def _fuzzed(monkeypatch, name, **options):
    popen = fuzz.subprocess.Popen
    monkeypatch.setattr(
        fuzz.subprocess, "Popen",
        lambda words, **given: popen([sys.executable, "-c", WORKER, *words[3:]], **given),
    )  # fmt: skip
    return fuzz.fuzz(name, 4, limit_s=3.0, patience=1, **options)


def test_rows_that_are_doubled_are_seen():
    row = {"kind": "sample", "group": "g", "attempt": 0, "subject": "a", "turn": 3}
    assert faults.doubled([row, {**row, "turn": 4}]) == []
    assert faults.doubled([row, row])
    ends = [{"kind": "end", "group": "g", "attempt": attempt} for attempt in (0, 1)]
    assert faults.doubled(ends) == ["g"]


def test_programs_that_do_not_build_name_their_file():
    assert devices.broken_kernels()["losses"] == []


def test_record_of_faults_has_no_loss():
    path = Path(__file__).parents[2] / "results/reference/faults.json"
    if path.exists():
        for kind in json.loads(path.read_text("utf-8")).values():
            for name, result in kind.items():
                assert result["losses"] == [], name


@pytest.mark.parametrize(
    ("name", "description"),
    [
        ("patches.npz", {"edits": [["repeat", 47, 599], ["flip", 119698, 223]], "whole": 2}),
        # headers that promise terabytes, and a number too large for an integer
        (
            "patches.npz",
            {
                "edits": [
                    ["number", 1879519, 2336],
                    ["word", 696, 60180],
                    ["word", 696, 60180],
                    ["number", 10723, 14111940],
                ],
                "whole": 1,
            },
        ),
        (
            "geometry_image.npz",
            {
                "edits": [
                    ["number", 293197, 48690960],
                    ["number", 301027, 1943],
                    ["flip", 12864, 3678],
                    ["number", 301027, 1943],
                ],
                "whole": 1,
            },
        ),
        (
            "height_map.npy",
            {
                "edits": [
                    ["number", 1879519, 2336],
                    ["number", 696, 60180],
                    ["word", 696, 60180],
                    ["number", 10723, 14111940],
                ],
                "whole": 1,
            },
        ),
        # a triangle and its back: closed and of genus 0, and no tetrahedron to begin with
        (
            "quadtree_lod",
            {
                "surface": {
                    "kind": "soup",
                    "seed": 731,
                    "triangles": 2,
                    "vertices": 4,
                    "exponent": 2,
                    "offset": 1e6,
                    "damages": [],
                },
                "case": "full",
                "size": 0,
            },
        ),
        ("nurbs.stp", {"edits": [["number", 45596, 872]], "whole": 0}),
        (
            "nurbs.stp",
            {
                "edits": [["word", 7528686, 2957], ["word", 30234, 229], ["word", 7528686, 1840]],
                "whole": 1,
            },
        ),
    ],
)
def test_what_was_lost_once_is_refused(name, description):
    assert targets.outcome(targets.target(name), description) == "refused"
