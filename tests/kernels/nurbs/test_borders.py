import dataclasses

from lodbench.datasets_gen import nurbs
from lodbench.datasets_gen.nurbs_surface import NurbsModel, NurbsSurface
from lodbench.kernels.nurbs.borders import borders_of, shared_vertices
from lodbench.kernels.nurbs.grids import placed
from lodbench.kernels.nurbs.params import NurbsParams
from lodbench.kernels.nurbs.tessellated import sampled


def turned(surface):
    """The same surface with u backwards."""
    return dataclasses.replace(
        surface,
        knots_u=5 - 2 * surface.knots_u[::-1],
        points=surface.points[::-1],
        weights=surface.weights[::-1],
    )


def swapped(surface):
    """The same surface with u and v exchanged."""
    return NurbsSurface(
        surface.degree_v, surface.degree_u, surface.knots_v, surface.knots_u,
        surface.points.transpose(1, 0, 2), surface.weights.T,
    )  # fmt: skip


def test_borders_are_found_in_either_direction():
    a, b, c, d = nurbs.quilt(2, 2, 3).surfaces
    for model in ((a, b, c, d), (a, turned(b), swapped(c), turned(swapped(d)))):
        found = borders_of(NurbsModel(model)).counts()
        assert found == {"shared_edges": 4, "open_edges": 8, "collapsed_edges": 0}


def test_closed_and_collapsed_borders_are_counted():
    found = borders_of(nurbs.ball()).counts()
    assert found == {"shared_edges": 1, "open_edges": 0, "collapsed_edges": 2}
    found = borders_of(nurbs.torus()).counts()
    assert found == {"shared_edges": 2, "open_edges": 0, "collapsed_edges": 0}


def test_other_knots_or_weights_part_a_border():
    left, right = nurbs.quilt(1, 2, 3).surfaces
    knots = left.knots_v.copy()
    knots[4] += 0.01
    weights = right.weights.copy()
    weights[0, 2] = 2
    assert borders_of(NurbsModel((left, right))).counts()["shared_edges"] == 1
    other = dataclasses.replace(left, knots_v=knots)
    assert borders_of(NurbsModel((other, right))).counts()["shared_edges"] == 0
    other = dataclasses.replace(right, weights=weights)
    assert borders_of(NurbsModel((left, other))).counts()["shared_edges"] == 0


def test_shared_vertices_have_one_root_at_one_place():
    a, b, c, d = nurbs.quilt(2, 2, 3).surfaces
    model = NurbsModel((a, turned(b), swapped(c), turned(swapped(d))))
    grids = placed(sampled(model, NurbsParams(2)))
    found = shared_vertices(model, grids, borders_of(model), normals=True)
    # 4 surfaces of 5 x 5 vertices, of which a grid of 9 x 9 has each once
    assert len(found.vertices) == 4 * 25 - 81
    assert not set(found.vertices) & set(found.roots)
    assert not found.smooth.all()  # swapped sides turn the normal around
