import json

import numpy as np
import pytest

from lodbench.datasets_gen.read import write_mesh
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.cli.app import main
from lodbench.harness.plan.registry import parameters, systems
from lodbench.kernels import refine, refine_mesh, render, simplify, simplify_mesh
from lodbench.kernels.cluster.target import GridTarget
from lodbench.kernels.opencl.device import Unsupported
from lodbench.kernels.system import run
from lodbench.kernels.targets import TARGETS, Target, missed, off_target
from tests.kernels.cluster.meshes import cube
from tests.test_every_system import sphere

SIMPLIFIERS = sorted(
    name
    for name, system in systems().items()
    if isinstance(next(iter(system.cases.values())), Target) and system.family != "geometry_image"
)
LEAST = {  # share of the target; these divide the box evenly, into whole cells
    "vtk_binned_decimation": 0.88,
    "vtk_quadric_clustering": 0.88,
    "meshoptimizer_sloppy": 0.8,
}
POINTS = np.ones((5, 3))


@pytest.mark.parametrize(
    ("asked", "left"),
    [
        ({}, None),
        ({"target_reduction": 0.0}, 1000),
        ({"target_reduction": 0.9}, 100),
        ({"target_reduction": 0.9999}, 1),
        ({"target_count": 7}, 7),
        ({"target_count": 7000}, 1000),
    ],
)
def test_target_says_how_many_triangles_are_asked_for(asked, left):
    assert Target(**asked).triangles(1000) == left
    assert GridTarget(**asked).counted(1000).target_reduction is None


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"target_reduction": 1.0}, "target_reduction: expected 0 to below 1, got 1"),
        ({"target_reduction": -0.1}, "target_reduction: expected"),
        ({"target_reduction": float("nan")}, "target_reduction: expected"),
        ({"target_count": 0}, "target_count: expected at least 1, got 0"),
        ({"cells": 0}, "cells: expected at least 1"),
        ({"cells": 9, "target_count": 3}, "expected one of them, got target_count and cells"),
        ({"target_reduction": 0.5, "target_count": 3}, "got target_reduction and target_count"),
    ],
)
def test_target_refuses_what_makes_none_and_more_than_one(asked, said):
    with pytest.raises(ValueError, match=said):
        GridTarget(**asked)


def test_gap_is_negative_where_there_are_more():
    assert missed(5, 12) == {"target": 5, "target_gap": -7}


@pytest.mark.parametrize(
    ("counters", "said"),
    [
        ({}, ""),
        (missed(1000, 1000), ""),
        (missed(1000, 950), ""),
        (missed(1000, 400), "600 fewer than the 1,000 asked for"),
        (missed(6, 12), "6 more than the 6 asked for"),
    ],
)
def test_a_miss_is_said_in_words(counters, said):
    assert off_target(counters) == said


def test_shell_says_by_how_much_a_target_is_missed(capsys, tmp_path):
    box = tmp_path / "box.ply"
    write_mesh(box, cube(1))
    words = ["simplify", str(box), str(tmp_path / "out.ply"), "-r", "0.5"]
    words += ["-m", "quadric_clustering"]
    assert main(words) == 0
    assert "12 -> 12 triangles (6 more than the 6 asked for)" in capsys.readouterr().out
    assert main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["counters"]["target_gap"] == -6


@pytest.mark.parametrize("verb", [["simplify", "-r", "0.5"], ["refine"], ["render"]])
def test_shell_refuses_points_alone(capsys, tmp_path, verb):
    cloud, out = (
        tmp_path / "cloud.ply",
        tmp_path / ("out.png" if verb[0] == "render" else "out.ply"),
    )
    write_mesh(cloud, TriangleMesh(POINTS, np.zeros((0, 3), int)))
    assert main([verb[0], str(cloud), str(out), *verb[1:]]) == 2
    said = capsys.readouterr().err
    assert said.endswith("faces: expected triangles, got 5 points and none\n")
    assert said.count("\n") == 1
    assert not out.exists()


