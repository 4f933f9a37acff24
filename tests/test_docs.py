"""The guide says what is so: its code runs, what it names is there, and its pages are in the table of contents."""

import ast
import json
import pkgutil
import re
import runpy
import sys
from pathlib import Path

import pytest

from lodbench.datasets_gen import catalogue
from lodbench.harness.measure import limits
from lodbench.harness.plan.registry import systems
from tests.harness import fake
from tests.harness.shell import run

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = {
    str(path.relative_to(DOCS).with_suffix("")): path.read_text("utf-8")
    for path in DOCS.rglob("*.md")
    if "_build" not in path.parts
}
GUIDE = PAGES["guide"]
_script = runpy.run_path(str(DOCS / "pictures.py"))
commands, shown = _script["commands"], _script["shown"]


@pytest.mark.parametrize("page", [name for name, text in PAGES.items() if "```python" in text])
def test_code_of_a_page_runs_in_its_order(page, monkeypatch):
    monkeypatch.chdir(ROOT)
    names = {}
    for block in re.findall(r"(?s)```python\n(.*?)```", PAGES[page]):
        exec(block, names)


@pytest.mark.parametrize("page", ["guide", "adding"])
def test_commands_of_a_page_run(page, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(limits, "measure", lambda device: fake.LIMITS)
    monkeypatch.setattr(catalogue, "_own", {})
    for line in commands(PAGES[page]):
        quick = " --samples 2" if line.startswith("lodbench run") else ""
        code, _ = run(line + quick, monkeypatch)
        assert code == 0, f"{line}\n{capfd.readouterr().err}"


@pytest.mark.parametrize("page", [name for name in PAGES if name.startswith("systems/")])
def test_commands_beside_pictures_run_and_make_them(page, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    for line in commands(PAGES[page]):
        less = re.sub(r"--size \S+", "--size 40x32", line)  # the same in less time
        code, _ = run(less.replace("blob_with_ears_20k", "icosphere_4"), monkeypatch)
        assert code == 0, f"{line}\n{capfd.readouterr().err}"
    for name in shown(PAGES[page]):
        assert (tmp_path / name).exists(), f"no command makes {name}"
        assert (DOCS / "pictures" / name).exists(), f"make pictures: {name}"


def test_pictures_are_shown_and_small():
    files = sorted((DOCS / "pictures").iterdir())
    assert {path.name for path in files} == {
        name for text in PAGES.values() for name in shown(text)
    }
    assert sum(path.stat().st_size for path in files) < 1_000_000


def test_every_system_has_its_section_with_limits_and_source():
    found = {}
    for name, text in PAGES.items():
        if name.startswith("systems/"):
            parts = re.split(r"(?m)^## `(\w+)`$", text)
            found |= dict(zip(parts[1::2], parts[2::2], strict=True))
    ours = {name for name, system in systems().items() if system.family != "baselines"}
    assert set(found) == ours
    for name, text in found.items():
        assert "Source:" in text, name
        assert "**Limits.**" in text, name


def test_methods_of_the_guide_are_systems():
    (table,) = re.findall(r"(?s)\| you want \|.*?\n\n", GUIDE)
    named = set(re.findall(r"`(\w+)`", table)) - {"regions", "view", "warp", "tolerance"}
    assert named <= set(systems())


def test_every_page_is_in_the_table_of_contents():
    trees = re.findall(r"(?s)```\{toctree\}\n(.*?)```", PAGES["index"])
    named = [word for tree in trees for word in tree.split("\n") if word and word[0] != ":"]
    assert sorted(named) == sorted(PAGES.keys() - {"index"})


def test_interface_names_functions_that_are_there():
    for name in re.findall(r"(?m)^\.\. auto\w+:: (lodbench\.\S+)", PAGES["api"]):
        assert pkgutil.resolve_name(name).__doc__, name
    for module, names in re.findall(r"automodule:: (\S+)\n   :members: (.+)", PAGES["api"]):
        for name in names.split(", "):
            assert pkgutil.resolve_name(f"{module}:{name}").__doc__, name


def test_program_that_shows_the_drivers_defect_needs_no_lodbench():
    tree = ast.parse((DOCS / "driver_defect/pocl_builtins.py").read_text("utf-8"))
    imported = {
        alias.name for node in tree.body if isinstance(node, ast.Import) for alias in node.names
    }
    assert imported - sys.stdlib_module_names == {"numpy", "pyopencl"}
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


def test_page_on_faults_has_every_figure_of_the_record():
    assert "FIGURES" in PAGES["faults"]
    record = json.loads((ROOT / "results/reference/faults.json").read_text("utf-8"))
    script = runpy.run_path(str(DOCS / "faults.py"))
    rows = [line for line in script["tables"](record).splitlines() if line.startswith("| `")]
    named = set(record["systems"]) | set(record["readers"])
    assert named == {row.split("`")[1] for row in rows} & named
    assert set(record["faults"]) <= set(script["FAULTS"])
