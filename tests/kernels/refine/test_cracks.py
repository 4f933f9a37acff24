import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere
from lodbench.kernels import refine_mesh
from lodbench.kernels.refine.cracks import split_edges

POINTS = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0.5], [0, 1, 0]]
UP, ASIDE = [0, 0, 1], [-0.6, 0, 0.8]


def hinge(*normals):
    """Two triangles along one edge, each with three vertices of its own."""
    return TriangleMesh(POINTS, [[0, 1, 2], [3, 4, 5]], normals)


@pytest.mark.parametrize(
    ("normals", "expected"),
    [([UP] * 6, 0), ([UP] * 3 + [ASIDE] + [UP] * 2, 1), ([UP] * 5 + [ASIDE], 1)],
)
def test_an_edge_is_split_where_normals_of_an_end_differ(normals, expected):
    assert split_edges(hinge(*normals)) == expected


def test_soup_is_split_along_all_edges_and_a_shared_mesh_along_none():
    mesh = icosphere(1).with_normals()
    soup = TriangleMesh(
        mesh.positions[mesh.triangles].reshape(-1, 3), np.arange(240).reshape(-1, 3)
    )
    assert split_edges(mesh) == 0
    assert split_edges(soup.with_normals()) == 120
    smooth = TriangleMesh(
        soup.positions, soup.triangles, mesh.normals[mesh.triangles].reshape(-1, 3)
    )
    assert split_edges(smooth) == 0
    assert split_edges(TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int))) == 0


@pytest.mark.parametrize("method", ["pn_triangles", "st_triangles", "adaptive_patterns"])
def test_cracks_that_may_open_are_counted(device, method):
    sharp, smooth = hinge(*[UP] * 3, ASIDE, UP, UP), hinge(*[UP] * 6)
    for mesh, expected in ((sharp, 1), (smooth, 0)):
        result = refine_mesh(device, mesh, method=method, segments=4, weld=False)
        assert result.counters["cracked_edges"] == expected


def test_a_flat_surface_cracks_only_where_it_is_displaced(device):
    sharp = hinge(*[UP] * 3, ASIDE, UP, UP)
    for amplitude, expected in ((0.0, 0), (0.05, 1)):
        result = refine_mesh(device, sharp, segments=4, amplitude=amplitude)
        assert result.counters["cracked_edges"] == expected
