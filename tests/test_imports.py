"""The import graph: no circles, no arrows upwards, no system that knows of another family's."""

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FAMILIES = {path.parent.name for path in (ROOT / "kernels").glob("*/__init__.py")} - {
    "stages",
    "opencl",
}
# the package itself: without this, a later import would put the package where the function `refine` stands
ALLOWED = {("lodbench.kernels", "lodbench.kernels.refine")}


def name_of(path: Path) -> str:
    parts = ["lodbench", *path.relative_to(ROOT).with_suffix("").parts]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


FILES = {
    name_of(path): path
    for folder in ("datasets_gen", "kernels", "harness")
    for path in sorted((ROOT / folder).rglob("*.py"))
}


def imported(path: Path) -> Iterator[str]:
    """What a module imports as it is loaded: not in functions, and not for type checkers alone."""
    for node in ast.parse(path.read_text("utf-8")).body:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            for alias in node.names:
                inner = f"{node.module}.{alias.name}"
                yield inner if inner in FILES else str(node.module)


GRAPH = {
    name: {found for found in imported(path) if found in FILES and found != name}
    for name, path in FILES.items()
}


def family(name: str) -> str | None:
    parts = name.split(".")
    return parts[2] if parts[1] == "kernels" and len(parts) > 2 and parts[2] in FAMILIES else None


ROOMS = ("record", "plan", "measure", "baselines", "report", "tables", "doctor", "cli")


def room(name: str) -> str | None:
    parts = name.split(".")
    return parts[2] if parts[1] == "harness" and len(parts) > 2 and parts[2] in ROOMS else None


@pytest.mark.parametrize("name", [name for name in GRAPH if room(name)])
def test_rooms_of_the_harness_import_those_before_them(name):
    for other in GRAPH[name]:
        if room(other):
            assert ROOMS.index(room(other)) <= ROOMS.index(room(name)), f"{name} imports {other}"


@pytest.mark.parametrize("name", [name for name in GRAPH if room(name) in ("tables", "plan")])
def test_tables_know_no_system_from_within(name):
    assert not [other for other in GRAPH[name] if family(other)], GRAPH[name]


def test_no_circle_of_imports():
    try:
        TopologicalSorter(GRAPH).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))


@pytest.mark.parametrize("name", GRAPH)
def test_what_systems_share_imports_no_system_and_no_family_another(name):
    for other in GRAPH[name]:
        if name.startswith("lodbench.kernels") and (name, other) not in ALLOWED:
            assert family(other) in (None, family(name)), f"{name} imports {other}"


@pytest.mark.parametrize("name", [name for name in GRAPH if name.endswith(".reference")])
def test_reference_imports_nothing_of_its_host(name):
    assert name.replace(".reference", ".host") not in GRAPH[name]


SYSTEMS = {path.parent.name for path in (ROOT / "kernels").glob("*/*/host.py")}
# the one that says which system a verb prefers, what papers claim of some, pictures of some, one spread over machines
NAMING = {
    *(f"lodbench.harness.claims.{paper}" for paper in ("boubekeur", "concheiro", "decoro", "wang")),
    "lodbench.kernels.verbs",
    "lodbench.harness.distributed",
    "lodbench.harness.report.adaptive_tessellations",
    "lodbench.harness.report.chains",
    "lodbench.harness.report.dices",
    "lodbench.harness.report.distances",
    "lodbench.harness.report.octrees",
    "lodbench.harness.report.refinements",
}
SHARED = [
    name
    for name in FILES
    if not (
        family(name) or name.startswith(("lodbench.harness.baselines", "lodbench.harness.tables"))
    )
]


def words(path: Path) -> Iterator[str]:
    """Every text in a module's code: docstrings, which give examples, are none."""
    tree = ast.parse(path.read_text("utf-8"))
    said = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
        and node.body and isinstance(node.body[0], ast.Expr)
    }  # fmt: skip
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in said:
            yield node.value


@pytest.mark.parametrize("name", sorted(set(SHARED) - NAMING))
def test_no_system_is_named_outside_its_folder_and_the_tables_about_it(name):
    named = SYSTEMS & set(words(FILES[name]))
    named -= {"pattern"}  # a role of memory and a regular expression are called so too
    assert not named
    assert not [other for other in GRAPH[name] if other.split(".")[-1] in SYSTEMS], GRAPH[name]


@pytest.mark.parametrize(
    "folder", sorted((ROOT / "kernels").glob("*/*/host.py")), ids=lambda path: path.parent.name
)
def test_params_stand_in_their_own_file(folder):
    for path in folder.parent.glob("*.py"):
        assert path.name == "params.py" or "\nclass Params" not in path.read_text("utf-8")
