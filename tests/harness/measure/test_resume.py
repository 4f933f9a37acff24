import errno
import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from lodbench.harness.cli.app import main
from lodbench.harness.record import record
from lodbench.harness.record.samples import read_rows, rows_file
from tests.harness import fake

ROOT = Path(__file__).parents[3]
SECONDS = "0.01"  # of a fake frame: slow enough to be killed between two samples
DERIVED = ("wall_s", "ratio_to_", "status", "reason")


def lodbench(*words):
    return subprocess.Popen(
        [sys.executable, "-m", "tests.harness.fake_main", SECONDS, *map(str, words)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def rows(folder):
    path = rows_file(folder)
    return read_rows(path) if path.exists() else []


def wait_for(folder, enough, process):
    deadline = time.monotonic() + 60
    while not enough(rows(folder)):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.005)


def table(folder):
    """The table without what depends on time."""
    made = json.loads((folder / "tables/fake_table.json").read_text())
    for row in made["rows"]:
        for key in list(row):
            if key.startswith(DERIVED):
                del row[key]
    return made


def second_group_half_done(found):
    begun = [i for i, row in enumerate(found) if row["kind"] == "begin"]
    return len(begun) > 1 and any(row["kind"] == "sample" for row in found[begun[1] :])


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole") / "run"
    process = lodbench("reproduce", "--samples", 3, "--out", folder, "--quiet")
    out, err = process.communicate(timeout=120)
    assert process.returncode == 0, out + err
    return folder


def test_killed_run_goes_on_where_it_was(tmp_path, whole):
    folder = tmp_path / "run"
    words = ("reproduce", "--samples", 3, "--out", folder, "--quiet")
    process = lodbench(*words)
    wait_for(folder, second_group_half_done, process)
    process.kill()
    process.communicate()
    before = rows(folder)
    assert sum(row["kind"] == "end" for row in before) == 1
    with (folder / record.SAMPLES).open("ab") as file:
        file.write(b'{"kind": "sample", "gro')  # the kill may also come in the middle of a line

    process = lodbench(*words, "--resume")
    out, err = process.communicate(timeout=120)
    assert process.returncode == 0, out + err
    after = rows(folder)
    assert after[: len(before)] == before, "no written row is lost"
    begun = [(row["group"], row["attempt"]) for row in after if row["kind"] == "begin"]
    ended = [(row["group"], row["attempt"]) for row in after if row["kind"] == "end"]
    assert len(ended) == len({group for group, _ in ended}) == 3, "no whole group ran twice"
    cut = [(row["group"], row["attempt"]) for row in after if row["kind"] == "superseded"]
    assert cut == [begun[1]], "the group cut short is flagged"
    assert [group for group, _ in begun] == [begun[0][0], begun[1][0], begun[1][0], begun[3][0]]
    assert table(folder) == table(whole)


def test_interrupted_run_keeps_its_records_and_says_how_to_go_on(tmp_path):
    folder = tmp_path / "run"
    process = lodbench("reproduce", "--samples", 3, "--out", folder, "--quiet")
    wait_for(folder, second_group_half_done, process)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    (line,) = err.strip().splitlines()
    assert "kept" in line
    assert f"--resume --out {folder}" in line
    assert second_group_half_done(rows(folder))


def test_full_disk_keeps_its_records_and_says_how_to_go_on(tmp_path, monkeypatch, capsys):
    fake.install(monkeypatch.setattr)
    folder = tmp_path / "run"
    write = record.Writer.write

    def full(self, kind, **row):
        if kind == "end":
            raise OSError(errno.ENOSPC, "No space left on device")
        write(self, kind, **row)

    monkeypatch.setattr(record.Writer, "write", full)
    assert main(["reproduce", "--samples", "1", "--out", str(folder), "--quiet"]) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert "disk full" in line
    assert f"--resume --out {folder}" in line
    assert rows(folder)
