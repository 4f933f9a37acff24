import numpy as np

from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.measure.moves import Moves
from lodbench.kernels.refine import adaptive_patterns, pn_triangles
from lodbench.kernels.stages.camera import orbit
from lodbench.kernels.system import Frame, run
from tests.tolerances import ROUNDING32


def seen(device, prepared, distances):
    moves = Moves()
    for distance in distances:
        run(device, prepared, Frame(orbit((0, 0, 0), distance)))
        moves.see(prepared, 1.0)
    return [moves.to(step).get("moved") for step in range(len(distances))]


class Still:
    pass


def test_nothing_is_known_of_a_subject_without_parameters():
    moves = Moves()
    moves.see(Still(), 1.0)
    assert moves.to(0) == {}
    assert moves.to(7) == {}


def test_a_level_that_changes_moves_the_surface_and_one_that_stays_does_not(device):
    mesh = icosphere(0)
    prepared = pn_triangles.PnTriangles(device, mesh, pn_triangles.Params(8, levels=4))
    first, same, coarser = seen(device, prepared, [1.5, 1.6, 40.0])
    assert first is None
    assert same == 0
    # the middle of an edge of the icosahedron, 0.85 from its centre, rises as far as the curve does
    assert 0.08 < coarser < 0.2


def test_the_same_surface_has_the_same_points_whatever_made_it(device):
    mesh = icosphere(1)
    even = pn_triangles.PnTriangles(device, mesh, pn_triangles.Params(8))
    adaptive = adaptive_patterns.AdaptivePatterns(
        device, mesh, adaptive_patterns.Params(8, by="given"), np.full(mesh.vertex_count, 3)
    )
    run(device, even), run(device, adaptive)
    points = even.at_parameters(), adaptive.at_parameters()
    np.testing.assert_allclose(*points, atol=ROUNDING32)


def test_geomorphing_takes_the_jump_out_of_a_level(device):
    mesh = icosphere(1)
    distances = np.geomspace(4, 40, 60)
    moved = {}
    for morph in (False, True):
        params = adaptive_patterns.Params(16, by="distance", geomorphing=morph)
        prepared = adaptive_patterns.AdaptivePatterns(device, mesh, params)
        moved[morph] = max(seen(device, prepared, distances)[1:])
    assert moved[True] < 0.5 * moved[False]
