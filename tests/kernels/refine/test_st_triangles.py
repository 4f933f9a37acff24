from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, torus
from lodbench.kernels import refine
from lodbench.kernels.refine import pattern
from lodbench.kernels.refine.lattice import lattice_rows
from lodbench.kernels.refine.pn_triangles import Params as PnParams
from lodbench.kernels.refine.pn_triangles import PnTriangles
from lodbench.kernels.refine.st_triangles import Params, StTriangles
from tests.kernels.refine.test_pattern import shaken, tetrahedron
from tests.tolerances import ROUNDING32, UNIT_LENGTH

ROOF = TriangleMesh([[0, 0, 0], [0, 1, 0], [-1, 0.5, -0.5], [1, 0.5, -0.5]], [[0, 1, 2], [1, 0, 3]])
SLOPES = np.degrees(2 * np.arctan(0.5))  # between the roof's two faces


def draw(device, mesh, segments=8, **params):
    return StTriangles(device, mesh, Params(segments, **params))


def random_tags(mesh, seed):
    random = np.random.default_rng(seed)
    tags = random.random((mesh.vertex_count, 3)) * (2, 1, 2) - (1, 0, 1)
    tags[random.random(len(tags)) < 0.3] = 0
    return replace(mesh, tags=tags.astype(np.float32))


@pytest.mark.parametrize(
    "params",
    [{}, {"tension": 0.5}, {"sharpness": 1.0}, {"tension": 0.3, "sharpness": 0.6, "bias": -0.5, "amplitude": 0.02}],
    ids=["none", "tension", "sharp", "all"],
)  # fmt: skip
@pytest.mark.parametrize("make", [tetrahedron, lambda: shaken(icosphere(1)), lambda: torus(9, 7)])
@pytest.mark.parametrize("segments", [1, 3, 16])
def test_st_triangles_agree_with_reference(device, make, segments, params):
    for mesh in (make(), random_tags(make(), 1)):
        check = draw(device, mesh, segments, **params).check()
        assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"


@pytest.mark.parametrize("make", [tetrahedron, lambda: shaken(icosphere(2)), lambda: torus(9, 7)])
def test_tags_of_zero_are_pn_triangles_to_the_bit(device, make):
    mesh = make()
    zero = replace(mesh, tags=np.zeros((mesh.vertex_count, 3), np.float32))
    expected = PnTriangles(device, mesh, PnParams(7)).result()[0]
    for made in (draw(device, mesh, 7), draw(device, zero, 7, tension=0.5, sharpness=1.0)):
        (found,) = made.result()
        assert found.positions.tobytes() == expected.positions.tobytes()
        assert found.normals.tobytes() == expected.normals.tobytes()


@settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(seed=st.integers(0, 2**32 - 1), segments=st.integers(1, 9))
def test_no_tags_open_a_crack(device, seed, segments):
    mesh = random_tags(shaken(icosphere(1), seed % 1000), seed)
    points = draw(device, mesh, segments).result()[0].positions + np.float32(0)
    # V = T n^2 / 2 + 2: whatever the tags, an edge is one curve
    assert len(np.unique(points, axis=0)) == mesh.triangle_count * segments**2 // 2 + 2


def of_vertices(mesh):
    """Tags of edges that say what the mesh's vertices do."""
    following = np.roll(mesh.triangles, -1, axis=1)
    ends = mesh.tags[np.stack([mesh.triangles, following])]
    bias = np.float32(0.5) * (ends[0, ..., 2] + ends[1, ..., 2])
    return np.stack([ends[0, ..., 1] * ends[1, ..., 1], bias], axis=2)


def test_tags_of_edges_that_say_what_vertices_do_change_no_bit(device):
    mesh = random_tags(shaken(icosphere(1)), 5)
    tagged = replace(mesh, tags=mesh.tags * (1, 0, 0), edge_tags=of_vertices(mesh))
    expected, found = (draw(device, one, 5).result()[0] for one in (mesh, tagged))
    assert found.positions.tobytes() == expected.positions.tobytes()
    assert found.normals.tobytes() == expected.normals.tobytes()


@pytest.mark.parametrize("seed", range(3))
def test_tags_of_edges_agree_with_reference_and_open_no_crack(device, seed):
    mesh = random_tags(shaken(icosphere(1), seed), seed)
    random = np.random.default_rng(seed)  # the two sides of an edge say different things
    edge_tags = random.random((mesh.triangle_count, 3, 2)) * (1, 2) - (0, 1)
    made = draw(device, replace(mesh, edge_tags=edge_tags), 6)
    assert made.check().passed
    points = made.result()[0].positions + np.float32(0)
    assert len(np.unique(points, axis=0)) == mesh.triangle_count * 6**2 // 2 + 2


def test_an_edge_creases_by_its_own_tags_whatever_its_ends_say(device):
    mesh = replace(ROOF.with_normals(), tags=np.tile((0.0, 1.0, 0.0), (4, 1)))
    edge_tags = np.zeros((2, 3, 2))
    assert between(ridge_normals(device, replace(mesh, edge_tags=edge_tags))) < 0.05
    edge_tags[:, 0, 0] = 1  # the ridge is the first edge of both
    alone = between(ridge_normals(device, replace(mesh, edge_tags=edge_tags)))
    edge_tags[:, :, 0] = (0, 1, 1)  # the others
    beside = between(ridge_normals(device, replace(mesh, edge_tags=edge_tags)))
    # a corner's normal is the mean of its two edges', so that half of a crease reaches the edges beside it
    assert 0.6 * SLOPES < alone < 0.75 * SLOPES
    assert beside < 0.35 * SLOPES


