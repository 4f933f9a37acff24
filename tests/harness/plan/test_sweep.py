import dataclasses
import json

import pytest

from lodbench.datasets_gen import catalogue
from lodbench.harness.cli.app import main
from lodbench.harness.measure import quality
from lodbench.harness.plan import registry, sweep
from tests.harness import fake


@dataclasses.dataclass(frozen=True)
class Seeded(fake.Params):
    seed: int = 7


@pytest.fixture(autouse=True)
def fakes(monkeypatch):
    fake.install(monkeypatch.setattr)
    systems = {"fake": fake.SYSTEMS["fake"], "seeded": fake.make("seeded", default=Seeded())}
    monkeypatch.setattr(registry, "registry", lambda: registry.Registry(systems, {}))


SPEC = {"name": "s", "systems": ["fake", "seeded"], "datasets": ["one"]}


def test_seeds_are_an_axis_for_every_subject():
    groups = sweep.groups(sweep.validate({**SPEC, "seeds": [0, 3], "params": {"size": [1, 2]}}))
    assert [(group.seed, group.facts) for group in groups] == [
        (seed, {"size": size, "seed": seed}) for size in (1, 2) for seed in (0, 3)
    ]
    own, other = groups[1].subjects[1], groups[1].subjects[0]
    assert (own.params["seed"], "seed" in other.params) == (3, False)
    assert len({json.dumps(group.config()) for group in groups}) == 4
    assert sweep.groups(sweep.validate(SPEC))[0].seed is None


def test_errors_are_sampled_with_the_groups_seed(tmp_path, monkeypatch, capsys):
    used = []
    monkeypatch.setattr(
        quality, "measure", lambda a, b, seed: used.append(seed) or {"rms_error": float(seed)}
    )
    path = tmp_path / "a-sweep.toml"
    path.write_text(
        "systems = ['fake', 'seeded']\ndatasets = ['one']\nseeds = [4, 5]\nquality = true"
    )
    words = ["sweep", path, "--samples", 1, "--out", tmp_path / "run", "--quiet", "--json"]
    assert main([str(word) for word in words]) == 0
    (made,) = json.loads(capsys.readouterr().out)
    assert used == [4, 5], "once per mesh and seed"
    assert [(row["system"], row["seed"], row["rms_error"]) for row in made["rows"]] == [
        ("fake", 4, 4.0), ("seeded", 4, 4.0), ("fake", 5, 5.0), ("seeded", 5, 5.0),
    ]  # fmt: skip


def test_dataset_named_twice_is_measured_once(tmp_path):
    path = tmp_path / "twice.toml"
    path.write_text("systems = ['fake']\ndatasets = ['two', 'one', 'two']")
    assert [group.dataset for group in sweep.groups(sweep.read(path))] == ["two", "one"]


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"seeds": 3}, "seeds: expected a list, got 3"),
        ({"seeds": [1.5]}, "expected int, got 1.5"),
        ({"seeds": [-1]}, "seeds: expected whole numbers from 0"),
        ({"seeds": [1], "params": {"seed": 2}}, "expected seeds or params.seed, got both"),
    ],
)
def test_bad_seeds_are_refused(change, text):
    with pytest.raises(ValueError, match=text):
        sweep.validate({**SPEC, **change})


def test_lists_are_axes_and_a_list_within_one_a_single_value():
    spec = {"params": {"size": [1, [2, 3]], "seconds": 0.5}, "datasets": ["one", "two"]}
    groups = sweep.groups(sweep.validate({**SPEC, **spec}))
    assert [(group.dataset, group.facts["size"]) for group in groups] == [
        ("one", 1), ("one", [2, 3]), ("two", 1), ("two", [2, 3]),
    ]  # fmt: skip
    assert {group.facts["seconds"] for group in groups} == {0.5}
    assert len({group.name for group in groups}) == 4


