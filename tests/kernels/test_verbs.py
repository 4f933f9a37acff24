import numpy as np
import pytest

from lodbench.datasets_gen.nurbs import ball
from lodbench.datasets_gen.patches import cup
from lodbench.datasets_gen.surfaces import GeometryImage
from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.cli import complete
from lodbench.harness.cli.app import main
from lodbench.harness.plan.registry import systems
from lodbench.kernels import tessellate, verbs
from lodbench.kernels.parameters import described

DECLARED = [(name, verb) for name, system in systems().items() for verb in system.verbs]


def image():
    points = np.random.default_rng(0).random((5, 5, 3))
    return GeometryImage(points, np.broadcast_to([0.0, 0.0, 1.0], (5, 5, 3)))


@pytest.mark.parametrize(("name", "verb"), DECLARED)
def test_declared_verb_is_known_and_offered(name, verb):
    assert verb in verbs.VERBS
    assert verbs.declared(name) is systems()[name]
    assert name in complete._methods(verb)


@pytest.mark.parametrize("verb", verbs.VERBS)
def test_preferred_systems_declare_the_verb(verb):
    for name in verbs.PREFERRED[verb]:
        system = verbs.declared(name)
        assert system is not None and verb in system.verbs


def test_surface_decides_where_no_method_is_named():
    mesh, square = icosphere(1), image()
    assert verbs.method("simplify", None, mesh) is systems()["auto"].verbs["simplify"]
    assert verbs.method("simplify", None, square) is systems()["quadtree_lod"].verbs["simplify"]
    assert verbs.method("tessellate", None, cup()) is systems()["vst"].verbs["tessellate"]
    preferred = systems()["uniform_nurbs"]
    assert verbs.method("tessellate", None, ball()) is preferred.verbs["tessellate"]
    assert verbs.method("refine", None, mesh) is systems()["pattern"].verbs["refine"]


def test_what_no_system_does_is_said_in_one_line():
    with pytest.raises(ValueError, match=r"expected one of .*vertex_average, .*got 'nobody'"):
        verbs.method("simplify", "nobody", icosphere(1))
    with pytest.raises(
        ValueError, match=r"expected one of adaptive_patterns, pattern, .*, got 'vertex_average'"
    ):
        verbs.method("refine", "vertex_average", icosphere(1))
    with pytest.raises(TypeError, match="expected quadtree_lod for a GeometryImage, got vertex_av"):
        verbs.method("simplify", "vertex_average", image())
    with pytest.raises(TypeError, match="method: expected rpns, uniform_nurbs for a NurbsModel"):
        verbs.method("tessellate", "vst", ball())
    with pytest.raises(
        TypeError, match="tessellate: expected a surface that some system takes, got"
    ):
        verbs.method("tessellate", None, icosphere(1))
    with pytest.raises(TypeError, match="tessellate: expected a surface that some system takes"):
        tessellate(icosphere(1))


@pytest.mark.parametrize("name", [name for name, system in systems().items() if system.cases])
def test_parameters_are_described(name):
    params = type(next(iter(systems()[name].cases.values())))
    for row in described(params):
        assert row["meaning"], (
            f"{name}: {row['parameter']} has no line in the docstring of its Params"
        )


def test_shell_takes_a_methods_own_parameters_and_lists_them(tmp_path, capsys):
    out = tmp_path / "small.ply"
    words = ["simplify", "icosphere_3", str(out), "--cells", "6"]
    assert main([*words, "-m", "vertex_average", "-s", "chunks=3", "--json"]) == 0
    capsys.readouterr()
    assert main([*words, "-s", "chonks=3"]) == 2
    assert "option: expected one like chunks, got 'chonks'" in capsys.readouterr().err
    assert main(["list", "systems", "vertex_average"]) == 0
    listed = capsys.readouterr().out
    assert "remove_duplicates" in listed and "1 to 64" in listed
