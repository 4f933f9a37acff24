from pathlib import Path

import pytest

from lodbench.harness.claims import CLAIMS, Claim, Comparison, Pick, Rows, Share
from lodbench.harness.plan.registry import systems
from lodbench.harness.plan.table import tables
from lodbench.harness.record.record import read_run
from lodbench.harness.report.claims import NOT_IN_RUN, judged, verdicts
from tests.harness.records import group, run, subject

REFERENCE = Path(__file__).parents[3] / "results" / "reference"
FASTER = Comparison(Pick("gst", {"reuse": "row"}), Pick("gst", {"reuse": "none"}), least=1.0)


COMING = {"rc13_6_7_to_6_10"}  # tables that claims name before they are there


def claim(*evidence, **more):
    return Claim("a", "one is faster", "a paper", evidence, **more)


def reuse(row, none, **facts):
    return group(
        subject("gst", row, params={"reuse": "row"}),
        subject("other", none, params={"reuse": "none"}, system="gst"),
        **facts,
    )


def test_claims_are_different_and_of_every_source():
    assert len({one.name for one in CLAIMS}) == len(CLAIMS)
    papers = {one.name.split("_")[0] for one in CLAIMS}
    assert papers == {"gmr05", "gems3", "dt07", "rc13", "w14"}
    for one in CLAIMS:
        assert one.text and one.source
        assert one.evidence or one.not_on_cpu


@pytest.mark.parametrize("one", [one for claim in CLAIMS for one in claim.evidence], ids=str)
def test_evidence_speaks_of_what_may_be_there(one):
    assert one.least is not None or one.most is not None
    if isinstance(one, Rows):
        found = tables().get(one.table)
        assert found is None or one.column in {column.key for column in found.columns}
        assert found is not None or one.table in COMING
        return
    picks = (one.subject,) if isinstance(one, Share) else (one.subject, one.other)
    for pick in picks:
        for key in pick.params.keys() - {"dice_culling"}:  # which is to come
            assert hasattr(next(iter(systems()[pick.system].cases.values())), key)


@pytest.mark.parametrize(
    ("row", "none", "verdict"),
    [
        ([0.1] * 10, [0.2] * 10, "confirmed"),
        ([0.2] * 10, [0.1] * 10, "refuted"),
        ([0.1, 0.3] * 5, [0.2] * 10, "undecided"),
    ],
)
def test_verdict_is_that_of_the_whole_interval(row, none, verdict):
    found = judged(claim(FASTER), run(reuse(row, none)))
    assert found["verdict"] == verdict
    assert len(found["cases"]) == 1


def test_claim_of_a_stage_leaves_out_the_rest_of_the_frame():
    rows = [{"basis": 0.1, "vertex": 9.0}] * 10, [{"basis": 0.2, "vertex": 1.0}] * 10
    one = Comparison(FASTER.subject, FASTER.other, least=1.5, stage="basis")
    found = judged(claim(one), run(reuse(*rows)))
    assert (found["verdict"], found["cases"][0]["ratio"]) == ("confirmed", 2)


def test_verdict_of_cases_that_differ_says_how_many_held():
    made = run(reuse([0.1] * 9, [0.2] * 9), reuse([0.3] * 9, [0.2] * 9))
    found = judged(claim(FASTER, published="3 times"), made)
    assert (found["verdict"], found["reason"]) == ("partly confirmed", "in 1 of 2 cases")
    assert found["measured"] == "0.667 to 2 times as fast"
    assert found["published"] == "3 times"


def test_verdict_without_subjects_names_them_and_failed_ones_do_not_count():
    bad = group(
        subject("gst", [0.1] * 9, params={"reuse": "row"}),
        subject("none", [0.1] * 9, params={"reuse": "none"}, system="gst", status="failed"),
    )
    for made in (run(), run(bad)):
        found = judged(claim(FASTER, note="a note"), made)
        assert found["verdict"] == NOT_IN_RUN and found["measured"] is None
        assert (
            found["reason"]
            == "no group of the run has measured both gst reuse=row and gst reuse=none"
        )


