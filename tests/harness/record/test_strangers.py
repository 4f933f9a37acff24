"""Run folders and files made by others: refused in one line or shown, never followed out of the folder."""

import copy
import json
import os
import random
import re
import shutil

import pytest

from lodbench.harness.cli.app import main
from lodbench.harness.plan import table as tables
from lodbench.harness.record.record import RUN, SAMPLES, read_run
from lodbench.harness.report import derive, plots
from lodbench.harness.report.page import write_report
from tests.harness.made_run import TABLES, edit_table, make_run

ODD = (
    None, True, -1, 0, 1e300, 10**400, 0.5, "", "x", "../../out", "/etc/passwd", "<script>alert(1)</script>", '"><b>',
    "$\\frac$", "[/]", [], {}, [[]], {"a": None}, [1, "x"],
)  # fmt: skip


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A small whole run: one group of each table, few samples."""
    folder = make_run(tmp_path_factory.mktemp("made") / "run")
    rows = [json.loads(line) for line in (folder / SAMPLES).read_text().splitlines()]
    keep = [r for r in rows if r.get("group") in (None, "c5", "p64-10") and r.get("turn", 0) < 6]
    (folder / SAMPLES).write_text("".join(json.dumps(row) + "\n" for row in keep))
    return folder


@pytest.fixture
def folder(made, tmp_path, monkeypatch):
    """A copy in a folder of its own, with the tables known and nothing drawn."""
    monkeypatch.setattr(tables, "tables", lambda: {one.id: one for one in TABLES})
    monkeypatch.setattr(plots, "CHARTS", {})
    shutil.copytree(made, tmp_path / "runs" / "run")
    return tmp_path / "runs" / "run"


def everything(folder):
    """All files and links of a folder with what they hold, but not those of the run itself."""
    return {
        path: os.readlink(path) if path.is_symlink() else path.is_file() and path.read_bytes()
        for path in folder.rglob("*")
        if folder / "runs" / "run" not in (path, *path.parents)
    }


def refused(capsys, *words):
    """The one line of a command that must fail."""
    assert main([str(word) for word in words]) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert "a fault in lodbench" not in line
    return line


def places(value, path=()):
    """Every place within a JSON value."""
    inner = {}
    if isinstance(value, dict | list):
        inner = value if isinstance(value, dict) else dict(enumerate(value))
    for key, item in inner.items():
        yield (*path, key)
        yield from places(item, (*path, key))


def changed(value, rng):
    """`value` with one field replaced, removed or added."""
    value = copy.deepcopy(value)
    at = rng.choice(list(places(value)))
    target = value
    for key in at[:-1]:
        target = target[key]
    if rng.random() < 0.2:
        del target[at[-1]]
    else:
        target[at[-1]] = rng.choice(ODD)
    return value


def lines_of(folder):
    return [json.loads(line) for line in (folder / SAMPLES).read_text().splitlines()]


def write_lines(folder, rows):
    (folder / SAMPLES).write_text("".join(json.dumps(row) + "\n" for row in rows))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("what", ["environment", "rows", "tables"])
def test_a_changed_field_is_taken_or_refused_by_name(
    folder, tmp_path, monkeypatch, capsys, what, seed
):
    if what == "tables":  # shown as they are found
        monkeypatch.setattr(derive, "write_tables", lambda folder: [])
    rng = random.Random(f"{what}{seed}")
    outside = everything(tmp_path)
    run, rows = json.loads((folder / RUN).read_text()), lines_of(folder)
    path = folder / "tables/clustering.json"
    table = json.loads(path.read_text())
    for _ in range(8):
        if what == "environment":
            (folder / RUN).write_text(json.dumps(changed(run, rng)))
            words = ["report", folder]
        elif what == "rows":
            number = rng.choice([rng.randrange(len(rows)), rng.randrange(4)])
            write_lines(folder, [*rows[:number], changed(rows[number], rng), *rows[number + 1 :]])
            words = rng.choice([["report", folder], ["compare", folder, folder]])
        else:
            path.write_text(json.dumps(changed(table, rng)))
            words = ["report", folder]
        code = main([str(word) for word in words])
        err = capsys.readouterr().err
        assert code in (0, 1, 2)
        if code == 2:
            (line,) = err.strip().splitlines()
            assert "a fault in lodbench" not in line
            assert re.search(r"run\.json|samples\.jsonl|tables/|expected a run that has rows", line)
        elif (folder / "report.html").exists():
            assert "<script>alert" not in (folder / "report.html").read_text()
            assert '"><b>' not in (folder / "report.html").read_text()
        assert everything(tmp_path) == outside


def test_table_under_the_name_of_another_is_refused(folder):
    edit_table(folder, "clustering", lambda made: made.update(id="patterns"))
    with pytest.raises(
        ValueError, match=r"clustering\.json: id: expected clustering, got patterns"
    ):
        write_report(folder)


def test_links_within_the_folder_and_to_it_are_followed(folder, tmp_path):
    (tmp_path / "link").symlink_to(folder)
    shutil.move(folder / SAMPLES, folder / "rows")
    (folder / SAMPLES).symlink_to("rows")
    assert len(read_run(tmp_path / "link").groups) == 2


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes in folders")
def test_pipe_in_place_of_the_rows_is_refused(folder, capsys):
    (folder / SAMPLES).unlink()
    os.mkfifo(folder / SAMPLES)
    assert "samples.jsonl: expected files and folders, got a pipe" in refused(
        capsys, "report", folder
    )


@pytest.mark.parametrize(
    ("name", "content", "text"),
    [
        (RUN, b"", "run.json: expected JSON"),
        (RUN, b"[1]", "run.json: expected an object, got [1]"),
        (RUN, b"\xff\xfe", "run.json: expected JSON"),
        (RUN, b'{"schema": NaN}', "NaN is no number"),
        (RUN, b"[" * 100_000, "run.json: expected JSON"),
        (RUN, b'{"schema": 1}', "run.json: expected the field started, got none"),
        (SAMPLES, b"3\n", "samples.jsonl: line 1: expected an object, got 3"),
        (SAMPLES, b"no\n{}", "samples.jsonl: line 1: expected JSON"),
        (SAMPLES, b'\n{"kind": "end"}\n', "samples.jsonl: line 2: expected the field group"),
        ("images/pictures.json", b'[{"file": 3}]', "pictures.json[0]: file: expected str, got 3"),
    ],
)
def test_broken_files_are_named_with_the_field(folder, capsys, name, content, text):
    (folder / name).parent.mkdir(exist_ok=True)
    (folder / name).write_bytes(content)
    assert text in refused(capsys, "report", folder)
    if "images" not in name:
        assert text in refused(capsys, "compare", folder, folder)


def test_deep_values_are_refused(folder, capsys):
    environment = json.loads((folder / RUN).read_text())
    inner = environment["machine"]
    for _ in range(20):
        inner["x"] = {}
        inner = inner["x"]
    (folder / RUN).write_text(json.dumps(environment))
    assert "run.json: expected at most 20 levels" in refused(capsys, "report", folder)


def test_names_are_shown_as_text_everywhere(folder, monkeypatch, capsys):
    monkeypatch.undo()
    monkeypatch.setattr(tables, "tables", lambda: {one.id: one for one in TABLES})
    odd = 'a$\\frac$ "><script>alert(1)</script>[/b]'
    rows = [
        row | {"subject": odd} if row.get("subject") == "pattern" else row
        for row in lines_of(folder)
    ]
    write_lines(folder, rows)
    environment = json.loads((folder / RUN).read_text())
    environment["options"]["tables"] = [odd]
    environment["packages"][odd] = odd
    (folder / RUN).write_text(json.dumps(environment))
    assert main(["report", str(folder)]) == 0
    page = (folder / "report.html").read_text()
    assert "alert(1)" in page
    assert "<script>alert" not in page
    assert '"><script' not in page.replace('<body>\n"', "")
    assert main(["compare", str(folder), str(folder)]) == 0
    assert odd in capsys.readouterr().out


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (b"name = '../out'", "name: expected a name of"),
        (b"name = 3", "name: expected a name of"),
        (b"params = 3", "params: expected dict, got 3"),
        (b"quality = 'yes'", "quality: expected bool, got 'yes'"),
        (b"devices = 'cpu'", "devices: expected a list, got 'cpu'"),
        (b"\xff", "expected TOML"),
        (b"x = " + b"[" * 5000, "expected TOML"),
    ],
)
def test_broken_sweep_files_are_named_with_the_key(tmp_path, capsys, content, text):
    path = tmp_path / "bad.toml"
    path.write_bytes(b"systems = ['pattern']\ndatasets = ['torus_20k']\n" + content)
    line = refused(capsys, "sweep", path, "--out", tmp_path / "run")
    assert line.startswith(f"error: {path}: ")
    assert text in line
    assert list(tmp_path.iterdir()) == [path]
