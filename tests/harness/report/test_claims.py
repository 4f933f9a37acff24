import pytest

from lodbench.harness.claims import CLAIMS, Claim, Comparison, Pick
from lodbench.harness.plan.registry import systems
from lodbench.harness.report.claims import judged, verdicts
from tests.harness.records import group, run, subject

FASTER = Comparison(Pick("gst", {"reuse": "row"}), Pick("gst", {"reuse": "none"}), least=1.0)


def claim(*comparisons, **more):
    return Claim("a", "one is faster", "a paper", comparisons, **more)


def reuse(row, none, **facts):
    return group(
        subject("gst", row, params={"reuse": "row"}),
        subject("other", none, params={"reuse": "none"}, system="gst"),
        **facts,
    )


def test_claims_are_different_and_speak_of_systems_that_may_be_there():
    assert len({one.name for one in CLAIMS}) == len(CLAIMS)
    coming = {"dabt", "semi_adaptive"}
    for one in CLAIMS:
        assert one.comparisons and one.text and one.source
        for comparison in one.comparisons:
            assert (comparison.least is None) != (comparison.most is None)
            for pick in (comparison.subject, comparison.other):
                assert pick.system in {*systems(), *coming}
                found = systems().get(pick.system)
                for key in pick.params if found else ():
                    assert hasattr(next(iter(found.cases.values())), key)


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
    assert found["measured"] == "0.667 to 2 times faster (0.667 to 2)"
    assert found["published"] == "3 times"


def test_verdict_without_subjects_names_them_and_failed_ones_do_not_count():
    bad = group(
        subject("gst", [0.1] * 9, params={"reuse": "row"}),
        subject("none", [0.1] * 9, params={"reuse": "none"}, system="gst", status="failed"),
    )
    for made in (run(), run(bad)):
        found = judged(claim(FASTER, note="a note"), made)
        assert found["verdict"] == "not measurable here" and found["measured"] is None
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
    assert found["measured"] == "4 times fewer triangles; 0.333 times faster (0.333)"
    faster = Comparison(Pick("dabt"), Pick("vst"), least=1.0)
    assert judged(claim(fewer, faster), made)["verdict"] == "refuted"


def test_frames_are_those_drawn_apart_or_whole_samples():
    drawn = {"subjects": [{"label": name, "draw": {"apart": False}} for name in ("a", "b")]}
    made = run(group(subject("a", [0.1] * 9), subject("b", [0.2] * 9), config=drawn))
    frames = Comparison(Pick("a"), Pick("b"), "frames faster", least=1.5)
    assert judged(claim(frames), made)["verdict"] == "confirmed"
    samples = Comparison(Pick("a"), Pick("b"), least=1.5)
    assert judged(claim(samples), made)["verdict"] == "not measurable here"


def test_subjects_on_one_core_are_left_out():
    config = {"subjects": [{"label": "b", "one_core": True}]}
    made = run(group(subject("a", [0.1] * 9), subject("b", [0.2] * 9), config=config))
    samples = Comparison(Pick("a"), Pick("b"), least=1.5)
    assert judged(claim(samples), made)["verdict"] == "not measurable here"


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


def test_every_claim_has_a_verdict_of_an_empty_run():
    assert {one["verdict"] for one in verdicts(run())} == {"not measurable here"}
