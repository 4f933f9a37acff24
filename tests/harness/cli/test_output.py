import io
import os
import re
import subprocess
import sys

import pytest

from lodbench.harness.cli import output as terminal
from lodbench.harness.cli.app import main

SYSTEMS = ("quadric_clustering", "numpy_quadric_clustering")
COLUMNS = [
    {"key": key, "label": label, "unit": unit}
    for key, label, unit in (
        ("dataset", "dataset", ""),
        ("triangles_in", "triangles in", ""),
        ("system", "system", ""),
        ("wall_s", "median wall", "s"),
        ("rms_error", "RMS error", "1"),
        ("open_edges", "open edges", ""),
        ("reason", "reason", ""),
    )
]


class Screen(io.StringIO):
    def isatty(self):
        return True


def rows(*datasets):
    return [
        {"dataset": dataset, "triangles_in": 1_310_720, "system": system, "wall_s": 0.01204,
         "rms_error": 2.69e-5, "open_edges": 0, "reason": "the machine was busy with something else"}
        for dataset in datasets for system in SYSTEMS
    ]  # fmt: skip


@pytest.fixture
def screen(monkeypatch):
    """Shows rows on a terminal of some columns; gives its lines."""

    def show(width, shown, columns=COLUMNS):
        monkeypatch.setenv("COLUMNS", str(width))
        monkeypatch.setenv("TERM", "xterm")
        stream = Screen()
        monkeypatch.setattr(sys, "stdout", stream)
        terminal.say_rows(columns, shown, "A title")
        plain = re.sub(r"\x1b\[[0-9;]*m", "", stream.getvalue())
        return [line.rstrip() for line in plain.splitlines()]

    return show


@pytest.mark.parametrize("width", [60, 80, 100, 120])
@pytest.mark.parametrize(
    "datasets", [["torus_20k"], ["torus_20k", "displaced_icosphere_1310k_sorted"]]
)
def test_no_name_or_number_is_broken_on_a_terminal(screen, width, datasets):
    lines = screen(width, rows(*datasets))
    assert max(map(len, lines)) <= width
    words = " ".join(lines)
    for whole in (*datasets, *SYSTEMS, "1,310,720", "12.04 ms", "2.69e-5"):
        assert whole in words
    assert words.count("A title") == 1


def test_each_part_of_a_wide_table_names_its_rows(screen):
    lines = screen(80, rows("torus_20k", "displaced_icosphere_1310k_sorted"))
    heads = [line for line in lines if line.split()[:1] == ["dataset"]]
    assert len(heads) > 1
    assert all("system" in head for head in heads)


def test_name_that_all_rows_share_is_said_once(screen):
    lines = screen(80, rows("torus_20k"))
    heads = [line.split() for line in lines if "system" in line.split()]
    assert len(heads) > 1
    assert sum("dataset" in head for head in heads) == 1


def test_table_that_fits_is_one_and_in_order(screen):
    lines = screen(200, rows("torus_20k"))
    (head,) = [line for line in lines if "dataset" in line]
    assert head.split()[:5] == ["dataset", "triangles", "in", "system", "median"]


def test_rows_without_any_value_say_nothing_wrong(screen):
    assert "A title" in " ".join(screen(80, []))


def test_pipe_has_one_line_per_row(monkeypatch):
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stdout", stream)
    terminal.say_rows(COLUMNS, rows("torus_20k"))
    assert len([line for line in stream.getvalue().splitlines() if "torus_20k" in line]) == 2


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "cp1252", "cp437", "cp850", "utf-8"])
def test_any_character_set_can_be_written(monkeypatch, encoding):
    stream = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    monkeypatch.setattr(sys, "stdout", stream)
    terminal.say_in_any_encoding()
    terminal.say_rows(COLUMNS, [{"system": "fake", "wall_s": 12e-6, "reason": None}], "A − title")
    terminal.say("12 µs – 4 × 4, \udcff")
    stream.flush()
    text = stream.buffer.getvalue().decode(encoding)
    assert "12 us" in text or "12 µs" in text


def test_micro_is_spelled_where_it_is_lacking(monkeypatch):
    stream = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr(sys, "stdout", stream)
    terminal.say_in_any_encoding()
    terminal.say("12 µs, 4 × 4 – κ")
    stream.flush()
    assert stream.buffer.getvalue() == b"12 us, 4 x 4 - ?\n"


@pytest.mark.parametrize("words", [["--help"], ["run", "--help"], ["list", "datasets"]])
def test_ascii_shell_reads_everything(words):
    environment = {**os.environ, "PYTHONIOENCODING": "ascii", "LC_ALL": "C"}
    command = [sys.executable, "-m", "lodbench.harness", *words]
    done = subprocess.run(command, env=environment, capture_output=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert done.stdout.isascii()


@pytest.mark.parametrize("word", ["--version", "-V"])
def test_version_is_said(capsys, word):
    assert main([word]) == 0
    name, version = capsys.readouterr().out.split()
    assert name == "lodbench"
    assert version.count(".") == 2
