"""Examples run as they stand, those of every help in its order and those of the README, in a folder empty at first."""

import os
import re
import shutil
from pathlib import Path

import pytest
import typer

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.fetch import SCANS
from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.cli import app as cli
from lodbench.harness.measure import limits
from tests.harness import fake
from tests.harness.shell import run

cli._register()
LESS = {"run": " --samples 2", "geometry-image": " --level 6"}  # the same in less time
README = (Path(__file__).parents[3] / "README.md").read_text("utf-8")


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
            if words == "guard":  # which says nothing of time where others are at work
                patch.setattr("lodbench.harness.report.compare.NOISY_OTHERS", 2.0)
            if words == "compare":  # of two runs, made before and after a change
                shutil.copytree("run_a", "run_b")
            quick = LESS["run"] if words == "run" else ""
            code, said = run(line.replace("--samples 20", "--samples 2") + quick, patch)
        assert code == 0, f"{line}\n{capfd.readouterr().err}"
        assert said or ">" in line or "| " in line, line
    made = {"small.ply", "fine.ply", "small.png", "terrain.png", "ball.npz", "torus.ply", "run_a"}
    assert made <= set(os.listdir())


def test_commands_of_the_readme_run_as_they_stand(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(limits, "measure", lambda device: fake.LIMITS)
    monkeypatch.setattr(catalogue, "_own", {})
    lines = re.findall(r"(?m)^(lodbench [^#\n]+?)(?: +#.*)?$", README)
    assert len(lines) > 10
    for line in lines:
        with monkeypatch.context() as patch:
            if "reproduce" in line:  # minutes
                fake.install(patch.setattr)
            quick = next((less for word, less in LESS.items() if f"lodbench {word} " in line), "")
            code, _ = run(line + quick, patch)
        assert code == 0, f"{line}\n{capfd.readouterr().err}"


def test_calls_of_the_readme_run_as_they_stand():
    (code,) = re.findall(r"(?s)```python\n(.*?)```", README)
    ball = icosphere(2)
    names = {"points": ball.points, "faces": ball.triangles, "mesh": ball}
    exec(code.replace("5000", "50").replace("90, 90, 90", "9, 9, 9"), names)
    assert names["image"].shape == (1024, 1280, 3)
    assert len(names["result"].mesh.triangles) <= 50
