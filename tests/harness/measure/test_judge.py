from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.measure import quality
from lodbench.harness.measure.judge import Judge
from lodbench.harness.measure.trial import Trial
from lodbench.harness.plan.group import Group, Subject
from lodbench.kernels.opencl import Unsupported
from tests.harness.measure.test_nested import refined

BALL = icosphere(0)


def trials(**meshes):
    return {name: Trial(Subject(name), mesh=mesh) for name, mesh in meshes.items()}


def test_each_result_is_compared_with_the_reference_and_that_with_nothing():
    group = Group("one", (), reference="fine")
    made = trials(coarse=refined(BALL, 2), odd=refined(BALL, 3), fine=refined(BALL, 4))
    judge = Judge()
    for name in made:
        judge(group, BALL, name, made, 0)
    assert made["coarse"].facts["quality"].keys() == {
        "rms_difference", "max_difference", "compared_points",
    }  # fmt: skip
    assert made["fine"].facts["quality"] is None
    assert made["odd"].status == "failed", "three segments are not nested in four"
    assert "segments" in made["odd"].reason


def test_reference_without_a_result_leaves_the_others_without_a_difference():
    made = trials(coarse=refined(BALL, 2), fine=None)
    Judge()(Group("one", (), reference="fine"), BALL, "coarse", made, 0)
    assert (made["coarse"].status, made["coarse"].facts["quality"]) == ("ok", None)


def test_distance_to_the_input_is_measured_once_for_the_same_mesh(monkeypatch):
    calls = []
    monkeypatch.setattr(quality, "measure", lambda *a: calls.append(a) or {"rms_error": 1.0})
    made, judge = trials(one=BALL, two=BALL), Judge()
    for name in made:
        judge(Group("one", (), quality=True), BALL, name, made, 0)
    assert [one.facts["quality"]["rms_error"] for one in made.values()] == [1.0, 1.0]
    assert len(calls) == 1
    judge(Group("one", (), quality=True), BALL, "one", made, 1)
    judge.forget()
    judge(Group("one", (), quality=True), BALL, "one", made, 1)
    assert len(calls) == 3, "another seed, and another input"


def test_without_libigl_the_counts_are_there(monkeypatch):
    def missing(*arguments):
        raise Unsupported("no libigl")

    monkeypatch.setattr(quality, "measure", missing)
    made = trials(one=BALL)
    Judge()(Group("one", (), quality=True), BALL, "one", made, 0)
    assert made["one"].facts["quality"] == quality.topology(BALL)