def test_every_simplifier_takes_the_same_targets():
    assert {"quadric_clustering", "simplify_call", "numpy_quadric_clustering"} <= set(SIMPLIFIERS)
    for name, system in systems().items():
        for case, params in system.cases.items():
            if hasattr(params, "target_count"):
                assert isinstance(params, Target), f"{name} {case}"


@pytest.mark.parametrize("name", SIMPLIFIERS)
def test_override_of_one_target_clears_those_of_the_case(name):
    system = systems()[name]
    for case in system.cases:
        for asked in ({"target_reduction": 0.9}, {"target_count": 77}, {"cells": [3, 4, 5]}):
            if next(iter(asked)) not in vars(system.cases[case]):
                continue
            found = vars(parameters(system, case, asked))
            assert {k for k in TARGETS if found.get(k) is not None} == set(asked)
        with pytest.raises(ValueError, match="expected one of them"):
            parameters(system, case, {"target_reduction": 0.9, "target_count": 77})


@pytest.mark.parametrize("name", SIMPLIFIERS)
def test_simplifiers_come_to_like_counts_for_one_target(device, name):
    system = systems()[name]
    mesh = sphere(40, 60)
    try:
        prepared = system.prepare(device, mesh, parameters(system, None, {"target_reduction": 0.8}))
    except (ValueError, Unsupported) as error:
        pytest.skip(str(error))
    run(device, prepared)
    assert prepared.check().passed
    counters = prepared.counters()
    asked = Target(target_reduction=0.8).triangles(mesh.triangle_count)
    assert LEAST.get(name, 0.95) * asked <= counters["triangles"] <= asked
    if "target" in counters:
        assert counters["target_gap"] == asked - counters["triangles"]


def test_numpy_form_searches_to_the_same_grid(device):
    mesh = sphere(30, 40)
    found = []
    for name in ("quadric_clustering", "numpy_quadric_clustering", "simplify_call"):
        system = systems()[name]
        prepared = system.prepare(device, mesh, parameters(system, None, {"target_count": 500}))
        counters = prepared.counters()
        found.append([counters[k] for k in ("triangles", "cells_along_longest", "target_gap")])
    assert found[0] == found[1] == found[2]


@pytest.mark.parametrize("call", [
    lambda mesh: simplify(*mesh, target_reduction=0.5),
    lambda mesh: simplify(mesh, cells=4),
    lambda mesh: simplify_mesh(None, mesh, target_count=1),
    lambda mesh: simplify(mesh, target_count=1, method="quadtree_lod"),
    lambda mesh: refine(*mesh),
    lambda mesh: refine_mesh(None, mesh),
    lambda mesh: render(*mesh),
])  # fmt: skip
def test_points_alone_are_an_error(call):
    with pytest.raises(ValueError, match="faces: expected triangles, got 5 points and none"):
        call((POINTS, np.zeros((0, 3), int)))


def test_no_points_and_no_triangles_stay_none():
    nothing = (np.zeros((0, 3)), np.zeros((0, 3), int))
    for found in (
        simplify(*nothing, target_reduction=0.5),
        simplify(nothing, target_count=3),
        refine(*nothing),
    ):
        assert [len(rows) for rows in found] == [0, 0]


def test_quadtree_lod_gives_a_mesh_back_where_all_of_it_is_asked_for(device):
    mesh = sphere()
    for asked in ({"target_reduction": 0.0}, {"target_count": 10**6}):
        result = simplify_mesh(device, mesh, method="quadtree_lod", **asked)
        assert np.array_equal(result.mesh.triangles, mesh.triangles)
        assert np.array_equal(result.mesh.positions, mesh.positions)
        assert result.counters["target_gap"] == 0
    tetrahedron = TriangleMesh(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
    )
    few = simplify_mesh(device, tetrahedron, method="quadtree_lod", target_count=3)
    assert (few.mesh.triangle_count, few.counters["target_gap"]) == (8, -5)


def test_exactly_one_target_is_asked_of_the_api():
    with pytest.raises(ValueError, match="max_error: expected one of them, got none"):
        simplify(sphere())
    with pytest.raises(ValueError, match="expected one of them, got target_reduction and cells"):
        simplify(sphere(), target_reduction=0.5, cells=3)
