import gzip
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from lodbench.harness.record import record
from lodbench.harness.record import samples as rows_module
from lodbench.harness.record.record import Writer, attempts, plain, read_rows, read_run
from tests.harness.made_run import ENVIRONMENT

BEGIN = {"table": "t", "name": "n", "dataset": "d", "device": "x", "facts": {}, "config": {}}


def begin(writer, group="g", attempt=0):
    writer.write("begin", group=group, attempt=attempt, **BEGIN)


def sample(writer, turn, attempt=0, warmup=False):
    writer.write(
        "sample", group="g", attempt=attempt, subject="a", turn=turn, warmup=warmup, wall_s=1.0 * turn,
        cpu_s=1.0, load=0.0, stage_s={"x": 0.25, "y": 0.5},
    )  # fmt: skip


@pytest.fixture
def folder(tmp_path):
    record.write_json(tmp_path / "run.json", ENVIRONMENT)
    return tmp_path


def test_plain_turns_everything_into_json():
    @dataclass
    class Inner:
        values: tuple
        bad: float

    value = {
        "a": Inner((np.float32(1.5), np.int64(2)), float("nan")),
        3: np.arange(2),
        "p": Path("x"),
    }
    assert plain(value) == {"a": {"values": [1.5, 2], "bad": None}, "3": [0, 1], "p": "x"}
    json.dumps(plain(value), allow_nan=False)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf"), np.float32("inf")])
def test_plain_has_no_number_for_what_is_not_finite(value):
    assert plain({"a": [value, np.array([1, value])]}) == {"a": [None, [1, None]]}


def test_config_hash_ignores_order_and_tells_values_apart():
    assert record.config_hash({"a": 1, "b": (2,)}) == record.config_hash({"b": [2], "a": 1})
    assert record.config_hash({"a": 1}) != record.config_hash({"a": 2})


def test_reading_drops_a_torn_last_line_and_writing_goes_on_behind_it(folder):
    writer = Writer(folder)
    begin(writer)
    writer.close()
    path = folder / record.SAMPLES
    whole = path.read_bytes()
    path.write_bytes(whole + b'{"kind": "sample", "gro')
    assert len(read_rows(path)) == 1
    writer = Writer(folder)
    sample(writer, 1)
    assert [row["kind"] for row in read_rows(path)] == ["begin", "sample"]
    assert path.read_bytes().startswith(whole)


@pytest.mark.parametrize("lost", range(1, 60, 7))
def test_reading_and_writing_agree_wherever_a_kill_cut_the_last_row(folder, lost):
    writer = Writer(folder)
    begin(writer)
    writer.write("end", group="g", attempt=0, others=0.5)
    writer.close()
    path = folder / record.SAMPLES
    whole = path.read_bytes()
    path.write_bytes(whole[:-lost])
    read, ended = read_rows(path), attempts(folder)
    writer = Writer(folder)
    writer.write("superseded", group="other", attempt=0)
    writer.close()
    assert read_rows(path)[:-1] == read
    assert attempts(folder) == ended
    assert (len(read), ended[0]) == ((2, {"g"}) if lost == 1 else (1, set()))


def test_reading_refuses_garbage_before_the_last_line(folder):
    (folder / record.SAMPLES).write_bytes(
        b'{"kind": "superseded", "group": "g", "attempt": 0}\nnonsense\n{}\n'
    )
    with pytest.raises(ValueError, match="line 2"):
        read_rows(folder / record.SAMPLES)


def test_only_whole_groups_count_and_superseded_samples_stay_out(folder):
    writer = Writer(folder)
    begin(writer)
    sample(writer, 3)
    assert attempts(folder) == (set(), {"g": [0]})
    assert read_run(folder).groups == []
    writer.write("superseded", group="g", attempt=0)
    begin(writer, attempt=1)
    sample(writer, 0, attempt=1, warmup=True)
    sample(writer, 5, attempt=1)
    writer.write("subject", group="g", attempt=1, subject="a", status="ok", reason="")
    writer.write("end", group="g", attempt=1, others=0.5)
    assert attempts(folder) == ({"g"}, {"g": []})
    (group,) = read_run(folder).of_table("t")
    assert group.others == 0.5
    subject = group.subjects["a"]
    assert subject.status == "ok"
    assert subject.wall_s == {5: 5.0}
    assert len(subject.warmups) == 1
    assert subject.stages == ["x", "y"]
    assert (subject.stage_s("x"), subject.stage_s()) == ([0.25], [0.75])


def test_read_run_refuses_other_folders_and_schemas(tmp_path):
    with pytest.raises(ValueError, match=r"expected a folder with run\.json"):
        read_run(tmp_path)
    record.write_json(tmp_path / "run.json", {"schema": record.SCHEMA + 1})
    with pytest.raises(ValueError, match="expected schema"):
        read_run(tmp_path)


def test_write_json_leaves_the_old_file_when_the_value_cannot_be_written(tmp_path):
    path = tmp_path / "x.json"
    record.write_json(path, {"a": 1})
    with pytest.raises(RecursionError):
        loop = []
        loop.append(loop)
        record.write_json(path, loop)
    assert json.loads(path.read_text()) == {"a": 1}
    assert list(tmp_path.iterdir()) == [path]


def test_rows_are_packed_and_unpacked_byte_for_byte(folder):
    writer = Writer(folder)
    begin(writer)
    writer.close()
    path = folder / record.SAMPLES
    whole, rows = path.read_bytes(), read_rows(path)
    rows_module.pack(folder)
    assert not path.exists()
    packed = rows_module.rows_file(folder)
    assert packed.name == "samples.jsonl.gz" and read_rows(packed) == rows
    first = packed.read_bytes()
    writer = Writer(folder)
    writer.close()
    assert path.read_bytes() == whole and not packed.exists()
    rows_module.pack(folder)
    assert packed.read_bytes() == first, "the same rows, the same bytes"


@pytest.mark.parametrize(
    ("content", "what"),
    [(b"no", "packed by gzip"), (gzip.compress(b"{}\n" * 99, mtime=0)[:-9], "packed by gzip")],
)
def test_packed_rows_that_are_damaged_are_named(folder, content, what):
    path = folder / rows_module.PACKED
    path.write_bytes(content)
    with pytest.raises(ValueError, match=what):
        read_rows(path)


def test_small_file_that_unpacks_to_more_than_a_run_holds_is_refused(folder, monkeypatch):
    monkeypatch.setattr(rows_module, "LARGEST", 1000)
    path = folder / rows_module.PACKED
    path.write_bytes(gzip.compress(b" " * 100_000))
    with pytest.raises(ValueError, match="expected at most 1,000 bytes of rows"):
        read_rows(path)
