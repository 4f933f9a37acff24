import dataclasses
import json

import pytest

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
