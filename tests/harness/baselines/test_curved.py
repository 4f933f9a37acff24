import numpy as np

from lodbench.datasets_gen.triangles import torus
from lodbench.harness.baselines.curved import NORMALS, POINTS, control_weights, controls
from lodbench.kernels.refine.attributes import canonical
from lodbench.kernels.refine.lattice import lattice_weights
from lodbench.kernels.refine.pn_triangles.reference import curved
from tests.tolerances import ROUNDING32


def test_controls_times_weights_are_the_curved_triangles():
    mesh, wuv = canonical(torus(9, 7)), lattice_weights(5)
    made = [
        weights @ net.astype(float)
        for net, weights in zip(controls(mesh), control_weights(wuv), strict=True)
    ]
    P, N = mesh.positions[mesh.triangles], np.asarray(mesh.normals)[mesh.triangles]
    for ours, expected in zip(made, curved(P.astype(float), N.astype(float), wuv), strict=True):
        np.testing.assert_allclose(ours, expected, atol=ROUNDING32)


def test_weights_of_control_points_sum_to_one_and_every_corner_has_its_own():
    points, normals = control_weights(np.eye(3))
    np.testing.assert_array_equal(points, np.eye(3, len(POINTS)))
    np.testing.assert_array_equal(normals, np.eye(3, len(NORMALS)))
    points, _ = control_weights(lattice_weights(7))
    np.testing.assert_allclose(points.sum(axis=1), 1, rtol=1e-14)
