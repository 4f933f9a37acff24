import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.measure.areas import vertex_areas


def test_vertices_have_the_areas_of_their_triangles():
    mesh = TriangleMesh([[0, 0, 0], [2, 0, 0], [0, 1, 0], [2, 1, 0]], [[0, 1, 2], [1, 3, 2]])
    assert np.allclose(vertex_areas(mesh), [2, 4, 4, 2])
    ball = icosphere(4)
    assert np.isclose(vertex_areas(ball).sum() / 6, 4 * np.pi, rtol=0.01)
