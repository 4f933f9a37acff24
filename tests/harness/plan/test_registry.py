import subprocess
import sys

import pytest

from lodbench.harness.plan import registry
from tests.harness.fake import SYSTEMS


def test_systems_are_found_by_their_folders_names():
    found = registry.systems()
    assert {"quadric_clustering", "pattern", "fast_simplification"} <= set(found)
    assert all(system.name == name for name, system in found.items())
    assert not registry.registry().missing


def test_looking_for_systems_touches_no_device():
    code = (
        "import sys; from lodbench.harness.plan.registry import systems; systems(); "
        "assert 'pyopencl' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_unknown_names_come_with_close_ones():
    with pytest.raises(ValueError, match="system: expected one like quadric_clustering"):
        registry.system("quadratic_clustering")


def test_system_whose_package_is_absent_says_so(monkeypatch):
    absent = registry.Registry({}, {"wings": "No module named 'feathers'"})
    monkeypatch.setattr(registry, "registry", lambda: absent)
    with pytest.raises(ValueError, match="wings cannot be used here: No module named 'feathers'"):
        registry.system("wings")


def test_parameters_replace_fields_of_a_case():
    params = registry.parameters(SYSTEMS["fake"], "default", {"size": 3, "outcome": "ok"})
    assert (params.size, params.seconds) == (3, 0.0)
    with pytest.raises(ValueError, match="parameter of fake: expected one like seconds"):
        registry.parameters(SYSTEMS["fake"], None, {"second": 1})


@pytest.mark.parametrize(
    ("text", "kind"), [("x = 1\ny = (\n", "SyntaxError"), ("x = 1\n1 / 0\n", "ZeroDivisionError")]
)
def test_folder_that_cannot_be_imported_is_named_with_file_and_line(
    tmp_path, monkeypatch, text, kind
):
    folder = tmp_path / f"family_of_{kind.lower()}" / "broken"
    folder.mkdir(parents=True)
    (folder.parent / "__init__.py").touch()
    (folder / "__init__.py").write_text(text)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(registry, "_candidates", lambda: [f"{folder.parent.name}.broken"])
    registry.registry.cache_clear()
    try:
        with pytest.raises(ValueError, match=rf"{kind} in .*broken/__init__.py, line 2") as caught:
            registry.registry()
        assert str(caught.value).startswith(f"{folder.parent.name}.broken: expected a folder")
    finally:
        registry.registry.cache_clear()