def test_tags_follow_the_edges_of_triangles_that_are_turned(device):
    mesh = shaken(icosphere(1))
    edge_tags = np.random.default_rng(1).random((mesh.triangle_count, 3, 2))
    whole = replace(mesh, edge_tags=edge_tags)
    turned = replace(
        mesh, triangles=np.roll(mesh.triangles, 1, axis=1), edge_tags=np.roll(edge_tags, 1, axis=1)
    )
    expected, found = (draw(device, one, 4).result()[0] for one in (whole, turned))
    assert found.normals.tobytes() == expected.normals.tobytes()


def test_bad_tags_of_edges_are_refused(device):
    mesh = replace(icosphere(0), edge_tags=np.full((20, 3, 2), 1.5))
    with pytest.raises(ValueError, match=r"edge_tags: expected sharpness of 0 to 1, got 1\.5"):
        draw(device, mesh)


def ridge_normals(device, mesh=ROOF, **params):
    """Normals of the roof's two sides along its ridge, (2, segments + 1, 3), from its first end on."""
    mesh = mesh.with_normals()
    made = draw(device, mesh, 8, **params).result()[0].normals.reshape(2, -1, 3)
    i, j = lattice_rows(8)
    sides = []
    for k, triangle in enumerate(ROOF.triangles):
        turned = np.roll(
            triangle, -int(np.argmin(triangle))
        )  # instances begin at the lowest vertex
        along = j == 0 if turned[1] == 1 else i == j
        sides.append(made[k][along])
    return np.array(sides, float)


def between(sides):
    """Degrees between the two sides' normals, in the middle of the ridge."""
    a, b = sides[:, 4]
    return np.degrees(np.arccos(np.clip(a @ b, -1, 1)))


def test_sharpness_opens_the_angle_between_the_sides_of_an_edge(device):
    angles = [between(ridge_normals(device, sharpness=s)) for s in (0, 0.25, 0.5, 0.75, 1)]
    assert angles[0] == pytest.approx(0, abs=0.05)
    assert all(a < b for a, b in pairwise(angles))
    # at 1 both sides' mid-edge normals are those of their faces, and the ends' means with smooth edges pull little
    assert angles[-1] == pytest.approx(SLOPES, rel=0.05)


def test_bias_turns_both_sides_of_an_edge_the_same_way(device):
    upright, leaning, other = (ridge_normals(device, sharpness=1.0, bias=b) for b in (0, 0.5, -0.5))

    def turned(sides):
        angles = np.degrees(np.arctan2(sides[:, 4, 2], sides[:, 4, 0]))
        return angles - np.degrees(np.arctan2(upright[:, 4, 2], upright[:, 4, 0]))

    assert (turned(leaning) < -10).all()
    # the roof is its own mirror image, and leans to the other side there
    np.testing.assert_allclose(other[0], leaning[1] * (-1, 1, 1), atol=UNIT_LENGTH)


def test_full_tension_without_sharpness_is_flat(device):
    mesh = shaken(icosphere(1))
    tight = draw(device, mesh, 8, tension=1.0).result()[0]
    flat = pattern.Pattern(device, mesh, pattern.Params(8)).result()[0]
    np.testing.assert_allclose(tight.positions, flat.positions, atol=ROUNDING32)


def test_tension_below_zero_bulges_more(device):
    mesh = icosphere(0)
    volumes = []
    for tension in (1.0, 0.5, 0.0, -0.5):
        a, b, c = (
            (m := draw(device, mesh, 8, tension=tension).result()[0])
            .positions.astype(float)[m.triangles]
            .transpose(1, 0, 2)
        )
        volumes.append((a * np.cross(b, c)).sum() / 6)
    assert volumes == sorted(volumes)


def test_sharp_tags_flatten_the_middle_and_leave_the_edges(device):
    mesh = icosphere(0)
    smooth, sharp = (draw(device, mesh, 6, sharpness=s).result()[0].positions for s in (0.0, 1.0))
    i, j = lattice_rows(6)
    edge = np.tile((j == 0) | (i == j) | (i == 6), mesh.triangle_count)
    assert np.array_equal(smooth[edge], sharp[edge])
    inside = np.linalg.norm(sharp[~edge], axis=1) < np.linalg.norm(smooth[~edge], axis=1)
    assert inside.all()


def test_a_meshes_own_tags_come_before_those_of_the_params(device):
    mesh = random_tags(icosphere(1), 3)
    one, other = (draw(device, mesh, 4, tension=t).result()[0] for t in (0.0, 0.9))
    assert np.array_equal(one.positions, other.positions)


@pytest.mark.parametrize(
    ("tags", "text"),
    [
        (np.full((12, 3), -0.5), "tags: expected sharpness of 0 to 1, got -0.5 to -0.5"),
        (np.full((12, 3), 2.0), "tags: expected tension of -1 to 1, got 2 to 2"),
    ],
)
def test_bad_tags_are_refused(device, tags, text):
    mesh = replace(icosphere(0), tags=tags.astype(np.float32))
    with pytest.raises(ValueError, match=text):
        draw(device, mesh)


def test_degenerate_triangles_are_finite(device):
    points = [[0, 0, 0], [0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]]
    mesh = TriangleMesh(points, [[0, 1, 2], [0, 2, 3], [4, 4, 4], [0, 2, 4]])
    made = draw(device, mesh, 5, tension=-1.0, sharpness=0.7, bias=1.0).result()[0]
    assert np.isfinite(made.positions).all()
    assert np.abs(np.linalg.norm(made.normals, axis=1) - 1).max() < UNIT_LENGTH


def test_method_is_reached_by_its_name_with_its_options():
    smooth, tight = (
        refine(icosphere(0), segments=4, method="st_triangles", tension=t)[0] for t in (0.0, 1.0)
    )
    assert np.linalg.norm(tight, axis=1).min() < np.linalg.norm(smooth, axis=1).min()
