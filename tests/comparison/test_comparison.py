"""That the record of what `compare` finds is as it must be, and that the defects it was made with are such."""

import json

import pytest

from lodbench.datasets_gen.triangles import displaced_icosphere
from lodbench.harness.measure import quality
from lodbench.kernels import simplify_mesh
from tests.comparison.__main__ import RECORD, wrong
from tests.comparison.changed import SHARE, off


@pytest.mark.skipif(not RECORD.exists(), reason="nothing is recorded")
def test_record_has_few_alarms_and_every_defect():
    assert wrong(json.loads(RECORD.read_text("utf-8"))) == []


def test_what_must_not_be_is_named():
    none = {"tries": 4, "found": 4}
    good = {"level": 0.05, "same": {"comparisons": 20, "alarms": 1}, "slower": none, "worse": none}
    assert wrong(good) == []
    assert wrong(
        {**good, "same": {"comparisons": 20, "alarms": 2}, "worse": {**none, "found": 3}}
    ) == [
        "2 alarms in 20 comparisons of the same code",
        "worse: 3 of 4 found",
    ]


def test_error_put_in_is_a_tenth(device):
    pytest.importorskip("igl")
    mesh = displaced_icosphere(12)
    made = simplify_mesh(device, mesh, cells=9).mesh
    before, after = (
        quality.measure(mesh, one, 0)["rms_error"] for one in (made, off(mesh, made, 0))
    )
    assert after / before == pytest.approx(1 + SHARE, abs=0.005)