def test_parameters_of_one_system_make_subjects_of_one_group():
    spec = {"params": {"seed": 1, "fake": {"size": [1, 2], "outcome": ["ok"]}}, "quality": True}
    (group,) = sweep.groups(sweep.validate({**SPEC, **spec, "case": "default"}))
    assert [(subject.name, subject.params) for subject in group.subjects] == [
        ("fake size=1 outcome=ok", {"size": 1, "outcome": "ok"}),
        ("fake size=2 outcome=ok", {"size": 2, "outcome": "ok"}),
        ("seeded", {"seed": 1}),  # fake has no such parameter
    ]
    assert group.quality and {subject.case for subject in group.subjects} == {"default"}
    assert group.facts == {"seed": 1} and group.seed is None, "of the system, not of the errors"
    group.validate()


@pytest.mark.parametrize("quality", [False, True])
def test_table_of_a_sweep_has_a_column_for_each_axis_and_ratios_to_the_first(quality):
    spec = {
        "params": {"size": [1, 2], "fake": {"seconds": [0.0]}},
        "seeds": [1],
        "quality": quality,
    }
    made = sweep.table(sweep.validate({**SPEC, **spec}))
    keys = [column.key for column in made.columns]
    assert (made.id, made.brief) == ("s", [])
    assert made.named("ratio_to") == ["fake seconds=0.0"]
    assert keys[2:5] == ["size", "seed", "system"], "no column for what one system alone has"
    assert ("rms_error" in keys) is quality
    assert [group.name for group in made.groups(True)] == ["one size=1 seed=1", "one size=2 seed=1"]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("64", 64), ("-0.5", -0.5), ("[32, [1, 2]]", [32, [1, 2]]), ("true", True), ('"fused"', "fused"),
        ("fused", "fused"), ("True", "True"), ("", ""), ("1, 2", "1, 2"), ("a = 3", "a = 3"),
    ],
)  # fmt: skip
def test_value_is_read_as_toml_or_else_as_text(text, value):
    found = sweep.literal(text)
    assert found == value and type(found) is type(value)


@pytest.mark.parametrize(
    ("file", "name"), [("My Sweep-2.toml", "my_sweep_2"), ("--.toml", "sweep"), ("a.b.toml", "a_b")]
)
def test_sweep_without_a_name_has_that_of_its_file(tmp_path, file, name):
    path = tmp_path / file
    path.write_text("systems = ['fake']\ndatasets = ['one', 'two', 'one']")
    spec = sweep.read(path)
    assert (spec["name"], spec["datasets"]) == (name, ["one", "two"])
    path.write_text("name = 'own'\n" + path.read_text())
    assert sweep.read(path)["name"] == "own"


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"sytems": []}, "key: expected one like systems"),
        ({"systems": []}, "systems: expected a list of names, got"),
        ({"datasets": "one"}, "datasets: expected a list of names, got 'one'"),
        ({"quality": 1}, "quality"),
        ({"name": "../up"}, "name"),
        ({"params": {"sizes": 3}}, "params: expected one like size, .*got 'sizes'"),
        ({"params": {"seed": 3}, "systems": ["fake"]}, "params: expected one .*got 'seed'"),
        ({"params": {"seeded": {"seed": 3}}, "systems": ["fake"]}, "params: expected .*'seeded'"),
        ({"systems": ["fakes"], "params": {"size": 1}}, "system: expected one like fake"),
    ],
)
def test_bad_sweep_is_refused_with_the_key(change, text):
    with pytest.raises(ValueError, match=text):
        sweep.validate({**SPEC, **change})


def test_default_dataset_is_one_that_the_system_takes_and_needs_no_file(monkeypatch):
    monkeypatch.undo()
    for name, system in registry.systems().items():
        if not {"TriangleMesh", "BezierPatches", "NurbsModel"} & {c.__name__ for c in system.takes}:
            continue
        dataset = catalogue.find(sweep.default_dataset(name))
        assert type(dataset.surface) in system.takes
