"""Every example of every help, run as it stands: in the order of the help, in one folder, empty at first."""

import io
import os
import re
import shlex
import shutil
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
import typer

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.fetch import SCANS
from lodbench.harness import cli, limits
from tests.harness import fake

cli._register()


def walk(command, words=()):
    """(words, help) of every command, in the order of the help."""
    children = getattr(command, "commands", {})
    if not children:
        yield " ".join(words), command.help
    for name, child in children.items():
        yield from walk(child, (*words, name))


HELP = dict(walk(typer.main.get_command(cli.app)))
EXAMPLES = [
    (words, line)
    for words, text in HELP.items()
    for line in re.findall(r"(?m)^(?:Example|Piped): (.+)$", text)
]


class Bytes(io.TextIOWrapper):
    """A standard stream that is no terminal."""

    def __init__(self, data=b""):
        super().__init__(io.BytesIO(data), encoding="utf-8")


def run(line, monkeypatch):
    """What a shell does with `a | b < file > file`; the exit code and output of the last."""
    data = b""
    for stage in line.split("|"):
        words = shlex.split(stage)
        out = Path(words.pop(words.index(">") + 1)) if ">" in words else None
        if "<" in words:
            data = Path(words.pop(words.index("<") + 1)).read_bytes()
        name, *words = [word for word in words if word not in "<>"]
        assert name == "lodbench"
        monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(data), isatty=bool))
        monkeypatch.setattr(sys, "stdout", stdout := Bytes())
        code = cli.main(words)
        stdout.flush()
        data = stdout.buffer.getvalue()
        if out:
            out.write_bytes(data)
    return code, data


@pytest.mark.parametrize("words", HELP)
def test_every_command_has_an_example_of_itself(words):
    assert f"Example: lodbench {words}" in HELP[words]


def test_examples_run_as_they_stand(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(limits, "measure", lambda device: fake.LIMITS)
    monkeypatch.setattr(catalogue, "fetch", lambda names, say: [Path(SCANS[n].name) for n in names])
    monkeypatch.setattr(catalogue, "_own", {})
    toml = re.findall(r"(?m)^(?:systems|datasets|params) = .+$", HELP["sweep"])
    Path("grids.toml").write_text("\n".join(toml))
    for words, line in EXAMPLES:
        with monkeypatch.context() as patch:
            if words == "reproduce":  # minutes
                fake.install(patch.setattr)
            if words == "compare":  # of two runs, made before and after a change
                shutil.copytree("run_a", "run_b")
            code, said = run(line.replace("--samples 20", "--samples 2"), patch)
        assert code == 0, f"{line}\n{capfd.readouterr().err}"
        assert said or ">" in line or "| " in line, line
    made = {"small.ply", "fine.ply", "small.png", "terrain.png", "ball.npz", "torus.ply", "run_a"}
    assert made <= set(os.listdir())
