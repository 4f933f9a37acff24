"""Runs' folders that someone else made, or broke: one line names file and field, and nothing outside is touched."""

import json
import random
import shutil
from pathlib import Path

import pytest

from lodbench.harness.cli.app import main
from lodbench.harness.record import foreign
from lodbench.harness.record.record import RUN, SAMPLES, read_run
from lodbench.harness.report import plots
from lodbench.harness.report.plots import documents
from tests.harness.made_run import make_run

REFERENCE = Path(__file__).parents[3] / "results" / "reference"
NASTY = (
    None,
    -1,
    1.5,
    True,
    "",
    "../../evil",
    "<script>alert(1)</script>",
    [],
    {},
    [[]],
    {"a": {}},
    "x" * 999,
)


@pytest.fixture(scope="module")
def pristine(tmp_path_factory):
    return make_run(tmp_path_factory.mktemp("pristine") / "run")


@pytest.fixture
def folder(pristine, tmp_path):
    return shutil.copytree(pristine, tmp_path / "home" / "run")


def change(path, edit):
    made = json.loads(path.read_text())
    edit(made)
    path.write_text(json.dumps(made))


def change_rows(folder, edit):
    path = folder / SAMPLES
    rows = [json.loads(line) for line in path.read_text().splitlines()]
    for row in rows:
        edit(row)
    path.write_text("".join(json.dumps(row) + "\n" for row in rows))


def places(value, path=()):
    """Every (path of keys) inside a JSON value."""
    inside = (
        value.items()
        if isinstance(value, dict)
        else enumerate(value)
        if isinstance(value, list)
        else ()
    )
    for key, item in inside:
        yield (*path, key)
        yield from places(item, (*path, key))


def spoil(value, rng):
    """One field taken out or replaced by something nasty."""
    *way, last = rng.choice(list(places(value)))
    for key in way:
        value = value[key]
    if rng.random() < 0.3:
        del value[last]
    else:
        value[last] = rng.choice(NASTY)


def outside(folder):
    return sorted(path for path in folder.parents[1].rglob("*") if folder not in path.parents)


def one_line(capsys):
    (line,) = capsys.readouterr().err.strip().splitlines()
    return line


@pytest.mark.parametrize("seed", range(40))
def test_spoilt_record_ends_in_one_line_or_is_read(folder, pristine, seed, capsys):
    rng = random.Random(seed)
    if seed % 4 == 0:
        change(folder / RUN, lambda made: spoil(made, rng))
    else:
        lines = (folder / SAMPLES).read_text().splitlines()
        at = rng.randrange(len(lines))
        row = json.loads(lines[at])
        spoil(row, rng)
        lines[at] = json.dumps(row)
        (folder / SAMPLES).write_text("\n".join(lines) + "\n")
    before = outside(folder)
    code = main(["compare", str(pristine), str(folder)])
    said = capsys.readouterr()
    assert code in (0, 1, 2)
    assert "fault in lodbench" not in said.err
    assert len(said.err.strip().splitlines()) == (code == 2)
    assert outside(folder) == before


@pytest.mark.parametrize("name", ["../../evil", "/tmp/evil", "a b", "", "A", "<b>", ".."])
def test_table_name_that_is_no_name_is_refused(folder, name, capsys):
    def rename(row):
        if row["kind"] == "begin":
            row["table"] = name

    change_rows(folder, rename)
    before = outside(folder)
    assert main(["report", str(folder)]) == 2
    line = one_line(capsys)
    assert SAMPLES in line
    assert "table: expected a name of" in line
    assert outside(folder) == before


def test_sweep_of_a_record_is_checked_as_one_of_a_file(folder, capsys):
    def rename(row):
        if row["kind"] == "begin":
            row["table"] = "mine"

    change_rows(folder, rename)
    change(folder / RUN, lambda made: made["options"].update(sweep={"name": "mine", "systems": 3}))
    assert main(["report", str(folder)]) == 2
    assert "systems: expected a list of names, got 3" in one_line(capsys)


@pytest.mark.parametrize("what", ["tables", "figures", "images", "report.html", "samples.jsonl"])
def test_link_out_of_the_folder_is_refused(folder, what, capsys, tmp_path):
    secret = tmp_path / "secret"
    secret.mkdir()
    (secret / "note").write_text("private")
    path = folder / what
    shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
    path.symlink_to(secret if "." not in what else secret / "note")
    for words in (["report", str(folder)], ["compare", str(folder), str(folder)]):
        assert main(words) == 2
        assert "got a link out of" in one_line(capsys)
    assert [p.name for p in secret.iterdir()] == ["note"]
    assert (secret / "note").read_text() == "private"


def test_markup_in_a_record_is_text_in_the_report(folder, monkeypatch):
    # one kind of chart suffices: what is drawn is matplotlib's to escape
    monkeypatch.setattr(plots, "CHARTS", dict([next(iter(plots.CHARTS.items()))]))
    bad = '<img src=x onerror="alert(1)">'

    def spread(row):
        if row["kind"] == "subject":
            row["status"], row["reason"] = "failed", bad
        if row["kind"] == "begin":
            row["dataset"] = row["facts"]["dataset"] = bad

    change_rows(folder, spread)
    change(folder / RUN, lambda made: made["machine"].update(cpu=bad))
    for path in (folder / "tables").glob("*.json"):
        change(path, lambda made: made.update(title=bad, notes=[bad]))
    assert main(["report", str(folder)]) == 0
    text = (folder / "report.html").read_text()
    assert bad not in text
    assert "&lt;img src=x" in text


def test_broken_table_and_picture_list_are_named(folder, capsys):
    path = next((folder / "tables").glob("*.json"))
    change(path, lambda made: made["columns"][0].update(key=7))
    with pytest.raises(ValueError, match=rf"{path.name}: columns\[0\]: key: expected a name"):
        documents(folder)
    (folder / "images").mkdir(exist_ok=True)
    (folder / "images" / "pictures.json").write_text('[{"file": 3}]')
    with pytest.raises(ValueError, match=r"pictures.json\[0\]: file: expected str, got 3"):
        foreign.read_json(folder / "images" / "pictures.json", foreign.PICTURE_FIELDS)


@pytest.mark.parametrize(
    "path", sorted(REFERENCE.glob("*/*/run.json")), ids=lambda p: p.parent.name
)
def test_committed_runs_are_read(path):
    assert read_run(path.parent).groups
    assert documents(path.parent)


def test_rows_say_line_and_field():
    with pytest.raises(ValueError, match="line 4: expected the field group, got none"):
        foreign.check_row({"kind": "superseded", "attempt": 0}, "line 4")
    with pytest.raises(ValueError, match="line 4: kind: expected one of begin"):
        foreign.check_row({"kind": "began"}, "line 4")
    with pytest.raises(ValueError, match=r"line 4: expected an object, got \[1\]"):
        foreign.check_row([1], "line 4")
    with pytest.raises(ValueError, match="attempt: expected int, got True"):
        foreign.check_row({"kind": "superseded", "group": "g", "attempt": True}, "line 4")
