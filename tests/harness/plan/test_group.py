import json
from dataclasses import replace
from types import SimpleNamespace

import pytest

from lodbench.datasets_gen import catalogue
from lodbench.harness.plan.group import Context, Draw, Group, Subject
from lodbench.harness.record.record import config_hash
from lodbench.kernels.opencl.device import Unsupported
from lodbench.kernels.stages.paths import CameraPath
from tests.harness import fake

GROUP = Group("one", (Subject("fake", {"size": 2}), Subject("other")), {"cells": 8})


@pytest.fixture(autouse=True)
def fakes(monkeypatch):
    fake.install(monkeypatch.setattr)


def of_context(context):
    return {"size": context.counter("fake", "triangles")}


def test_group_is_named_by_its_dataset_and_its_facts():
    assert GROUP.name == "one cells=8"
    assert Group("one", ()).name == "one"
    assert [Subject("a").name, Subject("a", label="b").name] == ["a", "b"]


@pytest.mark.parametrize(
    "change",
    [
        {"dataset": "two"},
        {"facts": {"cells": 9}},
        {"facts": {}},
        {"quality": True},
        {"zoom": 2.0},
        {"once": True},
        {"seed": 0},
        {"path": CameraPath("orbit")},
        {"reference": "fake"},
        {"subjects": GROUP.subjects[::-1]},
        {"subjects": GROUP.subjects[:1]},
        {"subjects": (replace(GROUP.subjects[0], params={"size": 3}), GROUP.subjects[1])},
        {"subjects": (replace(GROUP.subjects[0], params=of_context), GROUP.subjects[1])},
        {"subjects": (replace(GROUP.subjects[0], label="mine"), GROUP.subjects[1])},
        {"subjects": (replace(GROUP.subjects[0], case="default"), GROUP.subjects[1])},
        {"subjects": (replace(GROUP.subjects[0], one_core=True), GROUP.subjects[1])},
        {"subjects": (replace(GROUP.subjects[0], draw=Draw()), GROUP.subjects[1])},
        {"subjects": (replace(GROUP.subjects[0], draw=Draw((64, 64))), GROUP.subjects[1])},
        {"subjects": (replace(GROUP.subjects[0], draw=Draw(apart=True)), GROUP.subjects[1])},
    ],
)
def test_whatever_decides_what_is_measured_changes_the_hash(change):
    assert config_hash(replace(GROUP, **change).config()) != config_hash(GROUP.config())


@pytest.mark.parametrize("change", [{"weight": 9.0}, {"standin_ok": True}])
def test_what_decides_nothing_leaves_the_hash(change):
    assert config_hash(replace(GROUP, **change).config()) == config_hash(GROUP.config())


def test_content_of_a_file_is_a_part_of_the_hash(monkeypatch):
    before = config_hash(GROUP.config())
    found = SimpleNamespace(name="one", content="abc")
    monkeypatch.setattr(catalogue, "find", lambda name: found)
    assert GROUP.config()["content"] == "abc"
    assert config_hash(GROUP.config()) != before


def test_config_is_json_and_names_the_rule_where_params_follow_from_others():
    group = replace(GROUP, subjects=(Subject("fake", of_context),), path=CameraPath("orbit"))
    config = json.loads(json.dumps(group.config()))
    assert config["subjects"][0]["params"] == of_context.__qualname__
    assert config["path"] == {"kind": "orbit", "frames": 60}


def test_stand_in_takes_the_place_of_a_scan_that_is_not_there(monkeypatch):
    def find(name):
        if name != "statue_standin":
            raise ValueError(f"dataset: expected a file, got {name!r}")
        return SimpleNamespace(name=name, content="")

    monkeypatch.setattr(catalogue, "find", find)
    group = Group("statue", (), standin_ok=True)
    assert group.found().name == group.config()["dataset"] == "statue_standin"
    with pytest.raises(ValueError, match="got 'statue'"):
        replace(group, standin_ok=False).found()
    with pytest.raises(ValueError, match="got 'another_standin'"):
        replace(group, dataset="another").found()


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"dataset": "four"}, "dataset: expected one of"),
        ({"subjects": (Subject("fake"), Subject("fake"))}, "different labels, got .'fake', 'fake'"),
        ({"subjects": (Subject("fake"), Subject("other", label="fake"))}, "different labels"),
        ({"subjects": (Subject("fakes"),)}, "system: expected one like fake"),
        ({"subjects": (Subject("fake", case="best"),)}, "case"),
        ({"subjects": (Subject("fake", of_context, case="best"),)}, "case"),
        ({"subjects": (Subject("fake", {"sized": 1}),)}, "parameter of fake: expected one like"),
        ({"subjects": (Subject("fake", {"size": 0}),)}, "size: expected at least 1, got 0"),
    ],
)
def test_group_that_cannot_be_measured_is_refused(change, text):
    GROUP.validate()
    with pytest.raises(ValueError, match=text):
        replace(GROUP, **change).validate()


def test_group_with_a_system_whose_package_is_absent_is_whole():
    replace(GROUP, subjects=(Subject("gone", {"what": 1}), Subject("fake"))).validate()


def test_params_that_follow_from_others_are_not_asked_before():
    replace(GROUP, subjects=(Subject("fake", of_context),)).validate()


def test_counter_of_a_subject_that_has_none_is_unsupported():
    context = Context(None, None, {"fake": {"triangles": 12}, "other": {}}, {})
    assert of_context(context) == {"size": 12}
    for label, name in (("fake", "cells"), ("other", "triangles"), ("absent", "triangles")):
        with pytest.raises(Unsupported, match=f"needs {name} of {label}, which has none"):
            context.counter(label, name)


def test_reference_that_nobody_is_called_is_refused():
    replace(GROUP, reference="other").validate()
    with pytest.raises(ValueError, match=r"reference: expected one of .*got 'nobody'"):
        replace(GROUP, reference="nobody").validate()


def test_results_are_judged_by_the_input_or_by_a_reference():
    changes = ({}, {"quality": True}, {"reference": "other"})
    assert [replace(GROUP, **change).judged for change in changes] == [False, True, True]
