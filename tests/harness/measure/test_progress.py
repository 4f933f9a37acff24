import pytest

from lodbench.harness.measure.progress import Progress, duration


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.2, "0 s"), (59.4, "59 s"), (200, "3 min 20 s"), (7500, "2 h 05 min")],
)
def test_duration_is_said_in_two_units_at_most(seconds, words):
    assert duration(seconds) == words


def test_progress_elsewhere_than_on_a_terminal_is_plain_lines(capsys):
    with Progress(4) as progress:
        progress.task("first")
        progress.step("a step")
        progress.advance(1)
        progress.task("second")
    lines = capsys.readouterr().err.splitlines()
    assert lines[0].split() == ["0%", "first"]
    assert lines[1].split()[:2] == ["25%", "second"]
    assert lines[1].endswith("left")
    assert len(lines) == 2


def test_quiet_progress_says_nothing(capsys):
    with Progress(1, quiet=True) as progress:
        progress.task("first")
    assert capsys.readouterr().err == ""


def test_kept_work_tells_nothing_about_the_time_left():
    with Progress(2, quiet=True) as progress:
        progress.advance(1, kept=True)
        assert progress.left() == ""
