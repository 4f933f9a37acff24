"""The pages on records and sweeps say what there is: every field, every key, and nothing else."""

import dataclasses
import json
import re
from pathlib import Path

import pytest

from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.cli.app import main
from lodbench.harness.measure import quality
from lodbench.harness.plan import sweep
from lodbench.harness.record import foreign
from lodbench.harness.record.samples import pack, read_rows, rows_file
from lodbench.kernels.system import Check, Footprint
from tests.harness import fake

RESULTS = Path(__file__).parents[2] / "results"
PAGE = (RESULTS / "README.md").read_text("utf-8")
SWEEPS = (RESULTS / "SWEEPS.md").read_text("utf-8")


def documented():
    """Kind of row -> names in the first column of its table."""
    found = {}
    for section in PAGE.split("\n### ")[1:]:
        cells = re.findall(r"(?m)^\| (`.*?) \|", section)
        found[section.split()[0]] = set(re.findall(r"`(\w+)`", " ".join(cells)))
    return found


@pytest.fixture(scope="module")
def recorded(tmp_path_factory, device):
    """Kind of row -> names of fields in the committed runs and in a run that goes wrong in places."""
    folder = tmp_path_factory.mktemp("run")
    with pytest.MonkeyPatch.context() as patch:
        fake.install(patch.setattr)
        main(["run", "fake", "-d", "one", "--samples", "1", "-q", "--out", str(folder / "run")])
    found = {}
    for run in [folder / "run", *RESULTS.glob("reference/*/*")]:
        for row in read_rows(rows_file(run)):
            found.setdefault(row["kind"], set()).update(row)
    return found


def known(kind):
    return {"kind", *(name.removesuffix("?") for name in foreign.ROWS[kind])}


def test_every_kind_of_row_is_explained():
    assert documented().keys() == foreign.ROWS.keys()


@pytest.mark.parametrize("kind", foreign.ROWS)
def test_every_field_of_a_row_is_explained_and_no_other(kind, recorded):
    assert documented()[kind] == known(kind) | recorded.get(kind, set())


def test_fields_within_fields_are_explained():
    names = [field.name for kind in (Check, Footprint) for field in dataclasses.fields(kind)]
    ball = icosphere(1)
    names += [*quality.topology(ball), *foreign.ROWS["limits"]["fill"]]
    names += ["rms_error", "rms_error_back", "max_error", "flipped_triangles", "error_samples"]
    names += ["rms_difference", "max_difference", "mean_difference", "compared_points"]
    names += ["border_error", "error_vertices", "content", "standin", "triangles_in", "vertices_in"]
    for name in names:
        assert f"`{name}`" in PAGE, name


def test_every_key_of_a_sweep_is_explained():
    assert set(re.findall(r"(?m)^\| `(\w+)` \|", SWEEPS)) == set(sweep.KEYS)


def test_sweep_of_the_page_is_what_the_page_says(tmp_path):
    (example,) = re.findall(r"(?s)```toml\n(.*?)```", SWEEPS)
    path = tmp_path / "grids.toml"
    path.write_text(example)
    groups = sweep.groups(sweep.read(path))
    assert len(groups) == 6
    assert {len(group.subjects) for group in groups} == {3}
    for group in groups:
        group.validate()


def test_example_of_the_page_reads_a_record(tmp_path, monkeypatch):
    _, code = re.findall(r"(?s)```python\n(.*?)```", PAGE)
    rows = [{"kind": "sample", "warmup": warm, "wall_s": 2.0} for warm in (True, False)]
    (tmp_path / "samples.jsonl").write_text("\n".join(map(json.dumps, rows)))
    pack(tmp_path)
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(code, names)
    assert names["times"] == [2.0]


def test_example_of_the_page_gives_rows_of_the_reference(monkeypatch):
    code, _ = re.findall(r"(?s)```python\n(.*?)```", PAGE)
    monkeypatch.chdir(RESULTS.parent)
    names = {}
    exec(code, names)
    assert {"system", "wall_s", "wall_s_low"} <= names["rows"][0].keys()