def test_verdict_needs_every_comparison():
    fewer = Comparison(Pick("dabt"), Pick("vst"), "fewer triangles", least=1.0)
    slower = Comparison(Pick("dabt"), Pick("vst"), most=1.0)
    made = run(
        group(
            subject("dabt", [0.3] * 9, counters={"triangles": 100}),
            subject("vst", [0.1] * 9, counters={"triangles": 400}),
        )
    )
    found = judged(claim(fewer, slower, note="lanes"), made)
    assert (found["verdict"], found["reason"]) == ("confirmed", "lanes")
    assert found["measured"] == "4 times fewer triangles; 0.333 times as fast"
    faster = Comparison(Pick("dabt"), Pick("vst"), least=1.0)
    assert judged(claim(fewer, faster), made)["verdict"] == "refuted"


def test_frames_are_those_drawn_apart_or_whole_samples():
    drawn = {"subjects": [{"label": name, "draw": {"apart": False}} for name in ("a", "b")]}
    made = run(group(subject("a", [0.1] * 9), subject("b", [0.2] * 9), config=drawn))
    frames = Comparison(Pick("a"), Pick("b"), "frames faster", least=1.5)
    assert judged(claim(frames), made)["verdict"] == "confirmed"
    samples = Comparison(Pick("a"), Pick("b"), least=1.5)
    assert judged(claim(samples), made)["verdict"] == NOT_IN_RUN


def test_subjects_on_one_core_are_left_out():
    config = {"subjects": [{"label": "b", "one_core": True}]}
    made = run(group(subject("a", [0.1] * 9), subject("b", [0.2] * 9), config=config))
    samples = Comparison(Pick("a"), Pick("b"), least=1.5)
    assert judged(claim(samples), made)["verdict"] == NOT_IN_RUN


def test_subjects_with_what_is_not_the_papers_are_left_out():
    found = group(
        subject("vst", [0.1] * 10),
        subject("dabt", [0.2] * 10, params={"test": "distance"}),
        subject("ours", [0.05] * 10, params={"test": "mean"}, system="dabt"),
    )
    theirs = Comparison(Pick("dabt", without={"test": "mean"}), Pick("vst"), most=1.0)
    assert judged(claim(theirs), run(found))["verdict"] == "confirmed"
    every = Comparison(Pick("dabt"), Pick("vst"), most=1.0)
    assert judged(claim(every), run(found))["verdict"] != "confirmed"


def test_stages_are_compared_where_the_claim_is_of_them():
    made = run(
        group(
            subject("a", [{"basis": 0.1, "rest": 5.0}] * 9),
            subject("b", [{"basis": 0.2, "rest": 1.0}] * 9),
        )
    )
    pair = Pick("a"), Pick("b")
    assert judged(claim(Comparison(*pair, least=1.0)), made)["verdict"] == "refuted"
    found = judged(claim(Comparison(*pair, least=1.0, stage="basis")), made)
    assert (found["verdict"], found["measured"]) == (
        "confirmed",
        "2 times as fast, stage basis alone",
    )
    gone = Comparison(*pair, least=1.0, stage="other")
    assert judged(claim(gone), made)["verdict"] == NOT_IN_RUN


def test_share_of_stages_is_of_every_sample():
    made = run(group(subject("a", [{"one": 0.3, "two": 0.1}] * 8)))
    found = judged(claim(Share(Pick("a"), ("one",), "of the time", least=0.7, most=0.8)), made)
    assert (found["verdict"], found["measured"]) == ("confirmed", "0.75 of the time")
    assert found["rule"] == "at least 0.7 and at most 0.8 in every case"


def test_best_case_decides_where_the_source_says_up_to():
    made = run(reuse([0.1] * 9, [0.2] * 9), reuse([0.3] * 9, [0.2] * 9))
    best = Comparison(FASTER.subject, FASTER.other, least=1.5, reach="one")
    assert judged(claim(best), made)["verdict"] == "confirmed"
    more = Comparison(FASTER.subject, FASTER.other, least=2.5, reach="one")
    assert judged(claim(more), made)["verdict"] == "refuted"


