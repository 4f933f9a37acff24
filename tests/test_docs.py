"""The guide says what is so: its code runs, what it names is there, and its pages are in the table of contents."""

import ast
import re
from pathlib import Path

import pytest

from lodbench.datasets_gen import catalogue
from lodbench.harness.measure import limits
from lodbench.harness.plan.registry import systems
from tests.harness import fake
from tests.harness.shell import run

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
GUIDE = (DOCS / "guide.md").read_text("utf-8")


def test_code_of_the_guide_runs_in_its_order(monkeypatch):
    monkeypatch.chdir(ROOT)
    names = {}
    blocks = re.findall(r"(?s)```python\n(.*?)```", GUIDE)
    assert len(blocks) > 3
    for block in blocks:
        exec(block, names)


def test_commands_of_the_guide_run(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(limits, "measure", lambda device: fake.LIMITS)
    monkeypatch.setattr(catalogue, "_own", {})
    lines = re.findall(r"(?m)^lodbench .+$", GUIDE)
    assert len(lines) == 2
    for line in lines:
        code, _ = run(
            line + (" --samples 2" if line.startswith("lodbench run") else ""), monkeypatch
        )
        assert code == 0, f"{line}\n{capfd.readouterr().err}"
    assert (tmp_path / "time.svg").exists()


def test_methods_of_the_guide_are_systems():
    (table,) = re.findall(r"(?s)\| you want \|.*?\n\n", GUIDE)
    named = set(re.findall(r"`(\w+)`", table)) - {"max_error", "regions", "view", "warp"}
    assert named <= set(systems())


def test_every_page_is_in_the_table_of_contents():
    pages = {
        str(path.relative_to(DOCS).with_suffix(""))
        for path in DOCS.rglob("*.md")
        if "_build" not in path.parts
    }
    (tree,) = re.findall(r"(?s)```\{toctree\}\n(.*?)```", (DOCS / "index.md").read_text("utf-8"))
    assert pages - {"index"} == set(tree.split())


def test_interface_names_functions_that_are_there():
    from lodbench.kernels import api

    (names,) = re.findall(r":members: (.+)", (DOCS / "api.md").read_text("utf-8"))
    for name in names.split(", "):
        assert callable(getattr(api, name)) and getattr(api, name).__doc__


def test_program_that_shows_the_drivers_defect_needs_no_lodbench():
    tree = ast.parse((DOCS / "driver_defect/pocl_builtins.py").read_text("utf-8"))
    imported = {
        alias.name for node in tree.body if isinstance(node, ast.Import) for alias in node.names
    }
    assert imported == {"sys", "numpy", "pyopencl"}
    assert not [node for node in tree.body if isinstance(node, ast.ImportFrom)]


@pytest.mark.parametrize(
    "key", ["cff-version", "message", "title", "authors", "version", "license"]
)
def test_citation_has_what_its_format_asks_for(key):
    text = (ROOT / "CITATION.cff").read_text("utf-8")
    assert re.search(rf"(?m)^{key}:", text)
    version = re.search(r'(?m)^version = "(.+)"', (ROOT / "pyproject.toml").read_text("utf-8"))
    assert version and f"\nversion: {version[1]}\n" in text
    assert f"\n## {version[1]}\n" in (ROOT / "CHANGELOG.md").read_text("utf-8")
