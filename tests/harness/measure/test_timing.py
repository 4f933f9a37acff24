import numpy as np
import pytest

from lodbench.harness.measure import timing
from lodbench.harness.measure.budget import Budget
from lodbench.harness.measure.precision import half_width
from lodbench.harness.measure.timing import interleave, quota
from lodbench.kernels.system import Timeline


def frame(wall=0.0):
    timeline = Timeline()
    timeline.wall_s = wall
    return lambda: timeline


def test_quota_slow_subjects_take_fewer_samples():
    assert quota(0.1, None) == (3, 10)
    assert quota(0.001, None) == (3, timing.MOST_SAMPLES)
    assert quota(2.5, None) == (1, 3)
    assert quota(2.5, 20) == (1, 3)
    assert quota(31.0, None) == (0, 1)
    assert quota(0.1, 5) == (3, 5)


def test_interleave_takes_turns_and_starts_to_count_at_the_same_turn():
    taken = list(interleave({"a": frame(), "b": frame()}, {"a": 0.1, "b": 3.0}, samples=4))
    assert [(s.subject, s.turn) for s in taken if s.warmup] == [("a", 1), ("a", 2)]
    counted = [(s.subject, s.turn) for s in taken if not s.warmup]
    assert counted == [("a", 3), ("b", 3), ("a", 4), ("b", 4), ("a", 5), ("b", 5), ("a", 6)]


def test_interleave_leaves_out_a_subject_whose_first_frame_was_its_only_sample():
    taken = list(interleave({"a": frame(), "b": frame()}, {"a": 0.1, "b": 40.0}, samples=2))
    assert {sample.subject for sample in taken} == {"a"}


def test_interleave_drops_a_subject_that_gives_up():
    left = iter([Timeline(), None])
    taken = list(interleave({"a": lambda: next(left), "b": frame()}, {"a": 0.1, "b": 0.1}))
    assert [sample.subject for sample in taken].count("a") == 1
    assert [sample.subject for sample in taken].count("b") == 12


def test_warm_samples_follow_on_frames_that_are_not_counted(monkeypatch):
    monkeypatch.setattr("lodbench.harness.measure.timing.WARM_S", 0.0)
    seconds = iter(np.arange(100.0))
    taken = list(
        interleave({"a": lambda: frame(next(seconds))()}, {"a": 0.1}, samples=3, warm=True)
    )
    assert [sample.wall_s for sample in taken] == [1, 3, 5, 7, 9]
    left = iter([Timeline(), None])
    assert not list(interleave({"a": lambda: next(left)}, {"a": 0.1}, samples=3, warm=True))[1:]


def test_warm_samples_begin_when_no_thread_computes(monkeypatch):
    cpu = iter([0.0, 0.9, 1.0, 1.7, 2.0, 2.1])  # milliseconds, before and after each look
    looks = []
    monkeypatch.setattr(timing.time, "process_time", lambda: next(cpu) / 1000)
    monkeypatch.setattr(timing.time, "sleep", looks.append)
    timing.calm()
    assert looks == [timing.CALM_S] * 3


def test_interleave_with_no_time_left_still_gives_every_subject_one_counted_sample():
    taken = list(interleave({"a": frame(), "b": frame()}, {"a": 1, "b": 1}, budget=Budget(0.0)))
    assert [s.subject for s in taken if not s.warmup] == ["a", "b"]


def noisy(seed, sigma, base=1e-4):
    """Frames of about `base` seconds, as lognormal noise of `sigma` has them."""
    rng = np.random.default_rng(seed)

    def run():
        timeline = Timeline()
        timeline.wall_s = base * float(rng.lognormal(sigma=sigma))
        return timeline

    return run


def counted(frames, **options):
    taken = list(interleave(frames, dict.fromkeys(frames, 0.1), **options))
    return {name: [s for s in taken if s.subject == name and not s.warmup] for name in frames}


def test_sampling_goes_on_until_each_ratio_to_the_first_is_narrow():
    frames = {"a": noisy(0, 0.01), "b": noisy(1, 0.01), "c": noisy(2, 0.2)}
    found = counted(frames, narrow=0.05)
    assert len(found["b"]) == timing.SAMPLES, "narrow from the beginning"
    assert timing.SAMPLES < len(found["c"]) < timing.MOST_TURNS
    first = {s.turn: s.wall_s for s in found["a"]}
    assert {s.turn for s in found["c"]} <= set(first), "each has its partner in the same turn"
    pairs = [s.wall_s / first[s.turn] for s in found["c"]]
    assert half_width(pairs) <= 0.05 < half_width(pairs[:-1])


def test_sampling_ends_at_its_most_turns_where_a_ratio_stays_wide():
    found = counted({"a": noisy(0, 0.01), "b": noisy(1, 3.0)}, narrow=0.001)
    assert len(found["b"]) <= timing.SAMPLES + timing.MOST_TURNS


@pytest.mark.parametrize("options", [{}, {"narrow": 0.0}, {"narrow": 0.01, "samples": 10}])
def test_exact_number_of_samples_stays_exact(options):
    found = counted({"a": noisy(0, 0.5), "b": noisy(1, 0.5)}, **options)
    assert {len(samples) for samples in found.values()} == {10}


def test_budget_ends_it_and_is_not_cut_by_that():
    budget = Budget(1000.0)
    found = counted(
        {"a": noisy(0, 0.5, 900.0), "b": noisy(1, 0.5, 900.0)}, narrow=0.01, budget=budget
    )
    assert len(found["a"]) == 1 and budget.cut  # the quota itself did not fit
    budget = Budget(1000.0)
    found = counted(
        {"a": noisy(0, 0.01, 40.0), "b": noisy(1, 2.0, 40.0)}, narrow=1e-9, budget=budget
    )
    assert len(found["a"]) == len(found["b"])
    quick = Budget(30.0)
    found = counted({"a": noisy(0, 0.0, 1.0), "b": noisy(1, 0.5, 1.0)}, narrow=0.01, budget=quick)
    assert len(found["b"]) > timing.SAMPLES and not quick.cut


def test_single_subject_goes_on_for_its_own_median():
    found = counted({"a": noisy(0, 0.2)}, narrow=0.05)
    assert len(found["a"]) > timing.SAMPLES
    assert half_width([s.wall_s for s in found["a"]]) <= 0.05


def test_peak_memory_sees_what_was_freed_again():
    peak = timing.PeakMemory()
    np.ones(1 << 23)  # 64 MiB, written and gone: more than an allocator keeps for itself
    growth = peak.growth_bytes()
    assert growth is None or growth > 60 << 20