def test_interval_on_both_sides_of_a_band_is_undecided():
    made = run(reuse([0.1, 0.3] * 5, [0.2] * 10))
    band = Comparison(FASTER.subject, FASTER.other, least=0.9, most=1.1)
    assert judged(claim(band), made)["verdict"] == "undecided"


def test_cases_without_an_interval_count_where_there_are_no_others():
    few, many = reuse([0.3] * 2, [0.2] * 2), reuse([0.1] * 9, [0.2] * 9)
    assert judged(claim(FASTER), run(few))["verdict"] == "undecided"
    assert len(judged(claim(FASTER), run(few, many))["cases"]) == 1


def test_targets_may_differ_where_counts_are_alike():
    def pair(count):
        asked = {"target_count": 100}
        ours = subject("a", [0.1] * 9, params=asked, counters={"triangles": 100})
        theirs = {"target_count": count}
        other = subject("b", [0.2] * 9, params=theirs, counters={"triangles": count})
        return run(group(ours, other))

    faster = Comparison(Pick("a"), Pick("b"), least=1.0)
    assert judged(claim(faster), pair(102))["verdict"] == "confirmed"
    assert judged(claim(faster), pair(120))["verdict"] == NOT_IN_RUN


def test_rows_are_those_that_fit_with_the_interval_of_their_column():
    octree = {"work": "storage", "levels": 8, "storage": 0.08}
    lost = subject("probabilistic_octree", [0.1] * 9, counters={"collisions": 0.05})
    made = run(group(lost, table="dt07_octree", dataset="bunny_69k", **octree))
    where = {"system": ("x", "probabilistic_*"), "storage": 0.08}
    rows = Rows("dt07_octree", "collisions", where, "collide", most=0.1)
    found = judged(claim(rows), made)
    assert (found["verdict"], found["measured"]) == ("confirmed", "0.05 collide")
    assert found["cases"][0]["group"] == "dt07_octree: bunny_69k levels=8 storage=0.08"
    times = Rows("dt07_octree", "wall_s", {"levels": 8}, "s", most=0.2)
    assert judged(claim(times), made)["measured"] == "0.1 s"
    assert judged(claim(Rows("dt07_octree", "wall_s", {"levels": 5}, "s", most=1)), made)[
        "verdict"
    ] == (NOT_IN_RUN)


def test_runs_are_judged_together():
    one, other = run(reuse([0.1] * 9, [0.2] * 9)), run(reuse([0.3] * 9, [0.2] * 9))
    assert judged(claim(FASTER), [one, other])["verdict"] == "partly confirmed"


def test_what_a_cpu_cannot_decide_waits_for_a_gpu():
    made = run(reuse([0.1] * 9, [0.2] * 9))
    found = judged(claim(FASTER, not_on_cpu="no graphics card"), made)
    assert (found["verdict"], found["reason"]) == ("not measurable here", "no graphics card")
    made.environment["device"]["kind"] = "gpu"
    assert judged(claim(FASTER, not_on_cpu="no graphics card"), made)["verdict"] == "confirmed"


def test_count_that_is_no_number_is_the_runs_fault():
    made = run(
        group(
            subject("dabt", [0.3] * 9, counters={"triangles": "many"}),
            subject("vst", [0.1] * 9, counters={"triangles": 400}),
        )
    )
    fewer = Comparison(Pick("dabt"), Pick("vst"), "fewer triangles", least=1.0)
    with pytest.raises(ValueError, match=r"run\.json: expected what claims compare, got TypeError"):
        judged(claim(fewer), made)


def test_every_claim_has_a_verdict_of_an_empty_run():
    found = verdicts(run())
    assert len(found) == len(CLAIMS) >= 20
    assert {one["verdict"] for one in found} == {NOT_IN_RUN, "not measurable here"}


def test_every_claim_is_decided_by_one_of_the_recorded_runs():
    """Rules name systems, columns and facts: a misspelt one would never find a row."""
    recorded = [read_run(folder) for folder in sorted(REFERENCE.glob("*/*"))]
    open_ones = {
        one["name"] for one in verdicts(recorded) if one["verdict"] in (NOT_IN_RUN, "undecided")
    }
    assert open_ones <= {"rc13_esc", "rc13_dice", "rc13_psnr", "dt07_linear"}
