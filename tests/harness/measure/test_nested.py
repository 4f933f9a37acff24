import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, torus
from lodbench.harness.measure.nested import difference
from lodbench.kernels.refine.lattice import lattice_weights, refined_mesh


def refined(coarse, segments, lift=lambda points: 0.0):
    """Instances of a pattern, raised along z by a function of the points."""
    points = lattice_weights(segments) @ coarse.positions.astype(np.float64)[coarse.triangles]
    points = points.reshape(-1, 3)
    points[:, 2] += lift(points)
    return refined_mesh(coarse, segments, points.astype(np.float32), np.zeros_like(points))


def test_flat_refinement_differs_by_nothing_but_rounding():
    coarse = torus(6, 3)
    found = difference(coarse, refined(coarse, 2), refined(coarse, 8))
    assert found["max_difference"] < 1e-6
    assert found["compared_points"] == 36 * 45


def test_difference_of_a_parabola_is_that_of_its_chords():
    coarse = TriangleMesh([(0, 0, 0), (4, 0, 0), (0, 3, 0)], [(0, 1, 2)])  # its diagonal is 5
    sheet = [refined(coarse, n, lambda points: points[:, 0] ** 2) for n in (1, 2, 4, 64)]
    found = [difference(coarse, one, sheet[-1]) for one in sheet[:-1]]
    # a chord over a width h lies h^2 / 4 above the parabola at the most
    assert [one["max_difference"] for one in found] == pytest.approx([4 / 5, 1 / 5, 0.25 / 5])
    assert found[0]["rms_difference"] > 3.9 * found[1]["rms_difference"]


def test_meshes_that_are_no_nested_patterns_are_refused():
    coarse = icosphere(0)
    with pytest.raises(ValueError, match="segments: expected a divisor of 8 to compare, got 3"):
        difference(coarse, refined(coarse, 3), refined(coarse, 8))
    with pytest.raises(ValueError, match="result: expected 20 instances of a pattern"):
        difference(coarse, icosphere(1), refined(coarse, 8))
    none = TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), np.uint32))
    with pytest.raises(ValueError, match="result: expected 0 instances"):
        difference(none, none, none)
